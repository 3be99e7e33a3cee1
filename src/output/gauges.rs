//! The file of a gauge: a row a reading.

use std::fmt::Write as _;
use std::path::Path;

use super::OutputError;
use super::rows::RowFile;
use crate::gauge::Reading;

/// Writes a gauge's readings as CSV: `step`, `t_s`, and a column for each of its figures, empty where there was no
/// fluid to measure. Only whole rows ever go to the file; rows that wait are written by [`flush`](Self::flush) or when
/// it is dropped.
#[derive(Debug)]
pub struct GaugeFile(RowFile);

impl GaugeFile {
    /// Starts the file of a gauge with these [`columns`](crate::gauge::Gauge::columns), over an older one if there is
    /// one.
    ///
    /// # Errors
    /// When the system refuses.
    pub fn create(path: &Path, columns: &[String]) -> Result<Self, OutputError> {
        Ok(Self(RowFile::start(path, &header(columns))?))
    }

    /// Goes on with a gauge's file after its first `rows` rows, and gives those. A missing file, or one with other
    /// columns, is started afresh.
    ///
    /// # Errors
    /// When the system refuses.
    pub fn resume(
        path: &Path,
        columns: &[String],
        rows: u64,
    ) -> Result<(Self, Vec<String>), OutputError> {
        let (file, kept) = RowFile::resume(path, &header(columns), rows)?;
        Ok((Self(file), kept))
    }

    /// Rows so far, those included that wait.
    pub fn rows(&self) -> u64 {
        self.0.rows()
    }

    /// Adds a reading.
    ///
    /// # Errors
    /// When the system refuses to take the rows that wait.
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

    /// Writes the rows that wait.
    ///
    /// # Errors
    /// When the system refuses, or the file was removed meanwhile. Whole rows stay, and those that wait are lost.
    pub fn flush(&mut self) -> Result<(), OutputError> {
        self.0.flush()
    }
}

fn header(columns: &[String]) -> String {
    format!("step,t_s,{}\n", columns.join(","))
}
