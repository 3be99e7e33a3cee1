//! The initial pressure of a scene, solved once before the first step.
//!
//! A start without pressure is a shock: water falls until its weight reaches the floor, row by row, and is thrown back
//! (1.7 to 7.8 m/s in 80 to 240 rows that should be at rest). If steps start from earlier pressures, the first step
//! therefore starts from pressures that prevent compression, computed with the iteration of
//! [`implicit`](super::implicit) for every method.

use bevy_ecs::{prelude::*, schedule::ScheduleLabel, system::RunSystemOnce};
use glam::Vec4;

use super::{
    convergence::Convergence,
    density_rate::PredictedVelocities,
    implicit::store_pressures,
    iterate::{End, iterate},
    warm_start,
};
use crate::{
    scene::{Criterion, NotConverged, Scene},
    state::{Accelerations, Clock, Positions},
    time_step::{RecoveryTime, remember_first_pressure, shorten_first_step},
};

/// One iteration of the solve.
#[derive(ScheduleLabel, Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct InitialIteration;

/// Fraction of the gravity that may remain in the first step \[-].
const UNCARRIED: f32 = 1e-3;

/// Iterations within which the error must fall.
const PATIENCE: u32 = 100;

/// A column of 240 rows needs 400.
const MAX_ITERATIONS: u32 = 2000;

/// Whether a scene starts from a pressure that is solved for.
pub(crate) fn is_solved_for(scene: &Scene) -> bool {
    scene.pressure.solver().solves_initial_pressure()
}

/// Whether this is the first step.
pub(crate) fn is_first_step(clock: Res<Clock>) -> bool {
    clock.step == 0
}

/// Solves for the pressure (phase `Pressure`, before the method, in the first step). A method that `is_linear` starts
/// from the pressure that keeps all gaps, and in a step that this pressure allows. PCISPH would take the shock of a
/// wall that starts at a speed for pressure that lasts.
pub fn solve_initial_pressure(world: &mut World, is_linear: bool) {
    let dt = world.resource::<Clock>().dt;
    let Some(limit) = limit(world, dt) else {
        return;
    };
    let recovery = world.remove_resource::<RecoveryTime>();
    let convergence = Convergence {
        max_density_error: limit,
        mean_density_error: None,
        criterion: Criterion::Mean,
        min_iterations: 3,
        max_iterations: MAX_ITERATIONS,
        not_converged: NotConverged::Accept,
    };
    // A closed tank full of fluid may have no pressure that keeps all gaps: what its walls drive in has to go
    // somewhere.
    let attempts: &[bool] = if is_linear { &[true, false] } else { &[false] };
    for &keeps_gaps in attempts {
        world.insert_resource(RecoveryTime::never(keeps_gaps));
        warm_start::start(world, 0.0);
        if iterate(world, InitialIteration, &convergence, PATIENCE) == End::Converged {
            break;
        }
    }
    // Systems that read and write plain columns cannot fail.
    let _ = world.run_system_once(store_pressures);
    let _ = world.run_system_once(remember_first_pressure);
    if is_linear {
        let _ = world.run_system_once(shorten_first_step);
    }
    match recovery {
        Some(recovery) => world.insert_resource(recovery),
        None => {
            world.remove_resource::<RecoveryTime>();
        }
    }
    // PCISPH does not need this resource afterwards.
    world.resource_mut::<PredictedVelocities>().0 = Vec::new();
}

/// Mean compression \[-] of a step in which the fluid falls with the part [`UNCARRIED`] of the largest acceleration
/// over its whole extent; none if there is no acceleration.
fn limit(world: &World, dt: f32) -> Option<f32> {
    let positions = world.resource::<Positions>().points();
    let corners = (Vec4::INFINITY, Vec4::NEG_INFINITY);
    let (low, high) = positions
        .iter()
        .fold(corners, |(low, high), x| (low.min(*x), high.max(*x)));
    let extent = (high - low).truncate().max_element();
    let accelerations = world.resource::<Accelerations>().0.iter();
    let pull = accelerations
        .fold(0.0_f32, |most, a| most.max(a.length_squared()))
        .sqrt();
    let limit = UNCARRIED * dt * dt * pull / extent;
    (limit > 0.0 && limit.is_finite()).then_some(limit)
}
