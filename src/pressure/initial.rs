//! The initial pressure of a scene, solved once before the first step.
//!
//! A start without pressure is a shock: water falls until its weight reaches the floor, row by row, and is thrown back
//! (1.7 to 7.8 m/s in 80 to 240 rows that should be at rest). If steps start from earlier pressures, the first step
//! therefore starts from pressures that prevent compression, computed with the iteration of
//! [`implicit`](super::implicit) for every method.

use std::mem;

use bevy_ecs::{prelude::*, schedule::ScheduleLabel, system::RunSystemOnce};
use glam::{Vec3, Vec4};

use super::{
    convergence::Convergence,
    density_rate::{DensityRates, PredictedVelocities, predict_rates},
    force::pressure_force,
    implicit::{self, predict_velocities, store_pressures, update_pressure},
    iterate::{End, iterate},
    warm_start,
};
use crate::{
    boundary::moving::move_walls_less,
    scene::{Criterion, NotConverged, Scene},
    state::{
        Accelerations, Clock, Execution, Material, Positions, PredictedPositions,
        PressureAccelerations, SENTINEL, Systems, Velocities, wants_force,
    },
    time_step::{RecoveryTime, remember_first_pressure, shorten_first_step},
};

/// One iteration of the solve.
#[derive(ScheduleLabel, Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct InitialIteration;

/// Dρ/Dt of the velocities that the scene starts with \[kg/(m³ s)], while it does not count.
#[derive(Resource, Debug, Default)]
pub struct StartingRates(Vec<f32>);

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

/// The systems of one iteration, in their order.
pub(super) fn iteration(is_linear: bool) -> Systems {
    if is_linear {
        return implicit::iteration();
    }
    (
        pressure_force.run_if(wants_force),
        predict_velocities,
        predict_rates,
        leave_out_starting_rates,
        update_pressure,
    )
        .chain()
}

/// The velocities that the scene starts with, without any acceleration.
fn predict_starting_velocities(
    mut predicted: ResMut<PredictedVelocities>,
    velocities: Res<Velocities>,
    accelerations: Res<PressureAccelerations>,
    execution: Res<Execution>,
) {
    predicted.write(&velocities, &accelerations, &execution, |_, _| Vec3::ZERO);
}

fn leave_out_starting_rates(
    mut rates: ResMut<DensityRates>,
    starting: Res<StartingRates>,
    execution: Res<Execution>,
) {
    execution.for_each_chunk(&mut rates.0, |first, rates| {
        for (rate, starting) in rates.iter_mut().zip(&starting.0[first..]) {
            *rate -= starting;
        }
    });
}

/// Solves for the pressure that keeps all gaps (phase `Pressure`, before the method, in the first step), and shortens
/// the step to what it allows. Methods that are not `is_linear` would take the shock of a wall that starts at a speed
/// for pressure that lasts: for them, accelerations count alone.
pub fn solve_initial_pressure(world: &mut World, is_linear: bool) {
    let dt = world.resource::<Clock>().dt;
    let Some(limit) = limit(world, dt) else {
        return;
    };
    let recovery = world.remove_resource::<RecoveryTime>();
    if !is_linear {
        // Nobody has predicted positions yet: the velocities take their memory meanwhile.
        let lent = mem::take(&mut world.resource_mut::<PredictedPositions>().0);
        world.resource_mut::<PredictedVelocities>().0 = lent;
    }
    let convergence = Convergence {
        max_density_error: limit,
        mean_density_error: None,
        criterion: Criterion::Mean,
        min_iterations: 3,
        max_iterations: MAX_ITERATIONS,
        not_converged: NotConverged::Accept,
    };
    if !is_linear {
        warm_start::start(world, 0.0);
        // Systems that read and write plain columns cannot fail.
        let _ = world.run_system_once(predict_starting_velocities);
        let _ = world.run_system_once(predict_rates);
        let rates = mem::take(&mut *world.resource_mut::<DensityRates>());
        world.insert_resource(StartingRates(rates.0));
    }
    // A closed tank full of fluid may have no pressure that keeps all gaps: what its walls drive in has to go
    // somewhere.
    for keeps_gaps in [true, false] {
        world.insert_resource(RecoveryTime::never(keeps_gaps));
        warm_start::start(world, 0.0);
        if iterate(world, InitialIteration, &convergence, PATIENCE, false) == End::Converged {
            break;
        }
    }
    world.remove_resource::<StartingRates>();
    let _ = world.run_system_once(store_pressures);
    let _ = world.run_system_once(remember_first_pressure);
    let _ = world.run_system_once(shorten_first_step);
    let _ = world.run_system_once(move_walls_less);
    match recovery {
        Some(recovery) => world.insert_resource(recovery),
        None => {
            world.remove_resource::<RecoveryTime>();
        }
    }
    if !is_linear {
        // PCISPH needs neither afterwards.
        let mut lent = mem::take(&mut world.resource_mut::<PredictedVelocities>().0);
        if let Some(last) = lent.last_mut() {
            *last = SENTINEL;
        }
        world.resource_mut::<PredictedPositions>().0 = lent;
        world.resource_mut::<DensityRates>().0 = Vec::new();
    }
}

/// Mean compression \[-] of a step in which the fluid falls with the part [`UNCARRIED`] of the largest acceleration
/// over its extent along it; none if there is no acceleration.
fn limit(world: &World, dt: f32) -> Option<f32> {
    let execution = world.resource::<Execution>();
    let positions = world.resource::<Positions>().points();
    let owned = execution.owned(positions.len());
    let corners = (Vec4::INFINITY, Vec4::NEG_INFINITY);
    let (low, high) = execution.in_turn(corners, |corners| {
        let positions = positions[owned.clone()].iter();
        positions.fold(corners, |(low, high), x| (low.min(*x), high.max(*x)))
    });
    let extents = (high - low).truncate();
    let accelerations = &world.resource::<Accelerations>().0;
    let of_one = |(sum, most): (Vec3, f32), a: &Vec3| (sum + *a, most.max(a.length_squared()));
    let (sum, most) = execution.in_turn((Vec3::ZERO, 0.0), |start| {
        accelerations[owned.clone()].iter().fold(start, of_one)
    });
    let rows = execution.all(accelerations.len());
    let (mean, pull) = (sum / rows as f32, most.sqrt());
    // Water that is wide and shallow has to be carried as water of its depth alone. Forces of different directions, as
    // toward a centre, may act along any extent.
    let extent = if mean.length() > 0.5 * pull {
        extents.dot(mean.abs()) / mean.length()
    } else {
        extents.max_element()
    };
    let extent = extent.max(world.resource::<Material>().spacing);
    let limit = UNCARRIED * dt * dt * pull / extent;
    (limit > 0.0 && limit.is_finite()).then_some(limit)
}
