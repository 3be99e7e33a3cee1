//! The time step that follows the motion of the fluid.

use bevy_ecs::prelude::*;

use super::limits::{StepLimits, motion_limits, pressure_limit};
use crate::{
    integrate::Motion,
    scene::{Cfl, Scene},
    state::{Clock, Material, SolverState},
};

/// Maximum growth of the time step between steps \[-], so that it recovers slowly after an impact.
const GROWTH: f32 = 1.1;

/// Number of pressure iterations above which the next step is shorter. The cost of an iteration is constant, and the
/// number of iterations grows faster than the length of a step. A step whose error does not decrease is halved before
/// particles move.
///
/// Tuned on: a dam break with 10, 20, 30 and 50. PCISPH: equal work, smaller density errors with short steps. IISPH and
/// DFSPH with momentum: 10 % less work from 20 on.
pub(super) const ITERATIONS: u32 = 10;
const ITERATIONS_WITH_MOMENTUM: u32 = 20;
const SHRINKAGE: f32 = 0.9;

/// The control of a scene with `Cfl`.
#[derive(Resource, Debug, Clone, Copy, PartialEq)]
pub struct TimeStepControl {
    cfl: Cfl,
    /// Number of pressure iterations above which the next step is shorter.
    iterations: u32,
    /// Limit by viscosity and sound \[s]: constant in a run.
    constant_limit: f32,
    /// Number of spacings that `sqrt(p/ρ)` covers in the longest step that pressure allows \[-]. Infinite with an
    /// equation of state, whose sound is faster.
    pressure_step: f32,
}

impl TimeStepControl {
    /// The first time step \[s] of a scene, and the control of the next ones.
    pub(super) fn new(cfl: Cfl, scene: &Scene, limits: &StepLimits) -> (f32, Self) {
        let control = Self {
            cfl,
            iterations: match limits.momentum {
                Some(true) => ITERATIONS_WITH_MOMENTUM,
                _ => ITERATIONS,
            },
            constant_limit: limits.constant,
            pressure_step: limits.pressure_step,
        };
        let dt = control.choose(
            scene.support_radius(),
            scene.max_initial_speed(),
            scene.greatest_acceleration(),
            f32::INFINITY,
        );
        (dt, control)
    }

    /// Half a time step \[s], if the scene allows it.
    pub fn shorter(&self, dt: f32) -> Option<f32> {
        (0.5 * dt >= self.cfl.min).then_some(0.5 * dt)
    }

    /// Longest step \[s] under a pressure \[Pa], not below the scene's shortest.
    pub(super) fn longest_under(&self, material: &Material, pressure: f32) -> f32 {
        pressure_limit(self.pressure_step, material, pressure).max(self.cfl.min)
    }

    fn choose(&self, h: f32, max_speed: f32, max_acceleration: f32, longest: f32) -> f32 {
        let motion = motion_limits(self.cfl.factor, h, max_speed, max_acceleration);
        motion
            .iter()
            .fold(self.constant_limit.min(longest), |least, limit| {
                least.min(limit.1)
            })
            .clamp(self.cfl.min, self.cfl.max)
    }
}

/// Chooses the length of the next step (phase `Integrate`; with `Cfl` only).
pub fn choose_time_step(
    mut clock: ResMut<Clock>,
    control: Res<TimeStepControl>,
    motion: Res<Motion>,
    solve: Res<SolverState>,
    material: Res<Material>,
) {
    let h = material.kernel.support_radius;
    let change = if solve.iterations > control.iterations {
        SHRINKAGE
    } else {
        GROWTH
    };
    let pressure = pressure_limit(control.pressure_step, &material, motion.max_pressure);
    let longest = (change * clock.full_dt()).min(pressure);
    clock.next_dt = control.choose(h, motion.max_speed, motion.max_acceleration, longest);
}
