//! The iteration loop of all iterative methods: repeats until the density error is below its limit. If that fails and
//! the scene allows it, the time step is halved.

use std::mem;

use bevy_ecs::{prelude::*, schedule::ScheduleLabel};
use rayon::prelude::*;

use super::{
    convergence::Convergence,
    first_force, impact,
    implicit::Jacobi,
    warm_start::{self, WarmStart},
};
use crate::{
    boundary::moving::move_walls_less,
    scene::NotConverged,
    state::{
        Accelerations, Clock, Execution, Failure, FailureCause, Material, PressureAccelerations,
        SolverState, Velocities, of_step::OfStep,
    },
    time_step::{AdaptiveTimeStep, TimeStepControl},
};

/// One iteration of the pressure loop: measures the error of the present pressures and corrects them.
///
/// The systems form a chain, so the schedule runs on one thread (0.3 µs overhead per run); the loops inside the
/// systems are parallel.
#[derive(ScheduleLabel, Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct PressureIteration;

/// The force of the last correction, for PCISPH scenes that use Algorithm 2 unchanged.
#[derive(ScheduleLabel, Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct LastCorrection;

/// Iterates until the density error is small enough (phase `Pressure`).
///
/// If the error stops falling, the relaxation is halved first (see [`implicit`](super::implicit)). With the time step
/// `Cfl`, a step that turns out too long is halved and solved again before anything has moved: if the error has stopped
/// falling with the smallest relaxation, too, or if a particle would move more than the paper's h/2. With `Adaptive`,
/// the iterations stop under the same conditions, and the step is rolled back.
///
/// Initial pressures that are further from the solution than none are halved (see [`nearness`](super::implicit)).
pub fn solve_pressure(world: &mut World) {
    let convergence = *world.resource::<Convergence>();
    let mut share = world.resource::<WarmStart>().share;
    // Viscosity has prepared the start of the solve.
    let mut has_force = first_force::take(world);
    if share > 0.0 && world.resource::<Clock>().step == 0 {
        // The initial pressure counts in full; it was not there when viscosity was summed.
        (share, has_force) = (1.0, false);
    }
    loop {
        let shorter = world
            .get_resource::<TimeStepControl>()
            .and_then(|control| control.shorter(world.resource::<Clock>().dt));
        let goes_back = convergence.not_converged == NotConverged::Stop
            && world
                .get_resource::<AdaptiveTimeStep>()
                .is_some_and(|scheme| scheme.may_go_back(world.resource::<Clock>().dt));
        let patience = if shorter.is_some() || goes_back {
            PATIENCE
        } else {
            convergence.max_iterations
        };
        let mut solve = |world: &mut World| {
            loop {
                if mem::take(&mut has_force) {
                    world.resource_mut::<SolverState>().wants_force = false;
                } else {
                    warm_start::start(world, share);
                }
                let end = iterate(world, PressureIteration, &convergence, patience, true);
                if end != End::Misled {
                    return end;
                }
                share = if share > LEAST_SHARE {
                    0.5 * share
                } else {
                    0.0
                };
            }
        };
        let jacobi = *world.resource::<Jacobi>();
        let mut end = solve(world);
        if matches!(end, End::Converged | End::Exhausted) && impact::is_met(world) {
            if end == End::Converged && impact::is_stabilised(world) {
                end = impact::without_stabilisation(world, solve);
            }
            // An impact takes as many iterations as there are rows, or more. Half of the step has less to do.
            let may_be_shorter = shorter.is_some() || goes_back;
            let is_unsolved = end == End::Exhausted;
            if may_be_shorter && (is_unsolved || end == End::Converged && impact::compresses(world))
            {
                end = End::Overshot;
            }
        }
        if end == End::Stalled {
            // Not the relaxation was too large, but the step too long.
            *world.resource_mut::<Jacobi>() = jacobi;
        }
        // Present only if the scene needs it.
        let _ = world.try_run_schedule(LastCorrection);
        if let Some(dt) = shorter
            && (matches!(end, End::Stalled | End::Overshot) || moves_too_far(world))
        {
            world.resource_mut::<Clock>().dt = dt;
            world.resource_mut::<OfStep>().shorten(dt);
            // Systems that read and write plain columns cannot fail.
            let _ = world.run_system_cached(move_walls_less);
            continue;
        }
        if end != End::Converged && convergence.not_converged == NotConverged::Stop {
            let solve = world.resource::<SolverState>();
            let (error, row) = convergence.measured_error(solve);
            let cause = FailureCause::NotConverged {
                iterations: solve.iterations,
                error,
                limit: convergence.max_density_error,
            };
            world.resource_mut::<Failure>().record(cause, Some(row));
        }
        return;
    }
}

