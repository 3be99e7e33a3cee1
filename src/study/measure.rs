//! Quantities that are measured in a block of steps.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use super::gauge::{GaugeMeasure, Key, Tally};
use crate::{state::Phase, step::StepReport};

/// A quantity of a block.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub enum Measure {
    /// Wall time of some phases per step \[ms].
    Milliseconds(Vec<Phase>),
    /// Steps per second of wall time, all phases included \[1/s].
    UpdatesPerSecond,
    /// Percentage of the wall time that some phases take \[%].
    Share(Vec<Phase>),
    /// Wall time per simulated time \[s/s].
    WallTime,
    /// Wall time per step and fluid particle \[µs].
    MicrosecondsPerParticle,
    /// Fluid particles, averaged over the steps \[-].
    Particles,
    /// Mean length of a step in simulated time \[ms].
    TimeStep,
    /// Pressure iterations per step \[-].
    Iterations,
    /// Density error: compression, averaged over the particles and the steps \[%].
    MeanDensityError,
    /// Largest density error of any particle in any step \[%].
    LargestDensityError,
    /// Entries of all fluid neighbour lists \[-]; no figure if neighbours are not stored.
    Pairs,
    /// Candidates in the cells around the fluid's particles \[-], including each particle itself: the number of
    /// distances that the paper's query computes.
    TestedPairs,
    /// Distances computed per entry \[-].
    TestedRatio,
    /// Distance of the particles from where the baseline variant has them at the end of a turn, root mean square over
    /// the particles \[spacings]. The figure of a row is that of its last turn. Variants need a common start and
    /// steps of one length.
    Distance,
    /// The column of a gauge of the scene.
    Gauge(GaugeMeasure),
}

impl Measure {
    /// Unit of the figures; empty for plain numbers.
    pub fn unit(&self) -> &'static str {
        match self {
            Self::Milliseconds(_) | Self::TimeStep => "ms",
            Self::UpdatesPerSecond => "1/s",
            Self::Share(_) | Self::MeanDensityError | Self::LargestDensityError => "%",
            Self::WallTime => "s/s",
            Self::MicrosecondsPerParticle => "µs",
            Self::Distance => "spacings",
            Self::Gauge(measure) => measure.unit(),
            Self::Particles
            | Self::Iterations
            | Self::Pairs
            | Self::TestedPairs
            | Self::TestedRatio => "",
        }
    }

    /// Whether a larger figure is faster; none for what is no speed.
    pub(super) fn is_rate(&self) -> Option<bool> {
        match self {
            Self::Milliseconds(_) | Self::WallTime | Self::MicrosecondsPerParticle => Some(false),
            Self::UpdatesPerSecond => Some(true),
            _ => None,
        }
    }

    /// Whether the pairs must be counted.
    pub(super) fn counts_pairs(&self) -> bool {
        matches!(self, Self::Pairs | Self::TestedPairs | Self::TestedRatio)
    }

    /// Whether variants must be compared with each other.
    pub(super) fn compares_variants(&self) -> bool {
        matches!(self, Self::Distance)
    }

    /// Whether the median over the blocks represents a row. It does for times per step, which other programs on the
    /// machine disturb. Other figures are computed from all blocks together.
    pub(super) fn is_median(&self) -> bool {
        matches!(
            self,
            Self::Milliseconds(_)
                | Self::UpdatesPerSecond
                | Self::Share(_)
                | Self::MicrosecondsPerParticle
        )
    }

    /// The figure of a block; `None` if the block does not have it.
    pub fn of(&self, block: &Block) -> Option<f64> {
        let steps = block.steps as f64;
        let seconds = |phases: &[Phase]| -> f64 {
            phases
                .iter()
                .map(|&phase| block.phase_seconds[phase as usize])
                .sum()
        };
        let value = match self {
            Self::Milliseconds(phases) => 1e3 * seconds(phases) / steps,
            Self::UpdatesPerSecond => steps / seconds(&Phase::ALL),
            Self::Share(phases) => 100.0 * seconds(phases) / seconds(&Phase::ALL),
            Self::WallTime => seconds(&Phase::ALL) / block.time,
            Self::MicrosecondsPerParticle => 1e6 * seconds(&Phase::ALL) / block.particles,
            Self::Particles => block.particles / steps,
            Self::TimeStep => 1e3 * block.time / steps,
            Self::Iterations => block.iterations as f64 / steps,
            Self::MeanDensityError => 100.0 * block.mean_density_errors / steps,
            Self::LargestDensityError => 100.0 * f64::from(block.max_density_error),
            Self::Pairs => block.pairs? / block.counts,
            Self::TestedPairs => block.tested_pairs / block.counts,
            Self::TestedRatio => block.tested_pairs / block.pairs?,
            Self::Distance => block.distance?,
            Self::Gauge(measure) => block
                .gauges
                .get(&measure.key())?
                .figure(measure.statistic)?,
        };
        value.is_finite().then_some(value)
    }
}

/// Sums over consecutive steps.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Block {
    /// Steps taken.
    pub steps: u64,
    /// Simulated time \[s].
    pub time: f64,
    /// Wall time of each phase \[s], in the order of [`Phase::ALL`].
    pub phase_seconds: [f64; Phase::ALL.len()],
    /// Fluid particles, summed over the steps.
    pub particles: f64,
    /// Pressure iterations.
    pub iterations: u64,
    /// Sum of the steps' mean density errors \[-].
    pub mean_density_errors: f64,
    /// Largest density error \[-].
    pub max_density_error: f32,
    /// Number of counts of pairs, one at the end of each block.
    pub counts: f64,
    /// Entries of fluid neighbour lists, summed over all counts; `None` if they are not stored.
    pub pairs: Option<f64>,
    /// Distances computed, summed over all counts.
    pub tested_pairs: f64,
    /// Distance from the baseline at the end \[spacings], if it is measured.
    pub distance: Option<f64>,
    /// Statistics of the gauges that are measured.
    pub(super) gauges: BTreeMap<Key, Tally>,
    /// Steps of the previous block that were rolled back in this one and are not repeated yet.
    pub(super) owed: u64,
}

