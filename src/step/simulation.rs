//! A scene in a world of its own.

use std::panic::{AssertUnwindSafe, catch_unwind, resume_unwind};

use bevy_ecs::prelude::*;

use super::{error::InstallError, install::install, report::StepReport, take::take_step};
use crate::{
    scene::Scene,
    state::{Clock, Execution, StepError},
};

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
    pub fn with_threads(scene: &Scene, threads: usize) -> Result<Self, InstallError> {
        let mut world = World::new();
        world.insert_resource(Execution::new(threads)?);
        install(&mut world, scene)?;
        Ok(Self { world })
    }

    /// As [`with_threads`](Self::with_threads), in a world that a host has prepared: with stages of its own
    /// ([`Stages`](crate::registry::Stages)), resources, systems. Its [`Execution`] is used if it has one.
    pub fn in_world(mut world: World, scene: &Scene) -> Result<Self, InstallError> {
        install(&mut world, scene)?;
        Ok(Self { world })
    }

    /// Takes one step. After an error the world holds the last good state.
    pub fn step(&mut self) -> Result<StepReport, StepError> {
        take_step(&mut self.world)
    }

    /// Takes one step that does not pass `until` \[s]: the last before it is shortened, and ends there exactly.
    pub fn step_until(&mut self, until: f64) -> Result<StepReport, StepError> {
        self.set_until(Some(until));
        // After a panic of a host's system the next step has its own length again.
        let taken = catch_unwind(AssertUnwindSafe(|| self.step()));
        self.set_until(None);
        taken.unwrap_or_else(|panic| resume_unwind(panic))
    }

    fn set_until(&mut self, until: Option<f64>) {
        // A host may have taken the clock away: then the step says so.
        if let Some(mut clock) = self.world.get_resource_mut::<Clock>() {
            clock.until = until;
        }
    }

    /// Simulated time \[s].
    pub fn time(&self) -> f64 {
        self.world.resource::<Clock>().time
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
