//! Selects the time step control of a scene.

use bevy_ecs::prelude::*;

use super::{adaptive, cfl::TimeStepControl, limits::StepLimits};
use crate::scene::{Scene, TimeStep};

/// Inserts the resources of the time step control, and returns the first time step \[s].
pub fn install(world: &mut World, scene: &Scene, limits: &StepLimits) -> f32 {
    match scene.time_step {
        TimeStep::Fixed(dt) => dt,
        TimeStep::Cfl(cfl) => {
            let (dt, control) = TimeStepControl::new(cfl, scene, limits);
            world.insert_resource(control);
            dt
        }
        TimeStep::Adaptive(scheme) => {
            let (dt, control) = adaptive::start(scheme, scene, limits);
            world.insert_resource(control);
            dt
        }
    }
}
