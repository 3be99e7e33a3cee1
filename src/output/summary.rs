//! `summary.json`: a run and its results.

use std::collections::BTreeMap;
use std::fs;
use std::io::Write as _;
use std::path::Path;

use serde::{Deserialize, Serialize};

use super::atomic::write_atomically;
use super::{OutputError, Provenance};
use crate::input::read_bytes;
use crate::{state::Phase, step::StepReport};

/// Version of the layout of `summary.json`, increased when a field changes its meaning or is removed.
pub const OUTPUT_VERSION: u32 = 1;

/// How a run ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Status {
    /// It reached its end.
    #[default]
    Done,
    /// It was interrupted.
    Interrupted,
    /// A step failed.
    Failed,
}

/// Content of `summary.json`.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct Summary {
    /// [`OUTPUT_VERSION`] of the writer.
    pub output_version: u32,
    /// Name of the scene.
    pub scene: String,
    /// How the run ended.
    pub status: Status,
    /// Why the run failed, if it did.
    pub failure: Option<String>,
    /// Fluid particles at the end.
    pub particles: usize,
    /// Particles that emitters added since the start.
    #[serde(default)]
    pub particles_emitted: u64,
    /// Particles that did not enter, because other fluid was in their places behind the face of an emitter.
    #[serde(default)]
    pub particles_without_place: u64,
    /// Particles that were removed since the start, by outflow or outside the domain.
    #[serde(default)]
    pub particles_removed: u64,
    /// Boundary particles.
    pub boundary_particles: usize,
    /// Threads of the data-parallel loops.
    pub threads: usize,
    /// The SIMD path that was used.
    pub instruction_set: String,
    /// Steps of this run, without those that were rolled back.
    pub steps: u64,
    /// Number of roll-backs (`time_step: Adaptive`).
    #[serde(default)]
    pub roll_backs: u64,
    /// Steps that were rolled back, failed attempts included. Their cost is part of the means.
    #[serde(default)]
    pub steps_taken_back: u64,
    /// Frames written.
    pub frames: u64,
    /// Simulated time at the end \[s].
    pub simulated_s: f64,
    /// Wall time of the run, output included \[s].
    pub wall_s: f64,
    /// Where the wall time went \[s], by what took it. What the writer of frames does runs beside the steps.
    #[serde(default)]
    pub wall_s_by_part: BTreeMap<String, f64>,
    /// Program, machine, date and command line.
    #[serde(default)]
    pub provenance: Provenance,
    /// Mean wall time per step \[ms]: of all its phases, unless the caller measured around them.
    pub ms_per_step: f64,
    /// Mean wall time of each phase per step \[ms].
    pub ms_per_phase: BTreeMap<String, f64>,
    /// Mean number of pressure iterations per step \[-].
    pub mean_iterations: f64,
    /// Largest density error in all steps \[-].
    pub max_density_error: f32,
    /// Mean density error, averaged over the steps \[-].
    pub mean_density_error: f64,
    /// Peak memory of the process \[bytes]; `None` if the system does not report it.
    pub peak_rss_bytes: Option<u64>,
}

impl Summary {
    /// Writes the summary, atomically.
    ///
    /// # Errors
    /// If the operating system reports an error.
    pub fn write(&self, path: &Path) -> Result<(), OutputError> {
        write_atomically(path, |out| {
            serde_json::to_writer_pretty(&mut *out, self)?;
            out.write_all(b"\n")
        })
    }

    /// Reads a summary.
    ///
    /// # Errors
    /// If the file cannot be read or is not a summary of this version.
    pub fn read(path: &Path) -> Result<Self, OutputError> {
        let bytes = read_bytes(path).map_err(|source| OutputError::io(path, source))?;
        let summary: Self = serde_json::from_slice(&bytes)
            .map_err(|e| OutputError::malformed(path, e.to_string()))?;
        if summary.output_version != OUTPUT_VERSION {
            return Err(OutputError::malformed(
                path,
                format!(
                    "output version {}, this program reads {OUTPUT_VERSION}",
                    summary.output_version
                ),
            ));
        }
        Ok(summary)
    }
}

/// Sums over the steps of a run, for the means in its summary.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
pub struct RunTotals {
    steps: u64,
    iterations: u64,
    time: f64,
    particles: usize,
    emitted: u64,
    without_place: u64,
    removed: u64,
    roll_backs: u64,
    steps_taken_back: u64,
    errors: Errors,
    /// Of all steps except the last, which may be rolled back.
    errors_before: Errors,
    phase_seconds: [f64; Phase::ALL.len()],
}

/// Density errors of the steps.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
struct Errors {
    largest: f32,
    mean_sum: f64,
}

impl RunTotals {
    /// Adds a step, or removes steps that were rolled back.
    pub fn add(&mut self, report: &StepReport) {
        self.iterations += u64::from(report.iterations);
        self.time = report.time;
        self.particles = report.particles;
        (self.emitted, self.removed) = (report.emitted, report.removed);
        self.without_place = report.without_place;
        if let Some(taken_back) = &report.taken_back {
            self.roll_backs += 1;
            self.steps_taken_back += u64::from(taken_back.steps);
            // The step that failed was never added.
            if taken_back.steps > 1 {
                self.steps -= u64::from(taken_back.steps - 1).min(self.steps);
                self.errors = self.errors_before;
            }
        } else {
            self.steps += 1;
            self.errors_before = self.errors;
            self.errors.largest = self.errors.largest.max(report.max_density_error);
            self.errors.mean_sum += f64::from(report.mean_density_error);
        }
        for (sum, seconds) in self.phase_seconds.iter_mut().zip(report.phase_seconds) {
            *sum += seconds;
        }
    }

    /// Steps that were added and not rolled back.
    pub fn steps(&self) -> u64 {
        self.steps
    }

    /// A summary with all values that follow from the steps, and [`peak_rss_bytes`]. The caller adds the rest: `Summary
    /// { scene, threads, …, ..totals.summary() }`.
    pub fn summary(&self) -> Summary {
        let mean = |sum: f64| sum / self.steps.max(1) as f64;
        let phases = Phase::ALL.iter().zip(self.phase_seconds);
        Summary {
            output_version: OUTPUT_VERSION,
            particles: self.particles,
            particles_emitted: self.emitted,
            particles_without_place: self.without_place,
            particles_removed: self.removed,
            steps: self.steps,
            roll_backs: self.roll_backs,
            steps_taken_back: self.steps_taken_back,
            simulated_s: self.time,
            ms_per_step: 1e3 * mean(self.phase_seconds.iter().sum()),
            ms_per_phase: phases
                .map(|(phase, seconds)| (phase.name().to_owned(), 1e3 * mean(seconds)))
                .collect(),
            mean_iterations: mean(self.iterations as f64),
            max_density_error: self.errors.largest,
            mean_density_error: mean(self.errors.mean_sum),
            peak_rss_bytes: peak_rss_bytes(),
            ..Summary::default()
        }
    }
}

/// Peak memory of this process \[bytes], if the system reports it (Linux).
pub fn peak_rss_bytes() -> Option<u64> {
    let status = fs::read_to_string("/proc/self/status").ok()?;
    let line = status
        .lines()
        .find_map(|line| line.strip_prefix("VmHWM:"))?;
    let kilobytes: u64 = line.trim().strip_suffix("kB")?.trim().parse().ok()?;
    kilobytes.checked_mul(1024)
}
