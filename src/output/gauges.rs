//! The file of a gauge: one row per reading.

use std::fmt::Write as _;
use std::path::Path;

use super::OutputError;
use super::rows::RowFile;
use crate::gauge::Reading;

/// Writes the readings of a gauge as CSV: `step`, `t_s`, and a column for each of its figures, which is empty if there
/// was no fluid to measure. Only complete rows are written to the file; buffered rows are written by
/// [`flush`](Self::flush) and on drop.
#[derive(Debug)]
pub struct GaugeFile(RowFile);

impl GaugeFile {
    /// Creates the file of a gauge with these [`columns`](crate::gauge::Gauge::columns); an existing file is replaced.
    ///
    /// # Errors
    /// If the operating system reports an error.
    pub fn create(path: &Path, columns: &[String]) -> Result<Self, OutputError> {
        Ok(Self(RowFile::start(path, &header(columns))?))
    }

    /// Continues the file of a gauge after its first `rows` rows, which are returned. If the file is missing or has
    /// other columns, a new one is created.
    ///
    /// # Errors
    /// If the operating system reports an error.
    pub fn resume(
        path: &Path,
        columns: &[String],
        rows: u64,
    ) -> Result<(Self, Vec<String>), OutputError> {
        let (file, kept) = RowFile::resume(path, &header(columns), rows)?;
        Ok((Self(file), kept))
    }

    /// Number of rows so far, buffered ones included.
    pub fn rows(&self) -> u64 {
        self.0.rows()
    }

    /// Adds a reading.
    ///
    /// # Errors
    /// If buffered rows cannot be written.
    pub fn push(&mut self, reading: &Reading) -> Result<(), OutputError> {
        self.0.push(|text| {
            // Writing to a String cannot fail.
            let _ = write!(text, "{},{}", reading.step, reading.time);
            for value in &reading.values {
                text.push(',');
                if let Some(value) = value {
                    let _ = write!(text, "{value:e}");
                }
            }
            text.push('\n');
        })
    }

    /// Writes the buffered rows.
    ///
    /// # Errors
    /// If the operating system reports an error, or the file was removed meanwhile. Complete rows stay; buffered ones
    /// are lost.
    pub fn flush(&mut self) -> Result<(), OutputError> {
        self.0.flush()
    }
}

fn header(columns: &[String]) -> String {
    format!("step,t_s,{}\n", columns.join(","))
}
