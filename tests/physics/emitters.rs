//! Fluid that enters: jets keep their speed and fall along parabolas, tanks fill at the rate of the flow, and no
//! pressure is where there should be none. All known results are exact.

use bevy_ecs::prelude::*;
use glam::{DVec3, Vec3};
use overfall::{
    Simulation,
    gauge::Gauges,
    state::particle::{Fluid, ParticleId, Position, Pressure, Velocity},
};

use crate::support::{METHODS, Method, measured, scene};

/// A particle: number, place, velocity, pressure.
type One = (u32, Vec3, Vec3, f32);

/// All methods but δ-SPH, which takes no emitters.
fn methods() -> impl Iterator<Item = Method> {
    METHODS.into_iter().filter(|method| method.name != "δ-SPH")
}

/// On one thread: these scenes are small.
fn simulation(text: &str) -> Simulation {
    Simulation::with_threads(&scene(text), 1).unwrap_or_else(|error| panic!("{error}"))
}

/// All fluid, by number.
fn particles(simulation: &mut Simulation) -> Vec<One> {
    type Parts<'w> = (&'w ParticleId, &'w Position, &'w Velocity, &'w Pressure);
    let world = simulation.world_mut();
    let mut fluid = world.query_filtered::<Parts, With<Fluid>>();
    let mut found: Vec<_> = (fluid.iter(world))
        .map(|(id, x, v, p)| (id.get(), x.0, v.0, p.0))
        .collect();
    found.sort_by_key(|particle| particle.0);
    found
}

/// Speed of the jets \[m/s].
const SPEED: f64 = 2.0;

/// Fluid that enters at the origin along +x, through a square (in 2-D a segment) of 8 spacings.
fn jet(dimension: u8, spacing: f32, method: &Method) -> String {
    let size = 8.0 * spacing;
    let height = match dimension {
        2 => String::new(),
        _ => format!(", height: {size}"),
    };
    format!(
        "(name: \"jet\", dimension: {dimension}, spacing: {spacing}, pressure: {}, bodies: [],
        emitters: [(shape: Rectangle(center: (0, 0, 0), normal: (1, 0, 0), width: {size}{height}), speed: {SPEED})])",
        (method.pressure)(10.0 * SPEED as f32)
    )
}

/// Each layer falls like a point thrown from the face, and no pressure acts on a jet that falls freely. Forces count
/// from the face on to the part of a step, so what remains is the error of the scheme: semi-implicit Euler is
/// ½ g dt t below the parabola.
#[test]
fn a_jet_in_free_air_keeps_its_speed_and_falls_along_a_parabola() {
    for dimension in [2, 3] {
        for spacing in [0.02, 0.01_f32] {
            for method in methods() {
                let text = jet(dimension, spacing, &method);
                let plan = overfall::plan(&scene(&text)).expect("a plan");
                let (layer, pitch) = (plan.emitters[0].layer, plan.emitters[0].pitch);
                let mut simulation = simulation(&text);
                let (mut error, mut longest, mut highest) = (0.0_f32, 0.0_f32, 0.0_f32);
                while simulation.time() < 0.25 {
                    let report = simulation.step().unwrap_or_else(|error| panic!("{error}"));
                    error = error.max(report.max_density_error);
                    longest = longest.max(report.dt);
                    let pressures = particles(&mut simulation).into_iter().map(|one| one.3);
                    highest = pressures.fold(highest, f32::max);
                }
                let (mut off, mut drift) = (0.0_f64, 0.0_f64);
                let all = particles(&mut simulation);
                for (k, layer) in all.chunks_exact(layer).enumerate() {
                    let mean = |value: fn(&One) -> Vec3| {
                        let sum: DVec3 = layer.iter().map(|one| value(one).as_dvec3()).sum();
                        sum / layer.len() as f64
                    };
                    let way = SPEED * simulation.time() - (k as f64 + 0.5) * pitch;
                    let fallen = 0.5 * 9.81 * (way / SPEED).max(0.0).powi(2);
                    off = off.max((mean(|one| one.1) - DVec3::new(way, -fallen, 0.0)).length());
                    drift = drift.max((mean(|one| one.2).x - SPEED).abs());
                }
                let scheme = 0.5 * 9.81 * f64::from(longest) * simulation.time();
                measured(&format!(
                    "{} in {dimension}-D, spacing {spacing}: {off:.2e} m off the parabola ({scheme:.2e} m by the \
                     scheme), speed {drift:.2e} m/s off, density error {error:.2e}, pressure up to {highest:.2e} Pa",
                    method.name
                ));
                assert!(off <= 1.02 * scheme, "{}: {off} {scheme}", method.name);
                assert!(drift <= 5e-4 * SPEED, "{}: {drift}", method.name);
                // 1 % of the stagnation pressure; half a thousandth of the density at most is the method's own error.
                let stagnation = 0.5 * 1000.0 * (SPEED * SPEED) as f32;
                assert!(highest <= 0.01 * stagnation, "{}: {highest}", method.name);
                assert!(error <= 5e-4, "{}: {error}", method.name);
            }
        }
    }
}

