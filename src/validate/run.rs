//! A simulation that a case observes.

use std::ops::ControlFlow;

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

/// A simulation that a case observes.
pub struct Runner<'a> {
    simulation: Simulation,
    /// Gets the completed fraction of the run, 0 to 1; may stop it.
    tell: &'a mut dyn FnMut(f64) -> ControlFlow<()>,
}

impl<'a> Runner<'a> {
    pub(super) fn new(
        simulation: Simulation,
        tell: &'a mut dyn FnMut(f64) -> ControlFlow<()>,
    ) -> Self {
        Self { simulation, tell }
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
            let report = self.simulation.step().map_err(|error| Stopped::Failed {
                time: self.simulation.time(),
                error,
            })?;
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
