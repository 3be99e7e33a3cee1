//! `history.csv`: one row per step.

use std::fmt::Write as _;
use std::fs;
use std::io::ErrorKind;
use std::path::Path;

use super::OutputError;
use super::rows::RowFile;
use crate::{state::Phase, step::StepReport};

/// Columns before those of the phases; a name ends with its SI unit if it has one.
const COLUMNS: [&str; 15] = [
    "step",
    "t_s",
    "dt_s",
    "iterations",
    "divergence_iterations",
    "max_density_error",
    "mean_density_error",
    "kinetic_energy_J",
    "potential_energy_J",
    "max_speed_m_per_s",
    "particles",
    "particles_emitted",
    "particles_removed",
    "mean_neighbours",
    "steps_taken_back",
];

/// Writes `history.csv`: one row per step, with the wall time of the phases in milliseconds (`rebuild_index_ms`, …).
///
/// `steps_taken_back` is 0 in the row of a normal step. Otherwise the run was rolled back (`time_step: Adaptive`):
/// `step` and `t_s` are those of the restored state, the other columns are those of the failed attempt. Earlier rows
/// with a larger `step` belong to steps that were rolled back; they stay, and later rows replace them.
///
/// Only complete rows are written to the file, so that an interruption leaves a valid file. Buffered rows are written
/// by [`flush`](Self::flush) and on drop.
#[derive(Debug)]
pub struct History(RowFile);

impl History {
    /// Creates a history; an existing file is replaced.
    ///
    /// # Errors
    /// If the operating system reports an error.
    pub fn create(path: &Path) -> Result<Self, OutputError> {
        Ok(Self(RowFile::start(path, &header())?))
    }

    /// Continues the history of a run that resumes after a step: the rows up to the last one of that step stay. If the
    /// file is missing or has other columns, a new one is created.
    ///
    /// # Errors
    /// If the operating system reports an error.
    pub fn resume(path: &Path, after_step: u64) -> Result<Self, OutputError> {
        let old = match fs::read_to_string(path) {
            Ok(old) => old,
            Err(e) if e.kind() == ErrorKind::NotFound => String::new(),
            Err(e) => return Err(OutputError::io(path, e)),
        };
        let mut kept = header();
        if let Some(rows) = old.strip_prefix(&header()) {
            let rows = rows.split_inclusive('\n').filter(|row| row.ends_with('\n'));
            let rows: Vec<_> = rows.map_while(|row| Some((step_of(row)?, row))).collect();
            let last = rows.iter().rposition(|&(step, _)| step <= after_step);
            let stay = &rows[..last.map_or(0, |last| last + 1)];
            stay.iter().for_each(|(_, row)| kept.push_str(row));
        }
        Ok(Self(RowFile::start(path, &kept)?))
    }

    /// Continues a history after its first `rows` rows. If the file is missing or has other columns, a new one is
    /// created.
    ///
    /// # Errors
    /// If the operating system reports an error.
    pub fn resume_after_rows(path: &Path, rows: u64) -> Result<Self, OutputError> {
        Ok(Self(RowFile::resume(path, &header(), rows)?.0))
    }

    /// Number of rows so far, buffered ones included.
    pub fn rows(&self) -> u64 {
        self.0.rows()
    }

    /// Adds the row of a step.
    ///
    /// # Errors
    /// If buffered rows cannot be written.
    pub fn push(&mut self, report: &StepReport) -> Result<(), OutputError> {
        self.0.push(|text| push_row(text, report))
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

fn header() -> String {
    let mut header = COLUMNS.join(",");
    for phase in Phase::ALL {
        header.push(',');
        header.push_str(phase.name());
        header.push_str("_ms");
    }
    header.push('\n');
    header
}

fn push_row(text: &mut String, r: &StepReport) {
    // Writing to a String cannot fail.
    let _ = write!(
        text,
        "{},{},{:e},{},{},{:e},{:e},{:e},{:e},{},{},{},{},{},{}",
        r.step,
        r.time,
        r.dt,
        r.iterations,
        r.divergence_iterations,
        r.max_density_error,
        r.mean_density_error,
        r.kinetic_energy,
        r.potential_energy,
        r.max_speed,
        r.particles,
        r.emitted,
        r.removed,
        r.mean_neighbours,
        r.taken_back
            .as_ref()
            .map_or(0, |taken_back| taken_back.steps),
    );
    for seconds in r.phase_seconds {
        let _ = write!(text, ",{:.4}", seconds * 1e3);
    }
    text.push('\n');
}

fn step_of(row: &str) -> Option<u64> {
    row.split(',').next()?.parse().ok()
}