/// Fluid enters for 0.8 s and comes to rest. Its volume is that of the flow to half a layer, and so is its level: the
/// gauge takes it from the highest particles, between which a surface that is not quite flat lies.
#[test]
fn a_tank_fills_at_the_rate_of_the_flow() {
    for spacing in [0.02, 0.01_f32] {
        // The equations of state take four times as many steps, and have the same emitter.
        for method in methods().filter(|method| !method.name.starts_with("SESPH")) {
            let text = format!(
                "(name: \"fill\", dimension: 2, spacing: {spacing}, pressure: {},
                bodies: [(shape: Box(min: (0, 0, 0), max: (0.4, 0.1, 0)))],
                emitters: [(shape: Rectangle(center: (0.15, 0.25, 0), normal: (0, -1, 0), width: 0.1), speed: 0.5,
                    end: 0.8)],
                boundaries: [Tank(min: (0, 0, 0), max: (0.4, 0.6, 0))],
                fluid: (viscosity: Laminar(kinematic_viscosity: 0.002)),
                gauges: [(name: \"level\", kind: Height(at: (0.2, 0, 0), radius: 0.15), every: Seconds(0.01))])",
                (method.pressure)(20.0),
            );
            let mut simulation = simulation(&text);
            while simulation.time() < 2.0 {
                simulation.step().unwrap_or_else(|error| panic!("{error}"));
            }
            let spacing = f64::from(spacing);
            let volume = spacing.powi(2) * particles(&mut simulation).len() as f64;
            let known = 0.4 * 0.1 + 0.1 * 0.5 * 0.8;
            let gauges = simulation.world().resource::<Gauges>();
            let level = gauges
                .get("level")
                .and_then(|gauge| gauge.value("height_m"));
            let level = level.expect("fluid");
            measured(&format!(
                "{}, spacing {spacing}: volume {volume:.5} m², known {known:.5}; level {level:.4} m, known {:.4}",
                method.name,
                known / 0.4
            ));
            assert!(
                (volume - known).abs() <= 0.5 * 0.1 * spacing,
                "{}: {volume}",
                method.name
            );
            assert!(
                (level - known / 0.4).abs() <= 0.4 * spacing,
                "{}: {level}",
                method.name
            );
        }
    }
}

/// A channel that fluid flows through at 1 m/s, from an emitter to a box that removes it: it goes on flowing at 1 m/s,
/// without pressure, and as much leaves as enters.
#[test]
fn a_uniform_flow_from_an_emitter_to_an_outflow_stays_uniform() {
    for spacing in [0.02, 0.01_f32] {
        for method in methods() {
            let text = format!(
                "(name: \"channel\", dimension: 2, spacing: {spacing}, pressure: {}, gravity: (0, 0, 0),
                bodies: [(shape: Box(min: (0, 0, 0), max: (0.6, 0.2, 0)), velocity: (1, 0, 0))],
                emitters: [(shape: Rectangle(center: (0, 0.1, 0), normal: (1, 0, 0), width: 0.2), speed: 1)],
                boundaries: [Tank(min: (-0.3, 0, 0), max: (1, 0.2, 0))],
                outflow: [(min: (0.6, 0, 0), max: (0.9, 0.2, 0))])",
                (method.pressure)(10.0),
            );
            let plan = overfall::plan(&scene(&text)).expect("a plan");
            let layer = plan.emitters[0].layer;
            let mut simulation = simulation(&text);
            let (mut error, mut fastest) = (0.0_f32, 0.0_f32);
            let mut last = overfall::StepReport::default();
            while simulation.time() < 0.4 {
                last = simulation.step().unwrap_or_else(|error| panic!("{error}"));
                error = error.max(last.max_density_error);
                fastest = fastest.max(last.max_speed);
                // A layer comes before one goes, or after.
                assert!(
                    last.particles.abs_diff(plan.particles) <= layer,
                    "{}: {last:?}",
                    method.name
                );
            }
            let slowest = (particles(&mut simulation).iter())
                .fold(f32::INFINITY, |least, one| least.min(one.2.x));
            measured(&format!(
                "{}, spacing {spacing}: {slowest:.4} to {fastest:.4} m/s, density error {error:.2e}, {} in, {} out",
                method.name, last.emitted, last.removed
            ));
            assert!(
                fastest <= 1.005 && slowest >= 0.98,
                "{}: {slowest} {fastest}",
                method.name
            );
            // Rows beside walls lack 0.075 % in a lattice at rest.
            assert!(error <= 1e-3, "{}: {error}", method.name);
        }
    }
}

/// An emitter that stands in water: what flows into the layers behind its face is not thrown out when they pass it, and
/// all that was due has entered or is counted. The cavity behind the face collapses, which concentrates the energy of
/// the water around it (Rayleigh 1917) into speeds above that of a fall through the depth, as a splash does.
#[test]
fn an_emitter_under_water_blows_without_shocks() {
    for (dimension, spacing, method) in [
        (2, 0.02_f32, "Pcisph"),
        (2, 0.01, "Dfsph"),
        (3, 0.02, "Pcisph"),
        (3, 0.02, "Iisph"),
    ] {
        let (depth, height) = if dimension == 2 {
            ("0", "")
        } else {
            ("0.16", ", height: 0.08")
        };
        let block = |x: (f32, f32), y: (f32, f32)| {
            format!(
                "(shape: Box(min: ({}, {}, 0), max: ({}, {}, {depth})))",
                x.0, y.0, x.1, y.1
            )
        };
        // Free behind the face, where the layers enter.
        let back = 0.3 - 5.0 * spacing;
        let bodies = [
            block((0.0, back), (0.0, 0.28)),
            block((0.3, 0.6), (0.0, 0.28)),
            block((back, 0.3), (0.0, 0.06)),
            block((back, 0.3), (0.14, 0.28)),
        ];
        let middle = if dimension == 2 { "0" } else { "0.08" };
        let text = format!(
            "(name: \"under\", dimension: {dimension}, spacing: {spacing}, pressure: {method},
            bodies: [{}], boundaries: [Tank(min: (0, 0, 0), max: (0.6, 0.6, {depth}))],
            emitters: [(shape: Rectangle(center: (0.3, 0.1, {middle}), normal: (1, 0, 0), width: 0.08{height}),
                speed: 0.5, jitter: (amplitude: 0.05, seed: 1))])",
            bodies.join(", ")
        );
        let mut simulation = simulation(&text);
        let start = particles(&mut simulation).len();
        let (mut fastest, mut last) = (0.0_f32, None);
        while simulation.time() < 0.4 {
            let report = simulation.step().unwrap_or_else(|error| panic!("{error}"));
            fastest = fastest.max(report.max_speed);
            last = Some(report);
        }
        let report = last.expect("a step");
        measured(&format!(
            "{dimension}-D {method} at {spacing}: {fastest} m/s, {} entered, {} did not",
            report.emitted, report.without_place
        ));
        let fall = (2.0 * 9.81 * 0.28_f32).sqrt();
        assert!(fastest < 2.0 * fall, "{dimension}-D {method}: {fastest}");
        // Those behind the face were there at the start.
        let came = particles(&mut simulation).len() - start;
        let layer = if dimension == 2 {
            0.08 / spacing
        } else {
            (0.08 / spacing).powi(2)
        };
        let due = f64::from(layer) * 0.5 * simulation.time() / f64::from(spacing);
        let counted = (came as u64 + report.without_place) as f64;
        assert!(
            (counted - due).abs() <= f64::from(layer),
            "{dimension}-D {method}: {counted} of {due}"
        );
    }
}
