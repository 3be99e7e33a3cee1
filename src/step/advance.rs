//! Whole steps for the time of a game's frame.

use bevy_ecs::prelude::*;

use super::{
    report::StepReport,
    take::{refused, take_step},
};
use crate::state::{Clock, FailureCause, StepError};

/// Time that the fluid is behind the host \[s]: less than a step.
#[derive(Resource, Debug, Default)]
pub(super) struct Owed(f64);

/// What [`advance`] did.
#[derive(Debug, Clone, Default, PartialEq)]
#[non_exhaustive]
pub struct Advance {
    /// Steps taken; 0 if the time was too short for one.
    pub steps: u32,
    /// Time that is kept for the next call \[s].
    pub rest: f64,
    /// What the last of the steps did.
    pub report: Option<StepReport>,
}

/// Part of a step that rounding of many times may lack, which does not put the step off to the next call.
const ROUNDING: f64 = 1e-6;

/// Takes as many whole steps as fit into `seconds` and what earlier calls kept, and keeps the rest. Steps have their own
/// length. After an error the world holds the last good state, the time that was left is forgotten, and the next call
/// tries again.
///
/// A frame that took a second asks for a second of fluid, which may take longer still: a game that wants to stay in time
/// gives no more than it can wait for, `advance(world, delta.min(0.05))`.
pub fn advance(world: &mut World, seconds: f64) -> Result<Advance, StepError> {
    if !(seconds.is_finite() && seconds >= 0.0) {
        return Err(refused(world, FailureCause::Seconds { seconds }));
    }
    let owed = world.get_resource::<Owed>().map_or(0.0, |owed| owed.0);
    let start = world
        .get_resource::<Clock>()
        .map_or(0.0, |clock| clock.time);
    let end = start + owed + seconds;
    let mut done = Advance::default();
    let result = loop {
        let Some(&Clock { time, next_dt, .. }) = world.get_resource::<Clock>() else {
            // Says what is missing.
            break take_step(world).map(|_| ());
        };
        let dt = f64::from(next_dt);
        done.rest = end - time;
        // A step that has no length fails, and says so.
        if done.rest < dt * (1.0 - ROUNDING) || done.rest <= 0.0 {
            break Ok(());
        }
        match take_step(world) {
            Ok(report) => {
                done.steps += 1;
                done.report = Some(report);
            }
            Err(error) => break Err(error),
        }
    };
    if let Some(mut owed) = world.get_resource_mut::<Owed>() {
        owed.0 = if result.is_ok() { done.rest } else { 0.0 };
    }
    result.map(|()| done)
}
