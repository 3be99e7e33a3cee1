//! When a run ends and when a frame is due, in simulated time.

use overfall::scene::Output;

/// What a run goes for.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Goal {
    /// Simulated time \[s].
    Time(f64),
    /// Number of steps.
    Steps(u64),
}

impl Goal {
    /// The goal of a scene without a number of steps.
    pub(super) fn duration(seconds: f32) -> Self {
        Self::Time(decimal(seconds))
    }

    /// Whether a run that has taken `steps` steps, the last of which ended at `time` \[s], is there.
    pub(super) fn is_reached(self, steps: u64, time: f64) -> bool {
        match self {
            Self::Time(end) => time >= end,
            Self::Steps(end) => steps >= end,
        }
    }

    /// The part of the way that is done, 0 to 1.
    pub(super) fn fraction(self, steps: u64, time: f64) -> f64 {
        let fraction = match self {
            Self::Time(end) => time / end,
            Self::Steps(end) => steps as f64 / end.max(1) as f64,
        };
        fraction.clamp(0.0, 1.0)
    }

    /// The simulated time that the run goes for \[s].
    fn end(self) -> f64 {
        match self {
            Self::Time(end) => end,
            Self::Steps(_) => f64::INFINITY,
        }
    }
}

/// The number that a scene writes: 0.1 in single precision is 0.1, and not the 0.100000001 that it stands for.
fn decimal(number: f32) -> f64 {
    number.to_string().parse().unwrap_or(number.into())
}

/// Part of a step by which summed time may be off.
const ROUNDING: f64 = 1e-2;

/// Frames per second; the next multiple that has none; time of the last frame \[s], and the multiple that was next before.
pub(super) type ClockState = (f64, f64, Option<(f64, f64)>);

/// Says at which step ends a frame is due.
///
/// These are the step ends nearest to the multiples of the frame interval: a picture is not worth a change of the
/// result. A scene may ask for the multiples themselves (`output.exact_times`), where steps then end. The first frame
/// (time 0) and the last (the end of the run) are written whatever this says.
#[derive(Debug, Clone)]
pub(super) struct FrameClock {
    per_second: f64,
    exact: bool,
    /// The next multiple that has no frame yet.
    next: f64,
    /// Multiples from here on are left to the last frame \[s].
    end: f64,
    /// Time of the last frame \[s], and the multiple that was next before it.
    last: Option<(f64, f64)>,
}

impl FrameClock {
    /// A clock for the frames of a scene (none between if it has 0 a second), in a run that goes for `goal`.
    pub(super) fn new(output: &Output, goal: Goal) -> Self {
        Self {
            per_second: decimal(output.frames_per_second),
            exact: output.exact_times,
            next: 1.0,
            end: goal.end(),
            last: None,
        }
    }

    /// What a run that goes on has to know: frames per second, the next multiple, the last frame.
    pub(super) fn state(&self) -> ClockState {
        (self.per_second, self.next, self.last)
    }

    /// Goes on from there at `time` \[s]; with another number of frames per second at its next multiple.
    pub(super) fn set_state(&mut self, (per_second, next, last): ClockState, time: f64) {
        if per_second == self.per_second {
            (self.next, self.last) = (next, last);
        } else {
            self.next = (time * self.per_second).floor() + 1.0;
        }
    }

    /// The time after `time` that a step must not pass \[s], if there is one.
    pub(super) fn until(&self, time: f64) -> Option<f64> {
        let multiple = self.next / self.per_second;
        let times = [self.end, if self.exact { multiple } else { self.end }];
        let first = (times.into_iter().filter(|&until| until > time)).fold(f64::INFINITY, f64::min);
        first.is_finite().then_some(first)
    }

    /// Whether the step that ended at `time` is the nearest one to a multiple, if the next is `next_dt` long.
    ///
    /// Several multiples within one step make one frame.
    pub(super) fn is_due(&mut self, time: f64, next_dt: f64) -> bool {
        let multiple = self.next / self.per_second;
        if self.per_second <= 0.0 || multiple >= self.end - ROUNDING * next_dt {
            return false;
        }
        let reached = if !self.exact {
            ((time + 0.5 * next_dt) * self.per_second).floor()
        } else if time >= multiple {
            self.next
        } else {
            0.0
        };
        let is_due = reached >= self.next;
        if is_due {
            self.last = Some((time, self.next));
            self.next = reached + 1.0;
        }
        is_due
    }

