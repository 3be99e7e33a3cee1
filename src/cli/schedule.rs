//! When a run ends and when a frame is due, in simulated time.

use overfall::scene::Output;

/// The goal of a run.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Goal {
    /// Simulated time \[s].
    Time(f64),
    /// Number of steps.
    Steps(u64),
}

impl Goal {
    /// The goal of a scene that is given a duration.
    pub(super) fn duration(seconds: f32) -> Self {
        Self::Time(decimal(seconds))
    }

    /// Whether a run that has taken `steps` steps, the last of which ended at `time` \[s], has reached the goal.
    pub(super) fn is_reached(self, steps: u64, time: f64) -> bool {
        match self {
            Self::Time(end) => time >= end,
            Self::Steps(end) => steps >= end,
        }
    }

    /// The completed fraction of the run, 0 to 1.
    pub(super) fn fraction(self, steps: u64, time: f64) -> f64 {
        let fraction = match self {
            Self::Time(end) => time / end,
            Self::Steps(end) => steps as f64 / end.max(1) as f64,
        };
        fraction.clamp(0.0, 1.0)
    }

    /// The simulated time of the goal \[s].
    fn end(self) -> f64 {
        match self {
            Self::Time(end) => end,
            Self::Steps(_) => f64::INFINITY,
        }
    }
}

/// The decimal number of the scene file: 0.1 in single precision becomes 0.1 and not 0.100000001.
fn decimal(number: f32) -> f64 {
    number.to_string().parse().unwrap_or(number.into())
}

/// Largest rounding error of a sum of steps \[steps].
const ROUNDING: f64 = 1e-2;

/// Frames per second; the next multiple of the interval without a frame; time of the last frame \[s] and the next
/// multiple before it.
pub(super) type ClockState = (f64, f64, Option<(f64, f64)>);

/// Decides at the end of which steps a frame is due.
///
/// These are the step ends nearest to the multiples of the frame interval, so that frames do not change the result.
/// With `output.exact_times` steps end exactly at the multiples. The first frame (time 0) and the last (end of the run)
/// are written in any case.
#[derive(Debug, Clone)]
pub(super) struct FrameClock {
    per_second: f64,
    exact: bool,
    /// The next multiple without a frame.
    next: f64,
    /// Multiples from this time on are covered by the last frame \[s].
    end: f64,
    /// Time of the last frame \[s], and the next multiple before it.
    last: Option<(f64, f64)>,
}

impl FrameClock {
    /// A clock for the frames of a scene (with 0 per second, only the first and the last), in a run towards `goal`.
    pub(super) fn new(output: &Output, goal: Goal) -> Self {
        Self {
            per_second: decimal(output.frames_per_second),
            exact: output.exact_times,
            next: 1.0,
            end: goal.end(),
            last: None,
        }
    }

    /// The state from which a run resumes.
    pub(super) fn state(&self) -> ClockState {
        (self.per_second, self.next, self.last)
    }

    /// Resumes from that state at `time` \[s]. If the number of frames per second has changed, the next multiple is
    /// computed again.
    pub(super) fn set_state(&mut self, (per_second, next, last): ClockState, time: f64) {
        if per_second == self.per_second {
            (self.next, self.last) = (next, last);
        } else {
            self.next = (time * self.per_second).floor() + 1.0;
        }
    }

    /// The time that a step beginning at `time` must not pass \[s], if there is one.
    pub(super) fn until(&self, time: f64) -> Option<f64> {
        let multiple = self.next / self.per_second;
        let times = [self.end, if self.exact { multiple } else { self.end }];
        let first = (times.into_iter().filter(|&until| until > time)).fold(f64::INFINITY, f64::min);
        first.is_finite().then_some(first)
    }

    /// Whether the step that ended at `time` is the nearest to a multiple, if the next step has length `next_dt`.
    ///
    /// Several multiples within one step give one frame.
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

    /// Records that the run went back to `time`: a frame after it is due again. Remembering one frame suffices, because
    /// the run goes back over at most one step with a frame.
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

    /// Runs steps of `dt` to `end`, of which only the last is shortened. Returns their number and the times of the
    /// frames between.
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
        // Without exact times steps end only at the end, which is the decimal number of the scene.
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
