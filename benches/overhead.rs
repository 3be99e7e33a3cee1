//! What the ECS costs in a step: `cargo bench --bench overhead`. The schedule, the copies between tables and rows, and
//! the reordering of rows are run alone, on the world of the scene, and compared with its whole step.
//!
//! Also steps per second of a thousand particles in the plane, with every method. `--threads N` after `--`; else 2.
#![expect(clippy::print_stdout, reason = "a table for whoever runs it")]

use std::time::Instant;

use bevy_ecs::{
    prelude::*,
    schedule::{ScheduleLabel, SingleThreadedExecutor},
};
use overfall::{
    Simulation, Step,
    particle::Fluid,
    registry::{gathering, scattering},
    reorder::{ReorderState, reorder},
    scene::{PressureMethod, Scene, Sesph, StateEquation},
    state::{Execution, Systems},
};

/// 32 × 32 particles that collapse in a tank, in the plane.
const PLANE: &str = r#"(
    name: "plane",
    dimension: 2,
    spacing: 0.01,
    bodies: [(shape: Box(min: (0, 0, 0), max: (0.32, 0.32, 0)))],
    boundaries: [Tank(min: (0, 0, 0), max: (1.28, 0.64, 0))],
)"#;

#[derive(ScheduleLabel, Debug, Clone, Copy, PartialEq, Eq, Hash)]
struct Part;

/// Shortest time of some repetitions of `work` \[ms].
fn shortest(repetitions: usize, mut work: impl FnMut()) -> f64 {
    let mut best = f64::INFINITY;
    for _ in 0..repetitions {
        let start = Instant::now();
        work();
        best = best.min(start.elapsed().as_secs_f64());
    }
    1e3 * best
}

/// The systems alone, in a schedule as that of the step.
fn schedule(systems: Systems) -> Schedule {
    let mut schedule = Schedule::new(Part);
    schedule.set_executor(SingleThreadedExecutor::new());
    schedule.add_systems(systems);
    schedule
}

fn idle() {}

/// As many systems as the step has, without anything to do, one after the other.
fn idle_schedule(count: usize) -> Schedule {
    let mut schedule = Schedule::new(Part);
    schedule.set_executor(SingleThreadedExecutor::new());
    for _ in 0..count {
        schedule.add_systems(idle.run_if(|| true));
    }
    schedule
}

/// Prints the parts of a scene's step; `steps` of it are taken.
fn parts(scene: &Scene, threads: usize, steps: usize) {
    let mut simulation = Simulation::with_threads(scene, threads).expect("a scene that runs");
    for _ in 0..steps / 4 {
        simulation.step().expect("a step");
    }
    let mut times: Vec<f64> = (0..steps)
        .map(|_| {
            let start = Instant::now();
            simulation.step().expect("a step");
            1e3 * start.elapsed().as_secs_f64()
        })
        .collect();
    times.sort_by(f64::total_cmp);
    let step = times[times.len() / 2];
    let world = simulation.world_mut();
    let execution = world.resource::<Execution>().clone();
    let count = world.schedule_scope(Step, |_, step| step.systems_len());
    let interval = world
        .get_resource::<ReorderState>()
        .map(ReorderState::interval);
    let (mut gather, mut scatter) = (schedule(gathering(scene)), schedule(scattering(scene)));
    let mut idle = idle_schedule(count);
    let world = simulation.world_mut();
    // Inside the pool, as in a step; what is scattered was gathered before.
    let (in_schedule, in_gather, in_scatter) = execution.install(|| {
        let (mut gathered, mut scattered) = (f64::INFINITY, f64::INFINITY);
        for _ in 0..30 {
            gathered = gathered.min(shortest(1, || gather.run(world)));
            scattered = scattered.min(shortest(1, || scatter.run(world)));
        }
        (shortest(30, || idle.run(world)), gathered, scattered)
    });
    let reordering = interval.map_or(0.0, |interval| {
        shortest(5, || reorder(world)) / f64::from(interval)
    });
    let mut fluid = world.query::<&Fluid>();
    let particles = fluid.iter(world).count();
    let parts = [
        ("schedule", in_schedule),
        ("gathering", in_gather),
        ("scattering", in_scatter),
        ("reordering", reordering),
    ];
    let sum: f64 = parts.iter().map(|part| part.1).sum();
    println!(
        "{}, {particles} particles, {threads} threads: {step:.3} ms a step (median)",
        scene.name
    );
    for (name, time) in parts {
        println!(
            "  {name:<11} {time:>9.4} ms  {:>6.2} %",
            100.0 * time / step
        );
    }
    println!(
        "  {:<11} {sum:>9.4} ms  {:>6.2} %",
        "all",
        100.0 * sum / step
    );
}

/// Steps per second with every method, the best of some blocks.
fn speed(scene: &Scene, threads: usize) {
    let methods = [
        (
            "SESPH",
            PressureMethod::Sesph(Sesph {
                equation: StateEquation::Tait { stiffness: 1e5 },
            }),
        ),
        ("PCISPH", PressureMethod::Pcisph(Default::default())),
        ("IISPH", PressureMethod::Iisph(Default::default())),
        ("DFSPH", PressureMethod::Dfsph(Default::default())),
    ];
    println!(
        "{}: steps per second, median and best of 20 blocks of 50 steps",
        scene.name
    );
    for (name, pressure) in methods {
        let scene = Scene {
            pressure,
            ..scene.clone()
        };
        let mut simulation = Simulation::with_threads(&scene, threads).expect("a scene that runs");
        for _ in 0..100 {
            simulation.step().expect("a step");
        }
        let mut blocks: Vec<f64> = (0..20)
            .map(|_| {
                let start = Instant::now();
                for _ in 0..50 {
                    simulation.step().expect("a step");
                }
                50.0 / start.elapsed().as_secs_f64()
            })
            .collect();
        blocks.sort_by(f64::total_cmp);
        println!("  {name:<7} {:>7.0} {:>7.0}", blocks[10], blocks[19]);
    }
}

fn main() {
    let mut arguments = std::env::args()
        .skip_while(|word| word != "--threads")
        .skip(1);
    let threads = arguments
        .next()
        .and_then(|word| word.parse().ok())
        .unwrap_or(2);
    let parse = |text: &str| Scene::parse(text, "overhead.ron", &[]).expect("a scene");
    let plane = parse(PLANE);
    let large = include_str!("../assets/scenes/corner_dam_break_130k.ron");
    parts(&plane, threads, 400);
    parts(&parse(large), threads, 20);
    speed(&plane, threads);
    if threads > 1 {
        println!("one thread");
        speed(&plane, 1);
    }
}
