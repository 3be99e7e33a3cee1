//! `history.csv`: one row a step.

use std::fmt::Write as _;
use std::fs;
use std::io::ErrorKind;
use std::path::Path;

use super::OutputError;
use super::rows::RowFile;
use crate::{state::Phase, step::StepReport};

/// Columns before the phases; their names end in their SI unit where they have one.
const COLUMNS: [&str; 13] = [
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
    "mean_neighbours",
    "steps_taken_back",
];

/// Writes `history.csv`: a row a step, wall time of the phases in milliseconds (`rebuild_index_ms`, …).
///
/// `steps_taken_back` is 0 in the row of a step. Where the run went back (`time_step: Adaptive`) it is not, and the row
/// is of no step: `step` and `t_s` are those where the run stands again, the rest is of the step that went wrong. The
/// rows above it with a later `step` are of steps that were taken back; they stay, the rows below take their place.
///
/// Only whole rows ever go to the file: what an interruption leaves is valid. Rows that wait are written by
/// [`flush`](Self::flush) or when the history is dropped.
#[derive(Debug)]
pub struct History(RowFile);

impl History {
    /// Starts a history, over an older one if there is one.
    ///
    /// # Errors
    /// When the system refuses.
    pub fn create(path: &Path) -> Result<Self, OutputError> {
        Ok(Self(RowFile::start(path, &header())?))
    }

    /// Goes on with the history of a run that resumes after a step: the rows up to the last of that step stay. A
    /// missing file, or one with other columns, is started afresh.
    ///
    /// # Errors
    /// When the system refuses.
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

    /// Goes on with a history after its first `rows` rows. A missing file, or one with other columns, is started afresh.
    ///
    /// # Errors
    /// When the system refuses.
    pub fn resume_after_rows(path: &Path, rows: u64) -> Result<Self, OutputError> {
        Ok(Self(RowFile::resume(path, &header(), rows)?.0))
    }

    /// Rows so far, those included that wait.
    pub fn rows(&self) -> u64 {
        self.0.rows()
    }

    /// Adds the row of a step.
    ///
    /// # Errors
    /// When the system refuses to take the rows that wait.
    pub fn push(&mut self, report: &StepReport) -> Result<(), OutputError> {
        self.0.push(|text| push_row(text, report))
    }

    /// Writes the rows that wait.
    ///
    /// # Errors
    /// When the system refuses, or the file was removed meanwhile. Whole rows stay, and those that wait are lost.
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
        "{},{},{:e},{},{},{:e},{:e},{:e},{:e},{},{},{},{}",
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
