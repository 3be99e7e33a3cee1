//! When a gauge is read, and its mean over a window of time.

use std::collections::VecDeque;

use serde::{Deserialize, Serialize};

use crate::{scene::Rate, state::Clock};

/// When a gauge is read.
#[derive(Debug, Clone, Copy, Serialize, Deserialize)]
pub(super) struct Timing {
    rate: Rate,
    /// The next multiple without a reading.
    next: f64,
}

impl Timing {
    pub(super) fn new(rate: Rate) -> Self {
        Self { rate, next: 1.0 }
    }

    /// Whether the gauge is read after the step that ended. Several multiples within one step give one reading.
    pub(super) fn is_due(&mut self, clock: &Clock) -> bool {
        match self.rate {
            Rate::Steps(count) => clock.step.is_multiple_of(count.max(1).into()),
            Rate::Seconds(interval) => {
                let nearest = clock.time + 0.5 * f64::from(clock.next_dt);
                let reached = (nearest / decimal(interval)).floor();
                let is_due = reached >= self.next;
                if is_due {
                    self.next = reached + 1.0;
                }
                is_due
            }
        }
    }
}

/// The decimal number of the scene file: 0.1 in single precision becomes 0.1 and not 0.100000001.
pub(super) fn decimal(number: f32) -> f64 {
    number.to_string().parse().unwrap_or(number.into())
}

/// Means over the steps between two readings.
#[derive(Debug, Clone, Default, Serialize, Deserialize)]
struct Interval {
    /// Start of the interval \[s].
    begin: f64,
    /// For each quantity, the sum of its figures weighted with the lengths of their steps, and the sum of these
    /// lengths.
    sums: Vec<(f64, f64)>,
}

/// Means over a window of time, of the intervals between readings that lie in it.
#[derive(Debug, Clone, Default, Serialize, Deserialize)]
pub(super) struct Window {
    present: Interval,
    past: VecDeque<Interval>,
}

impl Window {
    /// Adds the figures after a step of length `dt` \[s].
    pub(super) fn add(&mut self, values: &[Option<f64>], dt: f64) {
        self.present.sums.resize(values.len(), (0.0, 0.0));
        for ((sum, weight), value) in self.present.sums.iter_mut().zip(values) {
            if let Some(value) = value {
                *sum += dt * value;
                *weight += dt;
            }
        }
    }

    /// Ends the interval at `time` \[s] and gives the means over the intervals that began no earlier than `length`
    /// before \[s], the last at least. A step may be off the rate by half of its length `dt` \[s].
    pub(super) fn close(&mut self, time: f64, length: f64, dt: f64) -> Vec<Option<f64>> {
        let next = Interval {
            begin: time,
            sums: Vec::new(),
        };
        self.past
            .push_back(std::mem::replace(&mut self.present, next));
        let is_past = |interval: &Interval| interval.begin + dt < time - length;
        while self.past.len() > 1 && self.past.front().is_some_and(is_past) {
            self.past.pop_front();
        }
        let quantities = self.past.back().map_or(0, |last| last.sums.len());
        (0..quantities)
            .map(|k| {
                let of_all = self.past.iter().filter_map(|interval| interval.sums.get(k));
                let (sum, weight) =
                    of_all.fold((0.0, 0.0), |(sum, weight), of| (sum + of.0, weight + of.1));
                (weight > 0.0).then(|| sum / weight)
            })
            .collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn clock(step: u64, time: f64, next_dt: f32) -> Clock {
        Clock {
            step,
            time,
            next_dt,
            ..Clock::default()
        }
    }

    #[test]
    fn readings_are_at_the_step_ends_nearest_to_the_multiples() {
        let mut timing = Timing::new(Rate::Seconds(0.1));
        let due: Vec<u64> = (1..=100)
            .filter(|&step| timing.is_due(&clock(step, 0.03 * step as f64, 0.03)))
            .collect();
        for (k, step) in (1..).zip(&due) {
            assert!(
                (0.03 * *step as f64 - 0.1 * f64::from(k)).abs() < 0.016,
                "{due:?}"
            );
        }
        assert_eq!(due.len(), 30);
        let mut timing = Timing::new(Rate::Seconds(0.01));
        assert_eq!(
            (1..=10)
                .filter(|&k| timing.is_due(&clock(k, 0.5 * k as f64, 0.5)))
                .count(),
            10
        );
        let mut timing = Timing::new(Rate::Steps(3));
        assert_eq!(
            (1..=10)
                .filter(|&k| timing.is_due(&clock(k, 0.0, 0.1)))
                .count(),
            3
        );
    }

    #[test]
    fn means_weigh_steps_by_their_length_and_forget_what_is_past() {
        let mut window = Window::default();
        window.add(&[Some(1.0), None], 0.1);
        window.add(&[Some(4.0), Some(7.0)], 0.2);
        let means = window.close(0.3, 0.3, 0.01);
        let weighted = (1.0 * 0.1 + 4.0 * 0.2) / 0.3;
        assert!((means[0].unwrap() - weighted).abs() < 1e-12 && means[1] == Some(7.0));
        window.add(&[Some(10.0), None], 0.3);
        let means = window.close(0.6, 0.3, 0.01);
        assert_eq!(means, [Some(10.0), None]);
        window.add(&[Some(20.0), None], 0.3);
        let means = window.close(0.9, 0.6, 0.01);
        assert!((means[0].unwrap() - 15.0).abs() < 1e-12 && means[1].is_none());
    }
}
