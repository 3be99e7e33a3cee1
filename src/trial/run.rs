//! A trial of a scene: a few steps, and what they did.

use std::collections::BTreeMap;
use std::ops::ControlFlow;
use std::time::Instant;

use bevy_ecs::prelude::*;
use glam::{DVec3, Vec3};

use crate::{
    Simulation, StepReport,
    gauge::Gauges,
    scene::Scene,
    state::{
        Phase, StepError,
        particle::{Fluid, ParticleId, Position},
    },
    step::InstallError,
};

/// When a trial ends.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum End {
    /// After this number of steps.
    Steps(u64),
    /// At this simulated time exactly \[s].
    Time(f64),
}

/// What a trial may take.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Limits {
    /// When it ends.
    pub end: End,
    /// Threads; 0 for all cores.
    pub threads: usize,
    /// Wall time after which it is given up \[s].
    pub seconds: f64,
}

/// What a few steps did.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Trial {
    /// Steps taken.
    pub steps: u64,
    /// Simulated time \[s].
    pub time: f64,
    /// Wall time of every phase in all steps \[s], in the order of [`Phase::ALL`].
    pub phase_seconds: [f64; Phase::ALL.len()],
    /// Pressure iterations of all steps.
    pub iterations: u64,
    /// Iterations of all divergence solves.
    pub divergence_iterations: u64,
    /// Where every particle was at the start and at the end \[m], by its number.
    pub places: BTreeMap<u32, [Vec3; 2]>,
    /// Curves over time \[s], by name: `energy` (kinetic \[J]), `centre_x`, `centre_y`, `centre_z` \[m], and one for
    /// each gauge, of its first column.
    pub curves: BTreeMap<String, Vec<(f64, f64)>>,
    /// Largest mean density error of a step \[-].
    pub mean_density_error: f64,
}

