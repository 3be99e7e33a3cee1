//! A manufactured solution: a layer that slides over itself, with the force that this flow needs.

use std::f64::consts::{PI, TAU};

use super::texts;
use crate::{
    scene::Scene,
    validate::{
        Case, Comparison, Figure, Findings, Particle, Runner, Stopped,
        figure::exact_curve,
        particles::{particles_of, set_velocities},
    },
};

pub(in crate::validate) const CASE: Case = Case {
    name: "manufactured_solution",
    title: "A manufactured solution: a layer that slides over itself",
    texts: texts!("manufactured_solution"),
    across: "depth",
    resolution: 32,
    resolutions: [16, 32, 64],
    sound_speed: 10.0, // 10 sqrt(g H)
    measure,
};

/// Depth \[m], and wave numbers along y and x \[rad/m].
const DEPTH: f64 = 1.0;
const Q: f64 = PI;
const K: f64 = TAU;
/// Largest speed \[m/s].
const SPEED: f64 = 0.5;
/// Amplitude of the uneven pressure over the density \[m²/s²].
const UNEVEN: f64 = 0.1;
/// Density \[kg/m³], and gravity \[m/s²].
const RHO: f64 = 1000.0;
const GRAVITY: f64 = 1.0;
/// Layers of the profile.
const LAYERS: usize = 16;

fn velocity(y: f64) -> f64 {
    SPEED * (Q * y).cos()
}

/// The part of the pressure that is not that of water at rest, over its amplitude \[-].
fn uneven(x: f64, y: f64) -> f64 {
    (K * x).sin() * (Q * y).sin()
}

/// Sums over steps and particles, each weighted with the length of its step.
#[derive(Default)]
struct Sums {
    weights: f64,
    velocities_off: f64,
    /// Of velocities along cos qy, and of its squares.
    shear: [f64; 2],
    inside: f64,
    pressures_off: f64,
    /// Of pressures along sin kx sin qy, and of its squares.
    uneven: [f64; 2],
    /// Weights, heights and velocities of the layers.
    layers: [[f64; 3]; LAYERS],
}

impl Sums {
    /// A particle at the end of a step.
    fn add_velocity(&mut self, particle: &Particle, dt: f64) {
        let (y, v) = (
            f64::from(particle.position.y),
            particle.velocity.truncate().as_dvec2(),
        );
        let known = velocity(y);
        self.weights += dt;
        self.velocities_off += dt * ((v.x - known).powi(2) + v.y * v.y);
        let shape = (Q * y).cos();
        self.shear[0] += dt * v.x * shape;
        self.shear[1] += dt * shape * shape;
        let layer = (y / DEPTH * LAYERS as f64).clamp(0.0, LAYERS as f64 - 1.0) as usize;
        let layer = &mut self.layers[layer];
        layer[0] += dt;
        layer[1] += dt * y;
        layer[2] += dt * v.x;
    }

    /// A particle that was at a place when its pressure \[Pa] was computed.
    fn add_pressure(&mut self, (x, y): (f64, f64), pressure: f64, dt: f64) {
        let shape = uneven(x, y);
        let rest = pressure - RHO * GRAVITY * (DEPTH - y);
        self.inside += dt;
        self.pressures_off += dt * (rest - RHO * UNEVEN * shape).powi(2);
        self.uneven[0] += dt * rest * shape;
        self.uneven[1] += dt * shape * shape;
    }
}

fn measure(scene: &Scene, flow: &mut Runner) -> Result<Findings, Stopped> {
    set_velocities(flow.world(), |x| {
        glam::Vec3::X * velocity(f64::from(x.y)) as f32
    });
    let end = f64::from(scene.duration);
    let margin = 2.0 * f64::from(scene.spacing);
    let mut sums = Sums::default();
    // Density and pressure belong to the positions at the start of a step.
    let mut before = particles_of(flow.world());
    flow.steps(end, |world, report| {
        let after = particles_of(world);
        if report.time > 0.5 * end {
            let dt = f64::from(report.dt);
            for (start, particle) in before.iter().zip(&after) {
                sums.add_velocity(particle, dt);
                let (x, y) = (f64::from(start.position.x), f64::from(start.position.y));
                // A reordering changes rows.
                if start.entity == particle.entity && y > margin && y < DEPTH - margin {
                    sums.add_pressure((x, y), particle.pressure.into(), dt);
                }
            }
        }
        before = after;
    })?;
    let layers = sums.layers.iter().filter(|layer| layer[0] > 0.0);
    let profile = layers.map(|[w, y, v]| (y / w, v / w)).collect();
    let shear = sums.shear[0] / sums.shear[1];
    let pressure = sums.uneven[0] / sums.uneven[1];
    let velocities_off = (sums.velocities_off / sums.weights).sqrt() / SPEED;
    let pressures_off = (sums.pressures_off / sums.inside).sqrt() / (RHO * GRAVITY * DEPTH);
    Ok(Findings {
        figures: vec![
            Figure::exact("amplitude of the shear [m/s]", shear, SPEED),
            Figure::exact(
                "amplitude of the uneven pressure [Pa]",
                pressure,
                RHO * UNEVEN,
            ),
            Figure::residual("error of the velocities [largest]", velocities_off),
            Figure::residual("error of the pressures [rho g H]", pressures_off),
        ],
        comparisons: vec![Comparison {
            name: "profile",
            x: "height above the floor [m]",
            y: "mean velocity [m/s]",
            measured: profile,
            known: exact_curve(
                "U cos qy",
                (0..=40)
                    .map(|k| f64::from(k) / 40.0)
                    .map(|y| (y, velocity(y))),
            ),
        }],
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{
        scene::BodyForce,
        validate::{METHODS, Method},
    };
    use glam::{DVec2, Vec3};

    /// The scene's forces are what the flow needs: by differences of its velocity and pressure.
    #[test]
    fn the_forces_of_the_scene_hold_the_flow() {
        let method: &Method = &METHODS[0];
        let scene = CASE.scene(method, CASE.resolution).expect("a scene");
        let nu = 0.02;
        let step = 1e-4;
        let pressure = |x: f64, y: f64| GRAVITY * (DEPTH - y) + UNEVEN * uneven(x, y);
        for k in 0..30 {
            let k = f64::from(k);
            let (x, y) = (0.5 + 0.5 * (1.3 * k).sin(), 0.5 + 0.5 * (2.1 * k).cos());
            let slope = DVec2::new(
                pressure(x + step, y) - pressure(x - step, y),
                pressure(x, y + step) - pressure(x, y - step),
            ) / (2.0 * step);
            let bend = (velocity(y + step) - 2.0 * velocity(y) + velocity(y - step)) / step.powi(2);
            let needed = slope - nu * bend * DVec2::X;
            let place = Vec3::new(x as f32, y as f32, 0.0);
            let waves = scene.body_forces.iter().map(|force| match force {
                BodyForce::Wave(wave) => wave.mean(place, 0.0, 0.0),
                _ => Vec3::ZERO,
            });
            let all = waves.sum::<Vec3>() + scene.gravity;
            let off = all.truncate().as_dvec2().distance(needed);
            assert!(off < 1e-5, "({x}, {y}): {all}, not {needed}");
        }
    }
}
