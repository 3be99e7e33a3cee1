//! Runs of the cases, and their measurements.

use bevy_ecs::prelude::*;
use glam::Vec3;
use overfall::{
    Simulation, StepReport,
    measure::semi_axes,
    scene::{Dimension, Scene},
    state::{
        Material,
        particle::{Fluid, Position, Velocity},
    },
};

use super::{GRAVITY, Outcome, centre_pressure::CentrePressure, residual::Residual};
use crate::support::{particles_of, reference};

/// Takes steps to a time; returns an error message on failure.
fn run(
    simulation: &mut Simulation,
    time: f64,
    mut observe: impl FnMut(&mut Simulation, &StepReport),
) -> Outcome {
    let mut outcome = Outcome::default();
    while simulation.time() < time {
        match simulation.step() {
            Ok(report) => {
                outcome.steps += 1;
                outcome.iterations +=
                    u64::from(report.iterations) + u64::from(report.divergence_iterations);
                observe(simulation, &report);
            }
            Err(error) => {
                outcome.failure = Some(error.to_string());
                break;
            }
        }
    }
    outcome
}

/// Largest speed at any time and at the end, root mean square at the end, in sqrt(g H); energy gained in m g H. Over
/// the second half: pressure of the lowest row divided by that of the water above it, its mean and its deviations in
/// time and along the floor.
pub(super) fn at_rest(
    simulation: &mut Simulation,
    scene: &Scene,
    [depth, time]: [f64; 2],
) -> Outcome {
    let scale = (GRAVITY * depth).sqrt();
    let (mut fastest, mut last, mut rms, mut early) = (0.0f64, 0.0, 0.0, f64::NAN);
    let (mut energy, mut gained, mut error) = (None, 0.0f64, 0.0f64);
    let (mut floor, mut weights) = ([0.0; 2], 0.0);
    let dx = f64::from(scene.spacing);
    let mut outcome = run(simulation, time, |simulation, report| {
        if report.time > 0.5 * time {
            for particle in particles_of(simulation) {
                let y = f64::from(particle.position.y);
                if y < 0.8 * dx {
                    let p = f64::from(particle.pressure) / (1000.0 * GRAVITY * (depth - y));
                    let dt = f64::from(report.dt);
                    floor = [floor[0] + dt * p, floor[1] + dt * p * p];
                    weights += dt;
                }
            }
        }
        last = f64::from(report.max_speed) / scale;
        fastest = fastest.max(last);
        error = error.max(f64::from(report.max_density_error));
        let total = report.kinetic_energy + report.potential_energy;
        // The height of the centre is half that of the surface.
        let start = *energy.get_or_insert(total);
        gained = gained.max((total - start) / start.abs());
        let mass = report.particles as f64;
        rms = (2.0 * report.kinetic_energy / mass).sqrt() / scale;
        if report.time <= 2.0 {
            early = rms;
        }
    });
    // Per mass of a particle: the mean speed does not depend on the number of particles.
    let mass = particle_mass(simulation).sqrt();
    outcome.figures = vec![
        ("fastest", fastest),
        ("at end", last),
        ("rms 2 s", early / mass),
        ("rms", rms / mass),
        ("gained", gained),
        ("compressed", error),
        ("floor", floor[0] / weights),
        (
            "floor noise",
            (floor[1] / weights - (floor[0] / weights).powi(2)).sqrt(),
        ),
    ];
    outcome
}

fn particle_mass(simulation: &Simulation) -> f64 {
    f64::from(simulation.world().resource::<Material>().particle_mass)
}

/// Rise of energy above its minimum, and the front at 0.2 s.
pub(super) fn collapse(simulation: &mut Simulation, height: f64, time: f64) -> Outcome {
    let (mut least, mut rise, mut step_rise, mut start) = (f64::INFINITY, 0.0f64, 0.0f64, None);
    let (mut front, mut before, mut error) = (f64::NAN, f64::NAN, 0.0f64);
    let mut mean = 0.0;
    let mut outcome = run(simulation, time, |simulation, report| {
        let energy = report.kinetic_energy + report.potential_energy;
        let scale = *start.get_or_insert(energy);
        least = least.min(energy);
        rise = rise.max((energy - least) / scale);
        if before.is_finite() {
            step_rise = step_rise.max((energy - before) / scale);
        }
        before = energy;
        error = error.max(f64::from(report.max_density_error));
        mean += f64::from(report.mean_density_error) * f64::from(report.dt);
        if front.is_nan() && report.time >= 0.2 {
            let x = particles_of(simulation).into_iter().map(|p| p.position.x);
            front = f64::from(x.fold(0.0, f32::max)) / (0.5 * height);
        }
    });
    outcome.figures = vec![
        ("rise", rise),
        ("step rise", step_rise),
        ("energy", before / start.unwrap_or(f64::NAN)),
        ("front 0.2 s", front),
        ("compressed", error),
        ("mean", mean / simulation.time().max(1e-9)),
    ];
    outcome
}