/// Why a trial has no result.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum TrialError {
    /// The caller stopped it.
    #[error("it was interrupted")]
    Asked,
    /// The scene is refused.
    #[error(transparent)]
    Refused(#[from] InstallError),
    /// A step failed.
    #[error(transparent)]
    Failed(#[from] StepError),
    /// The wall time was over.
    #[error("{seconds} s of wall time were not enough: at {time:.4} s after {steps} steps")]
    OutOfTime {
        /// The limit \[s].
        seconds: f64,
        /// Simulated time \[s].
        time: f64,
        /// Steps taken.
        steps: u64,
    },
}

impl Trial {
    /// Wall time of all phases \[s].
    pub fn wall(&self) -> f64 {
        self.phase_seconds.iter().sum()
    }

    /// Wall time per simulated time \[s/s].
    pub fn cost(&self) -> f64 {
        self.wall() / self.time
    }

    /// Root mean square of the particles' ways \[m].
    pub fn way(&self) -> f64 {
        rms(self
            .places
            .values()
            .map(|[start, end]| end.distance(*start)))
    }

    /// Root mean square of the distances of the particles at the end from those of another trial \[m], of the particles
    /// that both have.
    pub fn distance(&self, other: &Self) -> f64 {
        let both = self
            .places
            .iter()
            .filter_map(|(id, own)| Some((own, other.places.get(id)?)));
        rms(both.map(|(own, other)| own[1].distance(other[1])))
    }

    fn add(&mut self, report: &StepReport) {
        (self.steps, self.time) = (report.step, report.time);
        for (sum, seconds) in self.phase_seconds.iter_mut().zip(report.phase_seconds) {
            *sum += seconds;
        }
        self.iterations += u64::from(report.iterations);
        self.divergence_iterations += u64::from(report.divergence_iterations);
        if report.taken_back.is_none() {
            let error = f64::from(report.mean_density_error);
            self.mean_density_error = self.mean_density_error.max(error);
        }
    }
}

fn rms(values: impl Iterator<Item = f32>) -> f64 {
    let (sum, count) = values.fold((0.0, 0.0), |(sum, count), value| {
        (sum + f64::from(value).powi(2), count + 1.0)
    });
    if count > 0.0 {
        (sum / count).sqrt()
    } else {
        0.0
    }
}

/// Runs a trial; `tell` gets the completed fraction after every step, and may stop it.
pub fn run(
    scene: &Scene,
    limits: &Limits,
    tell: &mut dyn FnMut(f64) -> ControlFlow<()>,
) -> Result<Trial, TrialError> {
    let mut simulation = Simulation::with_threads(scene, limits.threads)?;
    let started = Instant::now();
    let mut trial = Trial::default();
    for (id, place) in places(simulation.world_mut()) {
        trial.places.insert(id, [place, place]);
    }
    loop {
        let part = match limits.end {
            End::Steps(steps) => trial.steps as f64 / steps as f64,
            End::Time(time) => trial.time / time,
        };
        // No steps at all are 0/0.
        if part >= 1.0 || part.is_nan() {
            break;
        }
        if tell(part).is_break() {
            return Err(TrialError::Asked);
        }
        if started.elapsed().as_secs_f64() > limits.seconds {
            return Err(TrialError::OutOfTime {
                seconds: limits.seconds,
                time: trial.time,
                steps: trial.steps,
            });
        }
        let report = match limits.end {
            End::Steps(_) => simulation.step()?,
            End::Time(time) => simulation.step_until(time)?,
        };
        trial.add(&report);
        note(&mut trial, &report, simulation.world_mut());
    }
    for (id, place) in places(simulation.world_mut()) {
        let both = trial.places.entry(id).or_insert([place, place]);
        both[1] = place;
    }
    for gauge in scene.gauges.iter().map(|gauge| &gauge.name) {
        let readings =
            (simulation.world().get_resource::<Gauges>()).and_then(|gauges| gauges.get(gauge));
        let Some(readings) = readings else {
            continue;
        };
        let first = readings
            .readings()
            .filter_map(|of| Some((of.time, *of.values.first()?.as_ref()?)));
        trial.curves.insert(gauge.clone(), first.collect());
    }
    Ok(trial)
}

/// Adds a point to the curves.
fn note(trial: &mut Trial, report: &StepReport, world: &mut World) {
    if report.taken_back.is_some() {
        // The state is that before: what came after it is gone.
        for curve in trial.curves.values_mut() {
            curve.retain(|point| point.0 <= report.time);
        }
        return;
    }
    let (mut sum, mut count) = (DVec3::ZERO, 0.0);
    for (_, place) in places(world) {
        sum += place.as_dvec3();
        count += 1.0;
    }
    let centre = sum / f64::max(count, 1.0);
    for (name, value) in [
        ("energy", report.kinetic_energy),
        ("centre_x", centre.x),
        ("centre_y", centre.y),
        ("centre_z", centre.z),
    ] {
        let curve = trial.curves.entry(name.to_owned()).or_default();
        curve.push((report.time, value));
    }
}

/// Numbers and places of the fluid's particles, in the order of their numbers: sums do not depend on tables.
fn places(world: &mut World) -> Vec<(u32, Vec3)> {
    let mut fluid = world.query_filtered::<(&ParticleId, &Position), With<Fluid>>();
    let mut places: Vec<(u32, Vec3)> = fluid.iter(world).map(|(id, x)| (id.get(), x.0)).collect();
    places.sort_unstable_by_key(|place| place.0);
    places
}

#[cfg(test)]
mod tests {
    use super::*;

    fn scene(rest: &str) -> Scene {
        let text = format!(
            "(name: \"t\", dimension: 2, spacing: 0.1, bodies: [(shape: Box(min: (0, 0, 0), max: (0.5, 0.5, 0)))], \
             time_step: Fixed(0.01), {rest})"
        );
        Scene::parse(&text, "t.ron", &[]).unwrap_or_else(|error| panic!("{error}"))
    }

    fn limits(end: End) -> Limits {
        Limits {
            end,
            threads: 1,
            seconds: 60.0,
        }
    }

    /// A block in free fall: its way, its centre and its energy are known.
    #[test]
    fn a_trial_knows_how_far_its_particles_went() {
        let trial =
            |scene: &Scene, end| run(scene, &limits(end), &mut |_| ControlFlow::Continue(()));
        let falling = trial(&scene(""), End::Time(0.1)).expect("a trial");
        assert!((10..=11).contains(&falling.steps) && falling.places.len() == 25);
        // Semi-implicit Euler falls half a step further than g t²/2.
        let way = 0.5 * 9.81 * 0.1 * 0.11;
        assert!(
            (falling.way() / way - 1.0).abs() < 1e-3,
            "{}",
            falling.way()
        );
        let (time, height) = falling.curves["centre_y"][9];
        assert!(
            (time - 0.1).abs() < 1e-6 && (0.25 - height - way).abs() < 1e-4,
            "{height}"
        );
        assert!(falling.distance(&falling) == 0.0 && falling.cost() > 0.0);
        let still = trial(&scene("gravity: (0, 0, 0)"), End::Steps(10)).expect("a trial");
        assert!(
            (still.distance(&falling) / way - 1.0).abs() < 1e-2,
            "{}",
            still.distance(&falling)
        );
    }

    #[test]
    fn a_trial_without_result_says_why() {
        let stopped = run(&scene(""), &limits(End::Steps(5)), &mut |_| {
            ControlFlow::Break(())
        });
        assert!(matches!(stopped, Err(TrialError::Asked)));
        let mut late = limits(End::Steps(u64::MAX));
        late.seconds = 0.0;
        let late = run(&scene(""), &late, &mut |_| ControlFlow::Continue(()));
        assert!(
            late.expect_err("no time")
                .to_string()
                .contains("not enough")
        );
        let failed = run(
            &scene("limits: ()").clone(),
            &limits(End::Time(100.0)),
            &mut |_| ControlFlow::Continue(()),
        );
        assert!(matches!(failed, Err(TrialError::Failed(_))), "{failed:?}");
    }
}
