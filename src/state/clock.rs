//! Where a run stands, and whether it still may go on.

use bevy_ecs::prelude::*;
use serde::{Deserialize, Serialize};

use super::{
    failure::{Failure, FailureCause},
    remembered::Remembers,
};

/// Simulated time and steps.
#[derive(Resource, Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
pub struct Clock {
    /// Steps taken.
    pub step: u64,
    /// Simulated time \[s].
    pub time: f64,
    /// Length of the step that is being taken, or was taken last \[s].
    pub dt: f32,
    /// Length of the next step \[s], if [`until`](Self::until) does not shorten it.
    pub next_dt: f32,
    /// Simulated time that no step passes \[s]: one ends there exactly. Once it is reached, or where there is none,
    /// steps have their own length.
    pub until: Option<f64>,
    /// The part of its own length that this step was shortened to.
    pub(crate) shortened_to: Option<f32>,
}

/// Part of a step by which time, a sum of many steps, may be off: a step is longer by so little rather than followed by
/// a second that long.
const ROUNDING: f64 = 1e-2;

impl Remembers for Clock {
    type State = Self;

    fn state(&self, _: &[Entity]) -> Self {
        *self
    }

    fn set_state(&mut self, state: Self, _: &[Entity]) -> Result<(), &'static str> {
        *self = state;
        Ok(())
    }
}

impl Clock {
    /// Length that this step would have had if it did not end at [`until`](Self::until) \[s]: the next step's follows
    /// from it.
    pub fn full_dt(&self) -> f32 {
        self.shortened_to.map_or(self.dt, |part| self.dt / part)
    }

    /// Length of a step \[s] that would be `dt` long. The last two before [`until`](Self::until) share what is left: a
    /// last one that is a small part of the one before would meet pressures that are not for it.
    fn shortened(&self, dt: f32) -> f32 {
        let Some(left) = self.until.map(|until| until - self.time) else {
            return dt;
        };
        let steps = left / f64::from(dt);
        // Neither is true of what is no number.
        if !(left >= f64::from(f32::MIN_POSITIVE) && steps < 2.0) {
            dt
        } else if steps <= 1.0 + ROUNDING {
            left as f32
        } else {
            (0.5 * left) as f32
        }
    }
}

/// Starts a step.
pub(crate) fn begin(mut clock: ResMut<Clock>, mut failure: ResMut<Failure>) {
    *failure = Failure::default();
    let dt = clock.next_dt;
    // What is no time step does not become one by being shortened.
    if !(dt > 0.0 && dt.is_finite()) {
        clock.dt = dt;
        clock.shortened_to = None;
        failure.record(FailureCause::TimeStep { dt }, None);
        return;
    }
    clock.dt = clock.shortened(dt);
    let (time, dt_now) = (clock.time, clock.dt);
    // False of a time that is infinite or no number, too.
    let advances = time + f64::from(dt_now) > time;
    if !advances {
        failure.record(FailureCause::Time { time, dt: dt_now }, None);
    }
    clock.shortened_to = (clock.dt != dt).then(|| clock.dt / dt);
}

/// Counts the step (phase `Integrate`, when nothing went wrong).
pub(crate) fn advance_clock(mut clock: ResMut<Clock>) {
    clock.step = clock.step.saturating_add(1);
    clock.time += f64::from(clock.dt);
    // The length of the step is rounded, and so is the sum; the time where it ends is not.
    let rounding = f64::from(f32::EPSILON * clock.dt).max(2.0 * f64::EPSILON * clock.time);
    clock.time = (clock.until)
        .filter(|until| (until - clock.time).abs() <= rounding)
        .unwrap_or(clock.time);
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The lengths of steps of `dt` from `time` to `until`, and the time behind the last.
    fn steps(time: f64, dt: f32, until: f64) -> (Vec<f32>, f64) {
        let mut world = World::new();
        world.init_resource::<Failure>();
        world.insert_resource(Clock {
            time,
            next_dt: dt,
            until: Some(until),
            ..Clock::default()
        });
        let mut schedule = Schedule::default();
        schedule.add_systems((begin, advance_clock).chain());
        let mut lengths = Vec::new();
        while world.resource::<Clock>().time < until && lengths.len() < 1000 {
            schedule.run(&mut world);
            let clock = world.resource::<Clock>();
            assert!((clock.full_dt() - dt).abs() <= 1e-6 * dt);
            lengths.push(clock.dt);
        }
        (lengths, world.resource::<Clock>().time)
    }

    #[test]
    fn the_last_step_ends_where_it_should_to_the_bit() {
        for (time, dt, until, expected) in [
            (0.0, 5e-3, 1e-4, vec![1e-4]),
            (0.0, 1e-3, 3e-3, vec![1e-3; 3]),
            (0.0, 1e-3, 2.5e-3, vec![1e-3, 7.5e-4, 7.5e-4]),
            (0.0, 1e-3, 2.005e-3, vec![1e-3, 1.005e-3]),
            (7.0, 1e-3, 7.0 + 1e-9, vec![1e-9]),
            (1e6, 0.1, 1e6 + 0.25, vec![0.1, 0.075, 0.075]),
        ] {
            let (lengths, end) = steps(time, dt, until);
            assert_eq!(end, until);
            assert_eq!(lengths.len(), expected.len(), "{lengths:?}");
            for (length, expected) in lengths.iter().zip(&expected) {
                assert!((length - expected).abs() < 1e-6 * dt, "{lengths:?}");
            }
        }
    }

    #[test]
    fn a_time_that_is_past_or_no_number_shortens_nothing() {
        for until in [-1.0, 2.0, 2.0 + 1e-60, f64::NAN, f64::INFINITY, 1e300] {
            let clock = Clock {
                time: 2.0,
                until: Some(until),
                ..Clock::default()
            };
            assert_eq!(clock.shortened(0.25), 0.25, "{until}");
        }
    }
}
