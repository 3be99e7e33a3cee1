//! The stages that an order may name, and their requirements for a scene.

use bevy_ecs::prelude::*;

use super::{advance, columns::columns, gather};
use crate::{
    boundary::moving,
    flow, force,
    lattice::Lattice,
    neighbours,
    pressure::stages as pressure,
    reorder,
    scene::Scene,
    state::{Limit, Stage},
    time_step::{StepLimits, motion_limits},
};

/// The engine's stages, in the order in which they run by default.
const STAGES: &[Stage] = &[
    gather::STAGE,
    moving::STAGE,
    neighbours::INDEX,
    neighbours::STAGE,
    pressure::DENSITY,
    pressure::DIVERGENCE,
    force::CLEAR_FORCES,
    force::GRAVITY,
    force::BODY_FORCES,
    force::VISCOSITY,
    force::SURFACE_TENSION,
    pressure::PRESSURE,
    advance::STAGE,
    reorder::STAGE,
    flow::OUTFLOW,
    flow::EMIT,
];

/// The stages that an order may name: the engine's, and those that a host registers before it installs a scene.
#[derive(Resource, Debug, Clone)]
pub struct Stages(Vec<Stage>);

/// Why a stage cannot be registered.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum StageError {
    /// Another stage has its name.
    #[error("there is a stage called `{name}` already; choose another name")]
    NameIsTaken {
        /// The name.
        name: &'static str,
    },
    /// An order could not name it.
    #[error("a stage needs a name of letters, digits and underscores; `{name}` is none")]
    NoName {
        /// The name.
        name: &'static str,
    },
}

impl Default for Stages {
    fn default() -> Self {
        Self(STAGES.to_vec())
    }
}

impl Stages {
    /// Adds a stage of a host's. An order runs it where it names it; one that does not name it is refused as long as
    /// the stage is [`wanted`](Stage::wanted).
    pub fn register(&mut self, stage: Stage) -> Result<(), StageError> {
        let name = stage.name;
        let is_name = |name: &str| name.chars().all(|c| c.is_alphanumeric() || c == '_');
        if name.is_empty() || !is_name(name) {
            return Err(StageError::NoName { name });
        }
        if self.find(name).is_some() {
            return Err(StageError::NameIsTaken { name });
        }
        self.0.push(stage);
        Ok(())
    }

    /// The stage of a name.
    pub fn find(&self, name: &str) -> Option<&Stage> {
        self.iter().find(|stage| stage.name == name)
    }

    /// All stages.
    pub fn iter(&self) -> impl Iterator<Item = &Stage> {
        self.0.iter()
    }

    /// Limits on the time step of a scene that do not change in a run.
    pub fn constant_limits(&self, scene: &Scene) -> Vec<Limit> {
        let wanted = self.iter().filter(|stage| (stage.wanted)(scene));
        wanted.flat_map(|stage| (stage.limits)(scene)).collect()
    }

    /// Limits that a run is under from its first step on: those that never change, gravity, and the speed at the start,
    /// with which nothing may move more than h/2.
    pub(crate) fn certain_limits(&self, scene: &Scene) -> Vec<Limit> {
        let h = scene.support_radius();
        let mut limits = self.constant_limits(scene);
        let gravity = scene.gravity.length();
        let [speed, force] = motion_limits(0.5, h, scene.max_initial_speed(), gravity);
        limits.push(("gravity", force.1));
        if !scene.body_forces.is_empty() {
            let greatest = scene.greatest_acceleration();
            limits.push((
                "gravity and body forces",
                motion_limits(0.5, h, 0.0, greatest)[1].1,
            ));
        }
        limits.push(("the speed at the start", speed.1));
        limits.retain(|limit| limit.1.is_finite());
        limits
    }

    /// What the control of a scene's time step knows of its physics.
    pub(crate) fn step_limits(&self, scene: &Scene) -> StepLimits {
        let constant = self.constant_limits(scene).into_iter().map(|limit| limit.1);
        let iterations = scene.pressure.iterations();
        StepLimits {
            constant: constant.fold(f32::INFINITY, f32::min),
            pressure_step: match iterations {
                Some(_) => Lattice::of(scene).pressure_step() as f32,
                None => f32::INFINITY,
            },
            momentum: iterations.map(|iterations| iterations.momentum),
        }
    }

    /// Memory of a scene's fluid by what holds it, for so many neighbours of a particle \[bytes per particle].
    pub(crate) fn bytes(&self, scene: &Scene, neighbours: f32) -> Vec<(&'static str, f64)> {
        let columns = columns(scene).map(|column| (column.name, column.bytes as f64));
        let wanted = self.iter().filter(|stage| (stage.wanted)(scene));
        columns
            .chain(wanted.flat_map(|stage| (stage.bytes)(scene, neighbours)))
            .collect()
    }
}
