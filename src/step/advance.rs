//! Advancing the fluid by the duration of a host's frame, in whole steps.

use bevy_ecs::prelude::*;

use super::{
    report::StepReport,
    take::{refused, take_step},
};
use crate::state::{Clock, FailureCause, StepError};

/// Simulated time by which the fluid lags behind the host \[s]: less than a step.
#[derive(Resource, Debug, Default)]
pub(super) struct Owed(f64);

/// Result of [`advance`].
#[derive(Debug, Clone, Default, PartialEq)]
#[non_exhaustive]
pub struct Advance {
    /// Number of steps taken; 0 if the time was too short for one.
    pub steps: u32,
    /// Time that was too short for another step and is kept for the next call \[s].
    pub rest: f64,
    /// Report of the last of these steps.
    pub report: Option<StepReport>,
}

/// A step is still taken if the time left is shorter than it by this relative rounding error.
const ROUNDING: f64 = 1e-6;

/// Takes as many whole steps as fit into `seconds` plus the time kept from earlier calls, and keeps the remainder. The
/// simulation chooses the length of its steps. After an error the world holds the last good state, the kept time is
/// dropped, and the next call tries again.
///
/// A host that passes the duration of a slow frame asks for that much simulated time, which may take even longer to
/// compute. A game that has to keep up limits it: `advance(world, delta.min(0.05))`.
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
            // This step fails and says what is missing.
            break take_step(world).map(|_| ());
        };
        let dt = f64::from(next_dt);
        done.rest = end - time;
        // A clock whose next step has no length, or whose time is none, takes a step, too: it fails and reports the
        // reason.
        let waits = done.rest < dt * (1.0 - ROUNDING) || done.rest <= 0.0;
        if waits && dt.is_finite() && time.is_finite() {
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
