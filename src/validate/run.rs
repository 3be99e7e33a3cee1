//! A simulation that a case observes.

use std::ops::ControlFlow;
use std::time::Instant;

use bevy_ecs::prelude::*;

use crate::{Simulation, StepError, StepReport, gauge::Gauges};

/// Why a run ended early.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Stopped {
    /// The caller stopped it.
    #[error("it was interrupted")]
    Asked,
    /// A step failed.
    #[error("it stopped at {time:.4} s: {error}")]
    Failed {
        /// Simulated time of the last good state \[s].
        time: f64,
        /// Reason.
        error: StepError,
    },
    /// The scene is refused at this resolution, or with this method.
    #[error("{0}")]
    Refused(String),
}

/// What the steps of a run took.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Spent {
    /// Steps taken.
    pub steps: u64,
    /// Simulated time \[s].
    pub time: f64,
    /// Wall time of the steps, without what the case does between them \[s].
    pub wall: f64,
    /// Pressure iterations.
    pub iterations: u64,
    /// Sum of the steps' mean density errors \[-].
    pub mean_density_errors: f64,
    /// Largest density error of a step \[-].
    pub largest_density_error: f64,
}

impl Spent {
    fn add(&mut self, report: &StepReport, wall: f64) {
        self.wall += wall;
        (self.steps, self.time) = (report.step, report.time);
        self.iterations += u64::from(report.iterations);
        if report.taken_back.is_none() {
            self.mean_density_errors += f64::from(report.mean_density_error);
            let largest = f64::from(report.max_density_error);
            self.largest_density_error = self.largest_density_error.max(largest);
        }
    }
}

/// A simulation that a case observes.
pub struct Runner<'a> {
    simulation: Simulation,
    spent: Spent,
    /// Gets the completed fraction of the run, 0 to 1; may stop it.
    tell: &'a mut dyn FnMut(f64) -> ControlFlow<()>,
}

impl<'a> Runner<'a> {
    pub(crate) fn new(
        simulation: Simulation,
        tell: &'a mut dyn FnMut(f64) -> ControlFlow<()>,
    ) -> Self {
        Self {
            simulation,
            spent: Spent::default(),
            tell,
        }
    }

    /// What the steps so far took.
    pub fn spent(&self) -> Spent {
        self.spent
    }

    /// The world before the first step, and between two.
    pub fn world(&mut self) -> &mut World {
        self.simulation.world_mut()
    }

    /// Takes steps until `end` \[s]; `see` gets the world and the report after every step.
    pub fn steps(
        &mut self,
        end: f64,
        mut see: impl FnMut(&mut World, &StepReport),
    ) -> Result<(), Stopped> {
        while self.simulation.time() < end {
            let started = Instant::now();
            let taken = self.simulation.step();
            let wall = started.elapsed().as_secs_f64();
            let report = taken.map_err(|error| Stopped::Failed {
                time: self.simulation.time(),
                error,
            })?;
            self.spent.add(&report, wall);
            see(self.simulation.world_mut(), &report);
            if (self.tell)((report.time / end).min(1.0)).is_break() {
                return Err(Stopped::Asked);
            }
        }
        Ok(())
    }

    /// Times \[s] and figures of a gauge's column, without readings that have no figure.
    pub fn readings(&self, gauge: &str, column: &str) -> Vec<(f64, f64)> {
        let gauges = self.simulation.world().get_resource::<Gauges>();
        let Some(gauge) = gauges.and_then(|gauges| gauges.get(gauge)) else {
            return Vec::new();
        };
        let Some(column) = gauge.columns().iter().position(|name| name == column) else {
            return Vec::new();
        };
        let readings = gauge.readings();
        readings
            .filter_map(|reading| Some((reading.time, reading.values[column]?)))
            .collect()
    }
}
