//! A blob of fluid in free flight: forces between particles must not move or turn the whole.
//!
//! Semi-implicit Euler follows its own parabola, `x(t) = x0 + v0 t + g t (t + dt)/2`, exactly at every step. Since
//! `x_{n+1} × v_{n+1} = x_n × v_{n+1}`, central forces that are equal and opposite also conserve the angular momentum
//! exactly. Only rounding in f32 remains.

use glam::{DVec3, Vec3};

use crate::support::{
    Particle, measured, particles_of, rigid_motion, run, set_velocities, simulation,
};

const DT: f32 = 5e-4;
const STEPS: u32 = 300;
const VELOCITY: Vec3 = Vec3::new(1.5, 2.0, -0.5);
/// \[1/s]
const SPIN: Vec3 = Vec3::new(1.0, -2.0, 5.0);

/// Fluid models whose momenta must be conserved.
const LAMINAR: &str = "Laminar(kinematic_viscosity: 0.005)";
const ARTIFICIAL: &str = "Artificial(alpha: 0.2, sound_speed: 10)";
const TAIT: &str = "Sesph((equation: Tait(stiffness: 10000)))";
const GAS: &str = "Sesph((equation: Gas(stiffness: 50)))";
// A step removes all compression at once, so that there are forces to be balanced.
const PCISPH: &str = "Pcisph((max_density_error: 0.005, recovery: 1))";
const IISPH: &str = "Iisph((max_density_error: 0.0005))";
const DFSPH: &str = "Dfsph((max_density_error: 0.0005))";

/// A ball (a disc in 2-D) with a jittered lattice, thrown and spun, with viscosity and surface tension.
/// Tolerances are relative to the speed of the motion (2.6 m/s) and the size of the blob. A velocity is rounded to 6e-8
/// of its size in every step, in directions that do not add up. So the mean of hundreds of particles over 300 steps is
/// well within 1e-6 × 2.6 m/s, and positions are within 1e-6 m. Angular momentum: 1e-5 of its initial value, because
/// its lever arms are short compared with the rounded positions.
#[track_caller]
fn momenta_are_kept(dimension: u32, pressure: &str, viscosity: &str) {
    let flat = |v: Vec3| if dimension == 2 { v.with_z(0.0) } else { v };
    let gravity = flat(Vec3::new(1.0, -9.81, 2.0));
    let kappa = if dimension == 2 { "0.05" } else { "0.002" };
    let mut blob = simulation(&format!(
        "(name: \"blob\", dimension: {dimension}, spacing: 0.02, time_step: Fixed({DT}),
          gravity: ({}, {}, {}), pressure: {pressure},
          fluid: (viscosity: {viscosity}, surface_tension: BeckerTeschner(kappa: {kappa})),
          bodies: [(shape: Sphere(center: (0, 0, 0), radius: 0.1), jitter: (amplitude: 0.15, seed: 7))])",
        gravity.x, gravity.y, gravity.z
    ));
    let spin = if dimension == 2 { SPIN * Vec3::Z } else { SPIN };
    set_velocities(&mut blob, |x| flat(VELOCITY) + spin.cross(x));
    let particles = particles_of(&mut blob);
    let start = rigid_motion(&particles);
    let speeds = |particles: &[Particle], mean: DVec3| {
        let squares: f64 = particles
            .iter()
            .map(|p| (p.velocity.as_dvec3() - mean).length_squared())
            .sum();
        (squares / particles.len() as f64).sqrt()
    };
    let inner_start = speeds(&particles, start.velocity);

    let (mut velocity_error, mut center_error, mut turn_error) = (0.0_f64, 0.0_f64, 0.0_f64);
    run(
        &mut blob,
        f64::from(DT) * (f64::from(STEPS) - 0.5),
        |blob, report| {
            let now = rigid_motion(&particles_of(blob));
            let (t, dt, g) = (report.time, f64::from(report.dt), gravity.as_dvec3());
            let velocity = start.velocity + g * t;
            let center = start.center + start.velocity * t + g * (0.5 * t * (t + dt));
            velocity_error = velocity_error.max((now.velocity - velocity).length());
            center_error = center_error.max((now.center - center).length());
            let turned = now.angular_momentum - start.angular_momentum;
            turn_error = turn_error.max(turned.length() / start.angular_momentum.length());
        },
    );
    let particles = particles_of(&mut blob);
    let inner_end = speeds(&particles, rigid_motion(&particles).velocity);
    let figures = format!(
        "{dimension}-D {pressure} {viscosity}: velocity off by {velocity_error:.1e} m/s, centre by {center_error:.1e} \
         m, angular momentum by {turn_error:.1e}; {} particles, speeds within the blob {inner_start:.2} to \
         {inner_end:.2} m/s",
        particles.len()
    );
    measured(&figures);
    // There were forces to be balanced: the motion inside the blob has changed.
    assert!((inner_end - inner_start).abs() > 1e-3, "{figures}");
    assert!(velocity_error < 2.6e-6, "{figures}");
    assert!(center_error < 1e-6, "{figures}");
    assert!(turn_error < 1e-5, "{figures}");
}

#[test]
fn sesph_with_tait_and_artificial_viscosity_keeps_momenta() {
    momenta_are_kept(2, TAIT, ARTIFICIAL);
    momenta_are_kept(3, TAIT, ARTIFICIAL);
}

#[test]
fn sesph_with_gas_and_artificial_viscosity_keeps_momenta() {
    momenta_are_kept(2, GAS, ARTIFICIAL);
    momenta_are_kept(3, GAS, ARTIFICIAL);
}

#[test]
fn pcisph_with_artificial_viscosity_keeps_momenta() {
    momenta_are_kept(2, PCISPH, ARTIFICIAL);
    momenta_are_kept(3, PCISPH, ARTIFICIAL);
}

#[test]
fn sesph_with_tait_and_laminar_viscosity_keeps_momenta() {
    momenta_are_kept(2, TAIT, LAMINAR);
    momenta_are_kept(3, TAIT, LAMINAR);
}

#[test]
fn sesph_with_gas_and_laminar_viscosity_keeps_momenta() {
    momenta_are_kept(2, GAS, LAMINAR);
    momenta_are_kept(3, GAS, LAMINAR);
}

#[test]
fn pcisph_with_laminar_viscosity_keeps_momenta() {
    momenta_are_kept(2, PCISPH, LAMINAR);
    momenta_are_kept(3, PCISPH, LAMINAR);
}

#[test]
fn iisph_keeps_momenta() {
    momenta_are_kept(2, IISPH, LAMINAR);
    momenta_are_kept(3, IISPH, ARTIFICIAL);
}

#[test]
fn dfsph_keeps_momenta() {
    momenta_are_kept(2, DFSPH, LAMINAR);
    momenta_are_kept(3, DFSPH, ARTIFICIAL);
}