/// Iterations within which the error must fall if the time step may be shortened; the median step needs 3 to 10.
///
/// While the error falls, the step keeps its length: compression is removed within the step, with a velocity
/// proportional to 1/dt. With a limit of 50 iterations instead, still water of 30 layers, whose weight needs hundreds
/// of iterations to reach the floor, went from 5 ms to 0.035 ms and moved with 8 sqrt(g H) (IISPH, 0.1 % mean error),
/// water of 90 layers with 230 sqrt(g H).
const PATIENCE: u32 = 25;

/// Smallest share of earlier pressures that is halved where they turn out too high \[-]; after it comes none. Half of
/// them, where that is nearer, still carries part of the fluid's weight: without, water at rest falls in steps that are
/// too short to compress it.
const LEAST_SHARE: f32 = 0.1;

/// Iterations after which errors that have not fallen are noticed at the latest.
const LONGEST_INTERVAL: u32 = 100;

/// How iterations end.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum End {
    /// The error is below its limit.
    Converged,
    /// The initial pressures are further from the solution than none. Those of an impact are: the next step does
    /// not need them, and a short one would not see in its densities that they throw the fluid back.
    Misled,
    /// The maximum number of iterations is reached.
    Exhausted,
    /// The error has stopped falling.
    Stalled,
    /// An impact: the step compresses the fluid though the error is below its limit, or is too long to solve.
    Overshot,
}

/// Runs `iteration` until the error is below its limit, the number of iterations is reached, or `patience` iterations
/// in a row did not reduce the error; if the solve `damps`, with the smallest relaxation either.
pub(super) fn iterate(
    world: &mut World,
    iteration: impl ScheduleLabel,
    convergence: &Convergence,
    patience: u32,
    damps: bool,
) -> End {
    // The whole loop runs inside the thread pool, so that loops need not wake its threads.
    let execution = world.resource::<Execution>().clone();
    let mut before = f32::INFINITY;
    let interval = patience.min(LONGEST_INTERVAL);
    let mut until_the_end = |world: &mut World, iteration: &mut Schedule| {
        loop {
            iteration.run(world);
            let mut solve = world.resource_mut::<SolverState>();
            solve.iterations += 1;
            solve.wants_force = true;
            let (error, _) = convergence.measured_error(&solve);
            if solve.iterations == 1 && solve.progress < 0.0 {
                return End::Misled;
            }
            if error <= convergence.max_density_error
                && solve.iterations >= convergence.min_iterations
            {
                return End::Converged;
            }
            if solve.iterations >= convergence.max_iterations {
                return End::Exhausted;
            }
            if solve.iterations.is_multiple_of(interval) {
                // NaN does not converge.
                let falls = error < before;
                before = error;
                if !falls {
                    if damps && world.resource_mut::<Jacobi>().damp() {
                        before = f32::INFINITY;
                    } else if interval == patience {
                        return End::Stalled;
                    }
                }
            }
        }
    };
    world.schedule_scope(iteration, |world, iteration| {
        execution.install(|| until_the_end(world, iteration))
    })
}

/// Whether a particle would move more than half the support radius.
fn moves_too_far(world: &World) -> bool {
    let dt = world.resource::<Clock>().dt;
    let velocities = world.resource::<Velocities>();
    let forces = world.resource::<Accelerations>().0.par_iter();
    let forces = forces.zip(&world.resource::<PressureAccelerations>().0);
    let limit = (0.5 * world.resource::<Material>().kernel.support_radius / dt).powi(2);
    let execution = world.resource::<Execution>();
    execution.any(execution.install(|| {
        forces
            .zip(&velocities.0)
            .any(|((a, a_p), v)| (v.truncate() + dt * (*a + *a_p)).length_squared() > limit)
    }))
}