/// Pressure in deep fluid minus a plane through its neighbours, over the mean pressure, and its correlation at one
/// spacing.
pub(super) fn sloshing(
    simulation: &mut Simulation,
    scene: &Scene,
    [from, to]: [f64; 2],
) -> Outcome {
    let volume = scene.dimension == Dimension::Three;
    let (mut residual, mut next) = (Residual::default(), from);
    let mut outcome = run(simulation, to, |simulation, report| {
        if report.time >= next {
            residual.add(&particles_of(simulation), scene.spacing, volume);
            next += 0.1;
        }
    });
    let [share, correlation] = residual.figures();
    outcome.figures = vec![("residual", share), ("correlation", correlation)];
    outcome
}

/// Semi-major axis at 7.6 ms over the exact one, the change of energy, and the pressure around the centre over the
/// exact one, in the second half.
pub(super) fn elliptic_drop(simulation: &mut Simulation) -> Outcome {
    let world = simulation.world_mut();
    let mut particles = world.query_filtered::<(&Position, &mut Velocity), With<Fluid>>();
    for (x, mut v) in particles.iter_mut(world) {
        v.0 = Vec3::new(-100.0 * x.0.x, 100.0 * x.0.y, 0.0);
    }
    let rows = reference("elliptic_drop_analytic.csv", ["t_s", "b"]);
    let known = rows
        .windows(2)
        .find(|pair| pair[1][0] >= 0.0076)
        .map_or(f64::NAN, |pair| {
            let part = (0.0076 - pair[0][0]) / (pair[1][0] - pair[0][0]);
            pair[0][1] + part * (pair[1][1] - pair[0][1])
        });
    let (mut start, mut low, mut high) = (None, 0.0f64, 0.0f64);
    let mut ends = [[f64::NAN; 2]; 2];
    let (mut exact, mut pressures) = (CentrePressure::new(100.0), [0.0; 2]);
    let mut outcome = run(simulation, 0.0076, |simulation, report| {
        // Pressures are those of the start of the step.
        if report.time > 0.0038 {
            for particle in particles_of(simulation) {
                let known = exact.at([particle.position.x, particle.position.y].map(f64::from));
                if let Some(known) = known {
                    pressures = [
                        pressures[0] + f64::from(particle.pressure),
                        pressures[1] + 1000.0 * known,
                    ];
                }
            }
        }
        exact.advance(f64::from(report.dt));
        let energy = report.kinetic_energy;
        let change = energy / *start.get_or_insert(energy) - 1.0;
        (low, high) = (low.min(change), high.max(change));
        if report.time > 0.0074 {
            let [_, b] = semi_axes(particles_of(simulation).iter().map(|p| p.position));
            ends = [ends[1], [report.time, b]];
        }
    });
    let [[t0, b0], [t1, b1]] = ends;
    let axis = b0 + (0.0076 - t0) / (t1 - t0) * (b1 - b0);
    outcome.figures = vec![
        ("axis error %", 100.0 * (axis / known - 1.0)),
        ("energy least %", 100.0 * low),
        ("energy most %", 100.0 * high),
        ("centre pressure", pressures[0] / pressures[1]),
    ];
    outcome
}

/// Fraction of the mode's energy that is lost per period.
///
/// The mode is the displacement of linear theory. Its amplitude is the projection of the particles' displacements from
/// the lattice on the cosine of the surface; its energy is the square of the peaks.
pub(super) fn standing_wave(simulation: &mut Simulation) -> Outcome {
    let k = std::f64::consts::PI;
    let amplitude = 0.05;
    let world = simulation.world_mut();
    let mut particles = world.query_filtered::<&mut Position, With<Fluid>>();
    for mut x in particles.iter_mut(world) {
        let [px, py] = [f64::from(x.0.x), f64::from(x.0.y)];
        let scale = amplitude / k.sinh();
        x.0.x -= (scale * (k * px).sin() * (k * py).cosh()) as f32;
        x.0.y += (scale * (k * px).cos() * (k * py).sinh()) as f32;
    }
    let period = std::f64::consts::TAU / (GRAVITY * k * k.tanh()).sqrt();
    let mut series: Vec<(f64, f64)> = Vec::new();
    let mut outcome = run(simulation, 3.2 * period, |simulation, report| {
        let particles = particles_of(simulation);
        let count = particles.len() as f64;
        let mode: f64 = particles
            .iter()
            .map(|p| f64::from(p.position.y) * (k * f64::from(p.position.x)).cos())
            .sum();
        series.push((report.time, 2.0 * mode / count));
    });
    // Peaks of either sign, half a period apart.
    let peak = |from: f64, to: f64| {
        let within = series.iter().filter(|(t, _)| (from..to).contains(t));
        within.fold((0.0, 0.0f64), |best, &(t, a)| {
            if a.abs() > best.1 { (t, a.abs()) } else { best }
        })
    };
    let at = |n: f64| peak((n - 0.2) * period, (n + 0.2) * period);
    let (half, first, third) = (at(0.5), at(1.0), at(3.0));
    let lost = |ratio: f64, periods: f64| 1.0 - ratio.powf(2.0 / periods);
    outcome.figures = vec![
        ("lost per period %", 100.0 * lost(third.1 / first.1, 2.0)),
        ("in the first %", 100.0 * lost(first.1 / half.1, 0.5)),
        ("period", (third.0 - first.0) / (2.0 * period)),
    ];
    outcome
}
