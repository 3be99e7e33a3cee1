//! Long runs: `cargo bench --bench soak`. A hundred thousand steps of a small scene, whose memory must not grow, and
//! still water for sixty simulated seconds, which must gain no energy and lose no volume.
//!
//! Words after `--` select parts by name; `--steps N` and `--seconds S` shorten them, `--threads N` (2) changes no
//! figure. A bound that breaks gives status 1.
#![expect(clippy::print_stdout, reason = "a report for whoever runs it")]

use std::process::ExitCode;

use bevy_ecs::prelude::*;
use overfall::{
    Simulation,
    gauge::Gauges,
    particle::{Fluid, Position},
    scene::{PressureMethod, Scene, Sesph, StateEquation},
};

/// Water and a piston in the plane, a tap, an outlet, gauges, kept lists: everything that could collect something.
const BUSY: &str = r#"(
    name: "busy",
    dimension: 2,
    spacing: 0.02,
    neighbours: Verlet(skin: 0.1),
    bodies: [(shape: Box(min: (0, 0, 0), max: (0.2, 0.1, 0)))],
    boundaries: [
        Tank(min: (0, 0, 0), max: (0.4, 0.3, 0), open: true),
        Box(min: (0.3, 0, 0), max: (0.36, 0.2, 0), motion: Oscillation(amplitude: (0.03, 0, 0), frequency: 0.5)),
    ],
    emitters: [(shape: Disc(center: (0.1, 0.2, 0), normal: (0, -1, 0), radius: 0.03), speed: 0.5)],
    outflow: [(min: (0.0, -0.1, 0), max: (0.06, 0.06, 0))],
    domain: (min: (-0.5, -0.5, 0), max: (1, 1, 0)),
    outside: Remove,
    gauges: [(name: "level", kind: Height(at: (0.1, 0, 0)), every: Steps(10), window: 0.1)],
    limits: (compression: 10, energy: 1000),
    duration: 1e9,
)"#;

/// Twenty rows of water at rest, in the plane.
const STILL: &str = r#"(
    name: "still",
    dimension: 2,
    spacing: 0.02,
    bodies: [(shape: Box(min: (0, 0, 0), max: (0.4, 0.4, 0)))],
    boundaries: [Tank(min: (0, 0, 0), max: (0.4, 0.6, 0))],
    duration: 1e9,
)"#;

/// Growth of the resident memory that is allowed from a tenth of the run on \[MB].
const MOST_GROWTH: f64 = 4.0;
/// Largest gain of energy of still water, as part of its potential energy over the floor \[-].
const MOST_ENERGY: f64 = 1e-3;
/// Largest change of the level, as part of the depth \[-].
const MOST_VOLUME: f64 = 0.02;

/// Resident memory of this process \[MB].
fn resident() -> f64 {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let line = status.lines().find_map(|line| line.strip_prefix("VmRSS:"));
    let number = line.and_then(|line| line.split_whitespace().next()?.parse::<f64>().ok());
    number.map_or(f64::NAN, |kilobytes| kilobytes / 1024.0)
}

fn scene(text: &str) -> Scene {
    Scene::parse(text, "soak.ron", &[]).unwrap_or_else(|error| panic!("{error}"))
}

/// Many steps; whether memory stayed.
fn memory(steps: u64, threads: usize) -> bool {
    let mut simulation =
        Simulation::with_threads(&scene(BUSY), threads).expect("a scene that runs");
    println!(
        "busy: {steps} steps\n{:>8} {:>10} {:>9}",
        "step", "particles", "MB"
    );
    let mut early = f64::NAN;
    for step in 1..=steps {
        let particles = match simulation.step() {
            Ok(report) => report.particles,
            Err(error) => {
                println!("busy: {error}");
                return false;
            }
        };
        // Readings that nobody takes would collect.
        let mut gauges = simulation.world_mut().resource_mut::<Gauges>();
        gauges.take_readings(step).for_each(drop);
        if step == steps / 10 {
            early = resident();
        }
        if step.is_multiple_of((steps / 10).max(1)) {
            println!("{step:>8} {particles:>10} {:>9.1}", resident());
        }
    }
    let growth = resident() - early;
    println!("busy: {growth:.1} MB from a tenth of the run on, at most {MOST_GROWTH}");
    // Where the system does not say, nothing is known.
    growth.is_nan() || growth <= MOST_GROWTH
}

/// Still water; whether it stays still.
fn still(seconds: f64, method: PressureMethod, name: &str, threads: usize) -> bool {
    let scene = Scene {
        pressure: method,
        ..scene(STILL)
    };
    let mut simulation = Simulation::with_threads(&scene, threads).expect("a scene that runs");
    let level = |simulation: &mut Simulation| {
        let world = simulation.world_mut();
        let mut fluid = world.query_filtered::<&Position, With<Fluid>>();
        let heights = fluid.iter(world).map(|x| f64::from(x.0.y));
        heights.fold(0.0, f64::max)
    };
    let before = level(&mut simulation);
    let first = match simulation.step() {
        Ok(report) => report,
        Err(error) => {
            println!("{name}: {error}");
            return false;
        }
    };
    let energy = first.kinetic_energy + first.potential_energy;
    let (mut most, mut next) = (f64::NEG_INFINITY, 0.0);
    while simulation.time() < seconds {
        let report = match simulation.step() {
            Ok(report) => report,
            Err(error) => {
                println!("{name}: {error}");
                return false;
            }
        };
        let gain =
            (report.kinetic_energy + report.potential_energy - energy) / first.potential_energy;
        most = most.max(gain);
        if report.time >= next {
            println!(
                "{name}: {:>5.1} s, step {}, gain {gain:+.2e}",
                report.time, report.step
            );
            next += seconds / 6.0;
        }
    }
    let change = (level(&mut simulation) - before) / before;
    println!(
        "{name}: greatest gain {most:+.2e} (at most {MOST_ENERGY}), level {change:+.2e} (±{MOST_VOLUME})"
    );
    most <= MOST_ENERGY && change.abs() <= MOST_VOLUME
}

fn main() -> ExitCode {
    let (mut words, mut steps, mut seconds, mut threads) = (Vec::new(), 100_000, 60.0, 2);
    let mut arguments = std::env::args().skip(1);
    while let Some(argument) = arguments.next() {
        let value = |value: Option<String>| value.and_then(|value| value.parse::<f64>().ok());
        match argument.as_str() {
            "--steps" => steps = value(arguments.next()).map_or(steps, |value| value as u64),
            "--seconds" => seconds = value(arguments.next()).unwrap_or(seconds),
            "--threads" => {
                threads = value(arguments.next()).map_or(threads, |value| value as usize);
            }
            "--bench" => {}
            _ => words.push(argument),
        }
    }
    let asked = |name: &str| words.iter().all(|word| name.contains(word.as_str()));
    let mut good = true;
    if asked("busy") {
        good &= memory(steps, threads);
    }
    let equation = StateEquation::Tait { stiffness: 6e4 };
    let methods = [
        ("still sesph", PressureMethod::Sesph(Sesph { equation })),
        ("still pcisph", PressureMethod::Pcisph(Default::default())),
        ("still iisph", PressureMethod::Iisph(Default::default())),
        ("still dfsph", PressureMethod::Dfsph(Default::default())),
        (
            "still delta-sph",
            PressureMethod::DeltaSph(Default::default()),
        ),
    ];
    for (name, method) in methods {
        if asked(name) {
            good &= still(seconds, method, name, threads);
        }
    }
    if good {
        ExitCode::SUCCESS
    } else {
        ExitCode::FAILURE
    }
}
