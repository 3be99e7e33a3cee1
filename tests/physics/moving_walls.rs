//! Walls in prescribed motion: what moves with its walls is at rest in them, what is pushed follows, nothing leaks.

use glam::Vec3;

use crate::support::{measured, particles_of, run, simulation};

/// Every pressure method; speeds of sound above ten times what these scenes reach.
const METHODS: [&str; 4] = [
    "Sesph(equation: Tait(stiffness: 60000))",
    "Pcisph()",
    "Iisph()",
    "Dfsph()",
];

/// Where the particles of a half-filled tank are after 0.1 s, in a frame of its own that moves so fast \[m/s].
fn in_its_frame(dimension: u32, method: &str, speed: Vec3) -> Vec<Vec3> {
    let Vec3 { x, y, z } = speed;
    let motion = if speed == Vec3::ZERO {
        String::new()
    } else {
        format!(", motion: Velocity(velocity: ({x}, {y}, {z}))")
    };
    let deep = if dimension == 2 { 0.0 } else { 0.16 };
    let mut tank = simulation(&format!(
        "(name: \"frame\", dimension: {dimension}, spacing: 0.02, pressure: {method}, time_step: Fixed(0.0005),
          bodies: [(shape: Box(min: (0, 0, 0), max: (0.16, 0.12, {deep})), velocity: ({x}, {y}, {z}),
            velocity_gradient: ((0, 1, 0), (0, 0, 0), (0, 0, 0)))],
          boundaries: [Tank(min: (0, 0, 0), max: (0.24, 0.2, {deep}){motion})])"
    ));
    run(&mut tank, 0.1, |_, _| {});
    let way = tank.time() as f32 * speed;
    let mut particles = particles_of(&mut tank);
    particles.sort_by_key(|particle| particle.entity);
    particles.iter().map(|p| p.position - way).collect()
}

/// A tank that moves at a constant velocity with all its fluid is a tank at rest, to the rounding of 200 steps.
#[test]
fn fluid_that_moves_with_its_tank_is_at_rest_in_it() {
    for (dimension, speed) in [
        (2, Vec3::new(0.5, -0.3, 0.0)),
        (3, Vec3::new(0.3, 0.2, -0.4)),
    ] {
        for method in METHODS {
            let at_rest = in_its_frame(dimension, method, Vec3::ZERO);
            let moving = in_its_frame(dimension, method, speed);
            assert_eq!(at_rest.len(), moving.len());
            let off = at_rest.iter().zip(&moving).map(|(a, b)| a.distance(*b));
            let off = off.fold(0.0, f32::max) / 0.02;
            let figures = format!("{dimension}-D {method}: at most {off:.1e} spacings off");
            measured(&figures);
            assert!(off < 0.02, "{figures}");
        }
    }
}

/// A piston drives a layer of water along a tank for 0.15 m: no particle gets behind its face by more than contact
/// allows (0.25 spacings; 0.11 more at edges), and the water stays at it.
#[test]
fn a_piston_pushes_water_and_lets_none_through() {
    for (dimension, methods) in [(2, &METHODS[..]), (3, &METHODS[3..])] {
        let deep = if dimension == 2 { 0.0 } else { 0.1 };
        for method in methods {
            let mut tank = simulation(&format!(
                "(name: \"piston\", dimension: {dimension}, spacing: 0.02, pressure: {method},
                  bodies: [(shape: Box(min: (0.1, 0, 0), max: (0.5, 0.1, {deep})))],
                  boundaries: [Tank(min: (0, 0, 0), max: (0.8, 0.3, {deep})),
                    Box(min: (0, 0, 0), max: (0.1, 0.3, {deep}),
                      motion: Velocity(velocity: (0.5, 0, 0), start: 0.05, end: 0.35))])"
            ));
            let count = particles_of(&mut tank).len();
            let (mut least, mut most) = (f32::INFINITY, f32::NEG_INFINITY);
            run(&mut tank, 0.4, |tank, report| {
                let face = 0.1 + 0.5 * (report.time as f32).clamp(0.05, 0.35) - 0.025;
                let particles = particles_of(tank);
                assert_eq!(particles.len(), count);
                let first = particles
                    .iter()
                    .map(|p| p.position.x)
                    .fold(f32::INFINITY, f32::min);
                least = least.min((first - face) / 0.02);
                if report.time > 0.1 && report.time < 0.35 {
                    most = most.max((first - face) / 0.02);
                }
            });
            let figures = format!(
                "{dimension}-D {method}: from {least:.3} to {most:.3} spacings before the piston"
            );
            measured(&figures);
            assert!(least > -0.36 && most < 1.5, "{figures}");
        }
    }
}

/// Water that fills a tank without gravity goes where the tank goes, there and back.
#[test]
fn a_full_tank_that_oscillates_takes_its_water_along() {
    for (dimension, methods) in [(2, &METHODS[..]), (3, &METHODS[3..])] {
        let deep = if dimension == 2 { 0.0 } else { 0.12 };
        for method in methods {
            let mut tank = simulation(&format!(
                "(name: \"shaken\", dimension: {dimension}, spacing: 0.02, gravity: (0, 0, 0), pressure: {method},
                  bodies: [(shape: Box(min: (0, 0, 0), max: (0.16, 0.12, {deep})))],
                  boundaries: [Tank(min: (0, 0, 0), max: (0.16, 0.12, {deep}),
                    motion: Oscillation(amplitude: (0.05, 0, 0), frequency: 2, phase: 1.5707963))])"
            ));
            let mut most = 0.0_f32;
            run(&mut tank, 0.5, |tank, report| {
                let phase = 4.0 * std::f64::consts::PI * report.time;
                let way = 0.05 * (phase.cos() - 1.0) as f32;
                let particles = particles_of(tank);
                let sum: f32 = particles.iter().map(|p| p.position.x).sum();
                let mean = sum / particles.len() as f32;
                most = most.max((mean - 0.08 - way).abs() / 0.02);
            });
            let figures = format!("{dimension}-D {method}: {most:.3} spacings off its tank");
            measured(&figures);
            assert!(most < 0.5, "{figures}");
        }
    }
}

/// A gate holds a column of water, and lets it go when it opens.
#[test]
fn a_gate_that_opens_releases_a_dam() {
    for method in METHODS {
        let mut dam = simulation(&format!(
            "(name: \"gate\", dimension: 2, spacing: 0.02, pressure: {method},
              bodies: [(shape: Box(min: (0, 0, 0), max: (0.2, 0.3, 0)))],
              boundaries: [Tank(min: (0, 0, 0), max: (0.8, 0.6, 0)),
                Box(min: (0.2, 0, 0), max: (0.24, 0.4, 0),
                  motion: Velocity(velocity: (0, 1.5, 0), start: 0.1, end: 0.4))])"
        ));
        let (mut held, mut front) = (f32::NEG_INFINITY, f32::NEG_INFINITY);
        run(&mut dam, 0.5, |dam, report| {
            let particles = particles_of(dam);
            front = particles
                .iter()
                .map(|p| p.position.x)
                .fold(f32::NEG_INFINITY, f32::max);
            if report.time <= 0.1 {
                held = held.max(front);
            }
        });
        let figures = format!("{method}: {held:.4} m behind the gate, {front:.3} m after it");
        measured(&figures);
        assert!(held < 0.2 + 0.36 * 0.02 && front > 0.55, "{figures}");
    }
}
