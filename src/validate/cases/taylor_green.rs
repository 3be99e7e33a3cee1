//! Taylor–Green vortices in a periodic box.

use std::f64::consts::{PI, TAU};

use glam::{DVec2, Vec3};

use super::texts;
use crate::{
    measure::LineFit,
    scene::Scene,
    validate::{
        Case, Comparison, Figure, Findings, Particle, Runner, Stopped,
        figure::{at, exact_curve},
        particles_of,
    },
};

pub(in crate::validate) const CASE: Case = Case {
    name: "taylor_green",
    title: "Taylor–Green vortices",
    texts: texts!("taylor_green"),
    across: "period",
    resolution: 40,
    resolutions: [20, 40, 80],
    sound_speed: 10.0,
    measure,
};

/// Kinematic viscosity \[m²/s], for a period of 1 m and a speed of 1 m/s.
const NU: f64 = 0.01;
/// When velocities are compared \[s].
const COMPARED: f64 = 0.5;
/// Since when the rate of decay is fitted \[s].
const FITTED: f64 = 0.1;

/// Exact velocity at a place and a time \[m/s].
fn exact(place: Vec3, time: f64) -> DVec2 {
    let (x, y) = (TAU * f64::from(place.x), TAU * f64::from(place.y));
    let speed = (-8.0 * PI * PI * NU * time).exp();
    speed * DVec2::new(x.sin() * y.cos(), -x.cos() * y.sin())
}

/// Root mean square of the distances from the exact velocities, over that of these.
fn error(particles: &[Particle], time: f64) -> f64 {
    let (mut off, mut all) = (0.0, 0.0);
    for particle in particles {
        let known = exact(particle.position, time);
        off += (particle.velocity.truncate().as_dvec2() - known).length_squared();
        all += known.length_squared();
    }
    (off / all).sqrt()
}

fn measure(scene: &Scene, flow: &mut Runner) -> Result<Findings, Stopped> {
    let squares = |particles: &[Particle]| -> f64 {
        let square = |p: &Particle| f64::from(p.velocity.length_squared());
        particles.iter().map(square).sum()
    };
    let start = squares(&particles_of(flow.world()));
    let rest_density = f64::from(scene.fluid.rest_density);
    let mut energy = vec![(0.0, 1.0)];
    let mut fit = LineFit::default();
    let (mut off, mut spread) = (f64::NAN, f64::NAN);
    flow.steps(f64::from(scene.duration), |world, report| {
        let particles = particles_of(world);
        let left = squares(&particles) / start;
        if report.time >= FITTED {
            fit.add(report.time, left.ln(), f64::from(report.dt));
        }
        if report.time >= COMPARED && off.is_nan() {
            off = error(&particles, report.time);
        }
        let distance = |p: &Particle| (f64::from(p.density) / rest_density - 1.0).powi(2);
        let sum: f64 = particles.iter().map(distance).sum();
        spread = (sum / particles.len() as f64).sqrt();
        energy.push((report.time, left));
    })?;
    let rate = 16.0 * PI * PI * NU;
    let known = |t: f64| (-rate * t).exp();
    Ok(Findings {
        figures: vec![
            Figure::exact("rate of decay of the energy [1/s]", -fit.slope(), rate),
            Figure::exact(
                "energy at 0.5 s [its start]",
                at(&energy, COMPARED),
                known(COMPARED),
            ),
            Figure::residual("error of the velocities at 0.5 s [exact ones]", off),
            Figure::residual("spread of the density at the end [rho0]", spread),
        ],
        comparisons: vec![Comparison {
            name: "energy",
            x: "t [s]",
            y: "kinetic energy [its start]",
            measured: energy,
            known: exact_curve(
                "exp(−16 π² ν t)",
                (0..=50).map(|k| f64::from(k) / 50.0).map(|t| (t, known(t))),
            ),
        }],
    })
}
