//! A scene in a world of its own.

use std::panic::{AssertUnwindSafe, catch_unwind, resume_unwind};

use bevy_ecs::prelude::*;
use glam::Vec3;

use super::{
    advance::{Advance, advance},
    error::InstallError,
    install::install,
    report::StepReport,
    take::take_step,
};
use crate::{
    gauge::{self, Field, Interpolated, Neighbour, Snapshot, SnapshotError, Target},
    scene::Scene,
    state::{Clock, Execution, Rows, StepError},
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
        world.insert_resource(Execution::new(threads).map_err(InstallError::Threads)?);
        install(&mut world, scene)?;
        Ok(Self { world })
    }

    /// As [`with_threads`](Self::with_threads), in a world that the host has prepared with its own stages
    /// ([`Stages`](crate::registry::Stages)), resources and systems. An [`Execution`] that the world already has is
    /// used.
    pub fn in_world(mut world: World, scene: &Scene) -> Result<Self, InstallError> {
        install(&mut world, scene)?;
        Ok(Self { world })
    }

    /// Takes one step. After an error the world holds the last good state.
    pub fn step(&mut self) -> Result<StepReport, StepError> {
        // Bevy notes every component that is removed and keeps the notes until they are cleared.
        self.world.clear_trackers();
        take_step(&mut self.world)
    }

    /// Takes one step that does not pass the time `until` \[s]: if it would, it is shortened to end exactly there.
    pub fn step_until(&mut self, until: f64) -> Result<StepReport, StepError> {
        self.set_until(Some(until));
        // The limit is removed even after a panic of a host's system, so that the next step has its normal length.
        let taken = catch_unwind(AssertUnwindSafe(|| self.step()));
        self.set_until(None);
        taken.unwrap_or_else(|panic| resume_unwind(panic))
    }

    /// Takes the whole steps that fit into a frame of `seconds` and keeps the remainder: see [`advance`].
    pub fn advance(&mut self, seconds: f64) -> Result<Advance, StepError> {
        advance(&mut self.world, seconds)
    }

    /// A snapshot of the current fluid, for queries at many points.
    pub fn snapshot(&self) -> Result<Snapshot, SnapshotError> {
        Snapshot::of(&self.world)
    }

    /// Fluid particles within the support radius h of a point \[m] or of an entity, the nearest first. Takes a
    /// [`snapshot`](Self::snapshot) for each call.
    pub fn neighbours_of(&self, of: impl Into<Target>) -> Result<Vec<Neighbour>, SnapshotError> {
        gauge::neighbours_of(&self.world, of.into())
    }

    /// [`Pressure`](crate::particle::Pressure), [`Density`](crate::particle::Density) or
    /// [`Velocity`](crate::particle::Velocity) at points \[m]. Takes a [`snapshot`](Self::snapshot) for each call.
    ///
    /// ```
    /// use overfall::{Simulation, particle::Pressure, scene::{BoundaryShape, FluidBody, Scene, Shape}};
    ///
    /// let scene = Scene {
    ///     bodies: vec![FluidBody::new(Shape::cuboid([0.0; 3], [0.5, 0.5, 0.5]))],
    ///     boundaries: vec![BoundaryShape::tank([0.0; 3], [0.5, 1.0, 0.5])],
    ///     ..Scene::new("pool", 0.1)
    /// };
    /// let mut simulation = Simulation::new(&scene).expect("threads");
    /// simulation.advance(0.02).expect("steps");
    /// let points = [[0.25, 0.1, 0.25].into(), [0.25, 5.0, 0.25].into()];
    /// let found = simulation.interpolate::<Pressure>(&points).expect("a scene");
    /// assert!(found[0].value.is_some() && found[0].neighbours > 10);
    /// assert!(found[1].value.is_none() && found[1].neighbours == 0);
    /// ```
    pub fn interpolate<F: Field>(
        &self,
        points: &[Vec3],
    ) -> Result<Vec<Interpolated<F>>, SnapshotError> {
        Ok(self.snapshot()?.interpolate(points))
    }

    /// The particle in a row of the last step's columns.
    pub fn entity_of(&self, row: usize) -> Option<Entity> {
        self.world.get_resource::<Rows>()?.entity_of(row)
    }

    /// The row of a particle in the last step's columns.
    pub fn row_of(&self, particle: Entity) -> Option<usize> {
        self.world.get_resource::<Rows>()?.row_of(particle)
    }

    fn set_until(&mut self, until: Option<f64>) {
        // If a host removed the clock, the step itself reports that.
        if let Some(mut clock) = self.world.get_resource_mut::<Clock>() {
            clock.until = until;
        }
    }

    /// Simulated time \[s]; 0 if a host has uninstalled the scene.
    pub fn time(&self) -> f64 {
        let clock = self.world.get_resource::<Clock>();
        clock.map_or(0.0, |clock| clock.time)
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
