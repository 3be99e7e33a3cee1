//! Takes a step of the scene in a world.

use std::panic::{AssertUnwindSafe, catch_unwind, resume_unwind};

use bevy_ecs::prelude::*;

use super::{
    constants::spoilt,
    report::{StepOutcome, StepReport},
    schedule::{Labels, OwnSystems, SingleThreadedStep, Step},
    uninstall::{is_running, lost_resource, set_running},
};
use crate::state::{
    Clock, Execution, FailureCause, StepError,
    seal::{Seal, reseal},
};

/// Takes one step of the scene that is installed in `world`. After an error the world holds the last good state. It
/// also fails if no scene is installed, or if a panic that the host caught removed a part of the scene.
///
/// If the systems run one at a time ([`Executor`](crate::scene::Executor)), the whole step runs inside the loops'
/// thread pool, so that its loops need not wake threads one by one. In a world with data that are bound to a thread, it
/// runs on the calling thread.
///
/// # Panics
///
/// If a system of the host panics. The tables then hold the last good state, and the next step can be taken. That state
/// is the one before the step; with parallel systems it is the one after it, because the engine's own systems run to
/// the end.
pub fn take_step(world: &mut World) -> Result<StepReport, StepError> {
    if let Some(cause) = what_is_missing(world) {
        return Err(refused(world, cause));
    }
    if world.contains_resource::<SingleThreadedStep>() && world.storages().non_sends.is_empty() {
        let execution = world.resource::<Execution>().clone();
        execution.install(|| run_step(world))?;
    } else {
        run_step(world)?;
    }
    world.resource::<StepOutcome>().0.clone()
}

/// The error of a step that could not begin.
pub(super) fn refused(world: &World, cause: FailureCause) -> StepError {
    let clock = world.get_resource::<Clock>().copied().unwrap_or_default();
    StepError {
        step: clock.step + 1,
        time: clock.time,
        particle: None,
        cause,
    }
}

/// Runs the schedule of the step. If a system panics, the schedule is returned to the world before the panic continues.
fn run_step(world: &mut World) -> Result<(), StepError> {
    set_running(world, true);
    let ran = world.try_schedule_scope(Step, |world, step| {
        // Initialises systems that the host has added since the last step: bevy would panic about an error in them.
        if let Err(error) = step.initialize(world) {
            let conflict = error.to_string(step.graph(), world);
            return Err(refused(world, FailureCause::Schedule { conflict }));
        }
        let own = world.get_resource::<OwnSystems>().and_then(|own| own.0);
        if let Some(mut seal) = world.get_resource_mut::<Seal>() {
            seal.is_alone = own == Some(step.systems_len());
        }
        Ok(catch_unwind(AssertUnwindSafe(|| step.run(world))))
    });
    set_running(world, false);
    match ran {
        // The engine's own systems panic where a host's system has taken their data away.
        Ok(Ok(Err(panic))) => match spoilt(world).or_else(|| what_is_missing(world)) {
            Some(cause) => Err(refused(world, cause)),
            None => {
                // What the engine wrote since its last phase ended is not the host's.
                reseal(world);
                resume_unwind(panic)
            }
        },
        Ok(Err(error)) => Err(error),
        _ => Ok(()),
    }
}

/// The reason why no step can be taken in this world, if there is one.
fn what_is_missing(world: &World) -> Option<FailureCause> {
    let because = |reason| Some(FailureCause::NotInstalled { reason });
    if is_running(world) {
        return because("a system cannot take a step in the middle of one; take it between steps");
    }
    let Some(labels) = world.get_resource::<Labels>() else {
        return because("no scene is installed in this world; call `install` first");
    };
    if let Some(resource) = lost_resource(world) {
        return Some(FailureCause::LacksResource { resource });
    }
    let schedules = world.get_resource::<Schedules>();
    let present = |label| schedules.is_some_and(|schedules| schedules.contains(label));
    let all = labels.0.iter().all(|&label| present(label));
    let lost = !all || !world.contains_resource::<Execution>();
    if !lost {
        return None;
    }
    because(
        "a panic or the host took a part of the scene out of the world; install it in a new one, and run steps by \
         `take_step`, which keeps them through a panic",
    )
}