/// The last good step: it may still be rolled back.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub(super) struct LastStep {
    dt: f32,
    mean_density_error: f32,
    /// Largest density error of its block without this step \[-].
    largest_before: f32,
}

impl Default for Block {
    fn default() -> Self {
        Self {
            steps: 0,
            time: 0.0,
            phase_seconds: Default::default(),
            particles: 0.0,
            iterations: 0,
            mean_density_errors: 0.0,
            max_density_error: 0.0,
            counts: 0.0,
            pairs: Some(0.0),
            tested_pairs: 0.0,
            distance: None,
            gauges: BTreeMap::new(),
            owed: 0,
        }
    }
}

impl Block {
    /// Adds a step, or removes steps that were rolled back. Their cost, wall time and iterations, stays in the block.
    ///
    /// `last` is the previous step, of this block or of the one before it.
    pub(super) fn add(&mut self, report: &StepReport, last: &mut LastStep) {
        match &report.taken_back {
            None => {
                *last = LastStep {
                    dt: report.dt,
                    mean_density_error: report.mean_density_error,
                    largest_before: self.max_density_error,
                };
                match self.owed {
                    0 => {
                        self.steps += 1;
                        self.particles += report.particles as f64;
                    }
                    _ => self.owed -= 1,
                }
                self.time += f64::from(report.dt);
                self.mean_density_errors += f64::from(report.mean_density_error);
                self.max_density_error = self.max_density_error.max(report.max_density_error);
            }
            // The step that failed was never added; the one before it was.
            Some(taken_back) if taken_back.steps > 1 => {
                match self.steps {
                    0 => self.owed += 1,
                    _ => {
                        self.particles *= 1.0 - 1.0 / self.steps as f64;
                        self.steps -= 1;
                        self.max_density_error = last.largest_before;
                    }
                }
                self.time -= f64::from(last.dt);
                self.mean_density_errors -= f64::from(last.mean_density_error);
            }
            Some(_) => {}
        }
        self.iterations += u64::from(report.iterations);
        for (sum, seconds) in self.phase_seconds.iter_mut().zip(report.phase_seconds) {
            *sum += seconds;
        }
    }

    /// The sum of all blocks.
    pub(super) fn together(blocks: &[Self]) -> Self {
        blocks.iter().fold(Self::default(), |mut sum, block| {
            sum.steps += block.steps;
            sum.time += block.time;
            sum.particles += block.particles;
            sum.iterations += block.iterations;
            sum.mean_density_errors += block.mean_density_errors;
            sum.max_density_error = sum.max_density_error.max(block.max_density_error);
            sum.counts += block.counts;
            sum.pairs = sum.pairs.zip(block.pairs).map(|(sum, pairs)| sum + pairs);
            sum.tested_pairs += block.tested_pairs;
            sum.distance = block.distance.or(sum.distance);
            for (key, tally) in &block.gauges {
                sum.gauges.entry(key.clone()).or_default().join(tally);
            }
            for (sum, seconds) in sum.phase_seconds.iter_mut().zip(block.phase_seconds) {
                *sum += seconds;
            }
            sum
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::state::FailureCause;
    use crate::state::TakenBack;

    fn good(dt: f32, error: f32) -> StepReport {
        StepReport {
            dt,
            iterations: 5,
            particles: 7,
            max_density_error: error,
            mean_density_error: error,
            ..StepReport::default()
        }
    }

    fn back(steps: u32) -> StepReport {
        let taken_back = TakenBack {
            steps,
            cause: FailureCause::LeftDomain,
            particle: None,
        };
        StepReport {
            taken_back: Some(taken_back),
            ..good(8.0, 9.0)
        }
    }

    #[test]
    fn steps_taken_back_cost_and_do_not_count() {
        let mut last = LastStep::default();
        let mut block = Block::default();
        for report in [
            good(1.0, 0.25),
            good(1.0, 0.5),
            back(2),
            good(0.5, 0.125),
            back(1),
            good(0.5, 0.125),
        ] {
            block.add(&report, &mut last);
        }
        assert_eq!((block.steps, block.time, block.iterations), (3, 2.0, 30));
        assert_eq!(Measure::Particles.of(&block), Some(7.0));
        assert_eq!(
            (block.mean_density_errors, block.max_density_error),
            (0.5, 0.25)
        );
    }

    #[test]
    fn a_step_of_the_block_before_that_is_taken_back_is_paid_for_in_the_next() {
        let mut last = LastStep::default();
        let (mut first, mut second) = (Block::default(), Block::default());
        first.add(&good(1.0, 0.5), &mut last);
        first.add(&good(1.0, 0.5), &mut last);
        for report in [back(2), good(0.5, 0.25), good(0.5, 0.25), good(1.0, 0.25)] {
            second.add(&report, &mut last);
        }
        let both = Block::together(&[first, second]);
        assert_eq!((both.steps, both.time), (4, 3.0));
        assert_eq!(both.mean_density_errors, 0.5 + 0.75);
    }
}