    /// Takes note that the run went back to `time`: a frame after it is due again. The last suffices, as a run goes
    /// back over one step that may have had a frame.
    pub(super) fn set_back(&mut self, time: f64) {
        if let Some((_, next)) = self.last.take_if(|last| last.0 > time) {
            self.next = next;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn output(frames_per_second: f32, exact_times: bool) -> Output {
        Output {
            frames_per_second,
            exact_times,
            ..Output::default()
        }
    }

    /// Runs steps of `dt` to `end` with nothing shortened but the last; gives their number and the times of the frames
    /// between.
    fn run(per_second: f32, dt: f64, end: f64) -> (u64, Vec<f64>) {
        let goal = Goal::Time(end);
        let mut clock = FrameClock::new(&output(per_second, false), goal);
        let (mut steps, mut time, mut frames) = (0, 0.0, Vec::new());
        while !goal.is_reached(steps, time) {
            steps += 1;
            time += dt;
            if time > end - ROUNDING * dt {
                time = end;
            }
            if !goal.is_reached(steps, time) && clock.is_due(time, dt) {
                frames.push(time);
            }
        }
        (steps, frames)
    }

    #[test]
    fn frames_are_at_the_step_ends_nearest_to_the_multiples() {
        let (steps, frames) = run(10.0, f64::from(0.003_f32), 1.0);
        assert_eq!(steps, 334);
        assert_eq!(frames.len(), 9);
        for (number, time) in frames.iter().enumerate() {
            let multiple = 0.1 * (number + 1) as f64;
            assert!(
                (time - multiple).abs() <= 0.0015 + 1e-6,
                "{time} for {multiple}"
            );
        }
    }

    #[test]
    fn a_step_longer_than_the_frame_interval_makes_one_frame() {
        let (steps, frames) = run(1000.0, 0.01, 0.1);
        assert_eq!(steps, 10);
        assert_eq!(frames.len(), 9);
    }

    #[test]
    fn the_last_multiple_is_left_to_the_last_frame() {
        assert_eq!(run(25.0, f64::from(0.001_f32), 0.4).1.len(), 9);
        // The multiple at the end is nearest to the step before the last.
        assert_eq!(run(1.0, 0.3, 1.0).1.len(), 0);
    }

    #[test]
    fn a_frame_of_a_step_taken_back_is_due_again() {
        let mut clock = FrameClock::new(&output(10.0, false), Goal::Time(1.0));
        assert!(clock.is_due(0.1, 0.02));
        clock.set_back(0.1);
        assert!(!clock.is_due(0.12, 0.02), "the frame stands");
        clock.set_back(0.08);
        assert!(clock.is_due(0.099, 0.005));
        assert!(!clock.is_due(0.104, 0.005));
    }

    #[test]
    fn exact_frames_are_at_the_multiples_and_steps_end_there() {
        let mut clock = FrameClock::new(&output(10.0, true), Goal::duration(0.25));
        assert_eq!(clock.until(0.0), Some(0.1));
        assert!(!clock.is_due(0.099, 0.01));
        assert!(clock.is_due(0.1, 0.01));
        assert_eq!(clock.until(0.1), Some(0.2));
        clock.set_back(0.09);
        assert_eq!(clock.until(0.09), Some(0.1));
        assert!(clock.is_due(0.1, 0.01) && clock.is_due(0.2, 0.01));
        assert_eq!(clock.until(0.2), Some(0.25));
        let clock = FrameClock::new(&output(0.0, true), Goal::Steps(3));
        assert_eq!(clock.until(0.0), None);
        // What is not exact ends at the end alone, and that is the number which the scene writes.
        let clock = FrameClock::new(&output(10.0, false), Goal::duration(0.3));
        assert_eq!(clock.until(0.0), Some(0.3));
    }

    #[test]
    fn no_frames_a_second_are_no_frames_between() {
        assert_eq!(run(0.0, 0.01, 0.1).1.len(), 0);
    }

    #[test]
    fn rounding_does_not_add_a_step() {
        // 0.0001 as f32 is a little below 0.0001.
        assert_eq!(run(0.0, f64::from(0.000_1_f32), 1.0).0, 10_000);
        assert_eq!(run(0.0, f64::from(0.001_f32), f64::from(0.3_f32)).0, 300);
    }

    #[test]
    fn the_way_done_is_a_fraction_of_time_or_of_steps() {
        assert_eq!(Goal::Time(2.0).fraction(7, 0.5), 0.25);
        assert_eq!(Goal::Steps(10).fraction(7, 0.5), 0.7);
        assert_eq!(Goal::Steps(0).fraction(0, 0.0), 0.0);
    }
}
