//! One timer per phase, always on.

use std::time::Instant;

use bevy_ecs::prelude::*;

use crate::state::Phase;

/// Wall time of the phases of one step \[s].
#[derive(Resource, Debug, Clone)]
pub struct PhaseTimer {
    last: Instant,
    /// One entry per phase, in the order of [`Phase::ALL`].
    pub(crate) seconds: [f64; Phase::ALL.len()],
}

impl Default for PhaseTimer {
    fn default() -> Self {
        Self {
            last: Instant::now(),
            seconds: Default::default(),
        }
    }
}

pub(super) fn start_timer(mut timer: ResMut<PhaseTimer>) {
    *timer = PhaseTimer::default();
}

/// A system that adds the time since the previous such system to `phase`.
pub(super) fn lap(phase: Phase) -> impl FnMut(ResMut<PhaseTimer>) {
    move |mut timer| {
        let now = Instant::now();
        timer.seconds[phase as usize] += (now - timer.last).as_secs_f64();
        timer.last = now;
    }
}
