//! The iterations of every method that has some: run one after the other until the density error is under its limit, in
//! a time step that is halved, if it may be, where they do not get there.

use bevy_ecs::{prelude::*, schedule::ScheduleLabel};
use rayon::prelude::*;

use super::{
    convergence::Convergence,
    first_force,
    warm_start::{self, WarmStart},
};
use crate::{
    scene::NotConverged,
    state::{
        Accelerations, Clock, Execution, Failure, FailureCause, Material, PressureAccelerations,
        PressureSolve, Velocities,
    },
    time_step::{AdaptiveTimeStep, TimeStepControl},
};

/// One iteration of the pressure loop. A chain of systems without anything to overlap: it runs on one thread, whose
/// overhead is 0.3 µs a run, and the loops inside are parallel.
///
/// It measures the error of the pressures that there are, and corrects them.
#[derive(ScheduleLabel, Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct PressureIteration;

/// The force of the last correction, where a scene of PCISPH wants the paper's Algorithm 2 to the letter.
#[derive(ScheduleLabel, Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct LastCorrection;

/// Iterates until the density error is small enough (phase `Pressure`).
///
/// With a time step that follows the motion (`Cfl`), one that turns out too long is halved and solved again before
/// anything has moved: when the error stops falling or a particle would move more than the paper's h/2. With one that
/// goes back (`Adaptive`) the iterations give up as early, and the step is taken back.
pub fn solve_pressure(world: &mut World) {
    let convergence = *world.resource::<Convergence>();
    let mut share = world.resource::<WarmStart>().share;
    // Viscosity has started the solve then, too.
    let mut has_force = first_force::take(world);
    if share > 0.0 && world.resource::<Clock>().step == 0 {
        // All of the initial pressure, which was not there when viscosity was summed.
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
        if has_force {
            world.resource_mut::<PressureSolve>().wants_force = false;
        } else {
            warm_start::start(world, share);
        }
        let end = iterate(world, PressureIteration, &convergence, patience);
        // There only if the scene asks for it.
        let _ = world.try_run_schedule(LastCorrection);
        if let Some(dt) = shorter
            && (end == End::Stalled || moves_too_far(world))
        {
            world.resource_mut::<Clock>().dt = dt;
            // What it started from led nowhere.
            (share, has_force) = (0.0, false);
            continue;
        }
        if end != End::Converged && convergence.not_converged == NotConverged::Stop {
            let solve = world.resource::<PressureSolve>();
            let (error, row) = convergence.judged(solve);
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

/// Iterations in which the error must fall where a time step may be shorter; the median step takes 3 to 10.
///
/// As long as it falls the step is as long as it was, however many it takes: what the density has too much at its start
/// is pushed out within it, with a speed that grows as 1/dt. Halved whenever 50 iterations did not do, still water of
/// 30 layers, whose weight takes hundreds to arrive at the floor, went from 5 ms to 0.035 ms and jumped with 8 sqrt(g
/// H) (IISPH, 0.1 % mean error), and water of 90 layers with 230.
const PATIENCE: u32 = 25;

/// How iterations end.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum End {
    /// The error is under its limit.
    Converged,
    /// There have been too many.
    Exhausted,
    /// The error does not fall any more.
    Stalled,
}

/// Runs `iteration` until the error comes under its limit, or the iterations are too many, or `patience` of them in a
/// row have not made it less.
pub(super) fn iterate(
    world: &mut World,
    iteration: impl ScheduleLabel,
    convergence: &Convergence,
    patience: u32,
) -> End {
    // All of it in the pool, so that no loop has to wake a thread of it first.
    let execution = world.resource::<Execution>().clone();
    let mut before = f32::INFINITY;
    let mut until_the_end = |world: &mut World, iteration: &mut Schedule| {
        loop {
            iteration.run(world);
            let mut solve = world.resource_mut::<PressureSolve>();
            solve.iterations += 1;
            solve.wants_force = true;
            let (error, _) = convergence.judged(&solve);
            if error <= convergence.max_density_error
                && solve.iterations >= convergence.min_iterations
            {
                return End::Converged;
            }
            if solve.iterations >= convergence.max_iterations {
                return End::Exhausted;
            }
            if solve.iterations.is_multiple_of(patience) {
                // What is not a number does not.
                let falls = error < before;
                if !falls {
                    return End::Stalled;
                }
                before = error;
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
    world.resource::<Execution>().install(|| {
        forces
            .zip(&velocities.0)
            .any(|((a, a_p), v)| (v.truncate() + dt * (*a + *a_p)).length_squared() > limit)
    })
}
