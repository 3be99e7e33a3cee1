//! Cost of a step, and its limits: every method at three sizes, phase by phase; every pass over the neighbours compared
//! with the memory bandwidth and the arithmetic of this machine.
//!
//! `cargo bench --bench step` uses 30 000 and 130 000 particles, `-- 30000 130000 1000000` those numbers.
//!
//! The scene is the corner dam break, scaled in all lengths except the spacing. Numbers of threads take turns step by
//! step, and every figure is a median of one run, so that disturbances of the machine affect all alike. Times are for
//! orientation; ratios count.
#![allow(clippy::print_stdout, reason = "a benchmark talks to its reader")]

use std::{array::from_fn, hint::black_box, path::Path, time::Instant};

use bevy_ecs::{prelude::*, system::SystemId};
use glam::Vec4;
use overfall::{
    Phase, Simulation,
    density::compute_density,
    force::apply_laminar_viscosity,
    loading::Override,
    neighbours::{FluidNeighbours, find_boundary_neighbours, find_fluid_neighbours},
    pressure::pressure_force,
    scene::{BoundaryShape as Boundary, Scene, Shape},
    simd::{Simd, Vectorised},
    state::Execution,
};

type Failure = Box<dyn std::error::Error>;

/// Warm-up steps, and measured steps.
const WARM_UP: usize = 10;
const STEPS: usize = 15;
/// Runs of a single pass.
const RUNS: usize = 15;

/// The methods, each with the settings of its step.
const METHODS: [(&str, &[&str]); 5] = [
    (
        "SESPH",
        &[
            "pressure=Sesph(equation:Tait(stiffness:294300))",
            "time_step=Fixed(0.0005)",
        ],
    ),
    (
        "PCISPH",
        &["pressure=Pcisph(criterion:Mean,max_density_error:0.01)"],
    ),
    (
        "IISPH",
        &["pressure=Iisph(criterion:Mean,max_density_error:0.01)"],
    ),
    (
        "DFSPH",
        &["pressure=Dfsph(criterion:Mean,max_density_error:0.01)"],
    ),
    ("δ-SPH", &["pressure=DeltaSph(sound_speed:45)"]),
];

/// The corner dam break with about `particles` particles.
fn scene(particles: usize, overrides: &[&str]) -> Result<Scene, Failure> {
    let overrides: Result<Vec<_>, _> = overrides.iter().map(|set| Override::parse(set)).collect();
    let file =
        Path::new(env!("CARGO_MANIFEST_DIR")).join("assets/scenes/corner_dam_break_130k.ron");
    let mut scene = Scene::load(&file, &overrides?)?;
    let scale = (particles as f32 / 130_000.0).cbrt();
    // A whole number of spacings, so that the block remains a block of the lattice.
    let scaled = |x: glam::Vec3| (x * scale / scene.spacing).round() * scene.spacing;
    for body in &mut scene.bodies {
        if let Shape::Box { min, max } = &mut body.shape {
            (*min, *max) = (scaled(*min), scaled(*max));
        }
    }
    for boundary in &mut scene.boundaries {
        if let Boundary::Tank { min, max, .. } = boundary {
            (*min, *max) = (scaled(*min), scaled(*max));
        }
    }
    Ok(scene)
}

fn median(values: &mut [f64]) -> f64 {
    values.sort_by(f64::total_cmp);
    values[values.len() / 2]
}

/// The steps of one method on one number of threads.
struct Timed {
    simulation: Simulation,
    steps: Vec<f64>,
    phases: Vec<Vec<f64>>,
    iterations: u32,
    error: f32,
}

impl Timed {
    fn new(scene: &Scene, threads: usize) -> Result<Self, Failure> {
        let mut simulation = Simulation::with_threads(scene, threads)?;
        for _ in 0..WARM_UP {
            simulation.step()?;
        }
        let phases = vec![Vec::new(); Phase::ALL.len()];
        Ok(Self {
            simulation,
            steps: Vec::new(),
            phases,
            iterations: 0,
            error: 0.0,
        })
    }

    fn step(&mut self) -> Result<(), Failure> {
        let start = Instant::now();
        let report = self.simulation.step()?;
        self.steps.push(1e3 * start.elapsed().as_secs_f64());
        for (all, seconds) in self.phases.iter_mut().zip(report.phase_seconds) {
            all.push(1e3 * seconds);
        }
        self.iterations += report.iterations;
        self.error = self.error.max(report.mean_density_error);
        Ok(())
    }
}

/// Every method: ms per step and by phase, on one thread and on two.
fn methods(particles: usize) -> Result<(), Failure> {
    print!(
        "\n{particles} particles, ms a step\n{:8} {:>7} {:>7}",
        "method", "step", "1 thr."
    );
    print!(
        " {:>6} {:>10} {:>6} {:>7}",
        "ratio", "ns/part.", "iter.", "error%"
    );
    for phase in Phase::ALL {
        print!(" {:>9.9}", phase.name());
    }
    println!();
    for (name, overrides) in METHODS {
        let scene = scene(particles, overrides)?;
        let mut one = Timed::new(&scene, 1)?;
        let mut two = Timed::new(&scene, 2)?;
        for _ in 0..STEPS {
            two.step()?;
            one.step()?;
        }
        let (step, alone) = (median(&mut two.steps), median(&mut one.steps));
        let rows = two.simulation.step()?.particles;
        print!(
            "{name:8} {step:7.1} {alone:7.1} {:6.2} {:10.1}",
            alone / step,
            1e6 * step / rows as f64
        );
        print!(
            " {:6.1} {:7.3}",
            f64::from(two.iterations) / STEPS as f64,
            100.0 * two.error
        );
        for phase in &mut two.phases {
            print!(" {:9.2}", median(phase));
        }
        println!();
    }
    Ok(())
}

/// Chains of fused multiply-add without memory access.
struct Arithmetic;

/// Number of parallel chains, and rounds of each.
const CHAINS: usize = 10;
const ROUNDS: usize = 2_000_000;

impl Vectorised for Arithmetic {
    type Output = f32;

    #[inline(always)]
    fn run<S: Simd>(self, simd: S) -> f32 {
        let (factor, term) = (simd.splat(black_box(0.999)), simd.splat(black_box(0.001)));
        // Different values: the compiler would merge equal chains.
        let mut chains: [S::F; CHAINS] = from_fn(|k| simd.splat(black_box(k as f32)));
        for _ in 0..ROUNDS {
            for chain in &mut chains {
                *chain = simd.mul_add(*chain, factor, term);
            }
        }
        chains.into_iter().map(|chain| simd.sum(chain)).sum()
    }
}

/// Billions of floating-point operations per second, all threads together.
fn peak_arithmetic(execution: &Execution) -> f64 {
    let set = execution.instruction_set.arithmetic();
    let mut rates: Vec<f64> = (0..5)
        .map(|_| {
            let mut results = vec![0.0f32; execution.threads() * overfall::state::CHUNK];
            let start = Instant::now();
            execution.for_each_chunk(&mut results, |_, chunk| chunk[0] = set.dispatch(Arithmetic));
            let operations = (execution.threads() * CHAINS * ROUNDS * 8 * 2) as f64;
            assert!(results[0] > 0.0);
            operations / start.elapsed().as_secs_f64() / 1e9
        })
        .collect();
    median(&mut rates)
}

/// Billions of bytes per second, read and written, of a copy too large for the caches.
fn stream_bandwidth(execution: &Execution) -> f64 {
    let from = vec![Vec4::ONE; 8 << 20];
    let mut to = vec![Vec4::ZERO; from.len()];
    let mut rates: Vec<f64> = (0..7)
        .map(|_| {
            let start = Instant::now();
            execution.for_each_chunk(&mut to, |first, chunk| {
                chunk.copy_from_slice(&from[first..first + chunk.len()]);
            });
            (2 * size_of_val(from.as_slice())) as f64 / start.elapsed().as_secs_f64() / 1e9
        })
        .collect();
    median(&mut rates)
}

/// A pass over the neighbours: operations per pair, and bytes per particle besides its list.
struct Pass {
    name: &'static str,
    system: SystemId,
    /// Floating-point operations per pair, counted in the source; a division or a root counts as one.
    operations: f64,
    /// Bytes of columns: each row is loaded once, because rows along the Z-curve share their neighbours.
    columns: f64,
    /// Bytes of lists and kernel gradients per neighbour.
    pair: f64,
}

/// The passes over the neighbours, registered in a world.
fn all_passes(world: &mut World) -> Vec<Pass> {
    vec![
        Pass {
            name: "neighbours, fluid",
            system: world.register_system(find_fluid_neighbours),
            operations: 0.0,
            columns: 16.0,
            pair: 4.0,
        },
        Pass {
            name: "neighbours, walls",
            system: world.register_system(find_boundary_neighbours),
            operations: 0.0,
            columns: 16.0,
            pair: 0.0,
        },
        Pass {
            name: "density",
            system: world.register_system(compute_density),
            operations: 26.0,
            columns: 20.0,
            pair: 8.0,
        },
        Pass {
            name: "viscosity",
            system: world.register_system(apply_laminar_viscosity),
            operations: 27.0,
            columns: 44.0,
            pair: 8.0,
        },
        Pass {
            name: "pressure force",
            system: world.register_system(pressure_force),
            operations: 11.0,
            columns: 28.0,
            pair: 8.0,
        },
    ]
}

/// Every pass on one thread and on two, compared with memory and arithmetic of the machine.
fn passes(particles: usize) -> Result<(), Failure> {
    let scene = scene(
        particles,
        &["pressure=Pcisph(criterion:Mean,max_density_error:0.01)"],
    )?;
    let mut results: Vec<Vec<f64>> = Vec::new();
    let (mut stream, mut peak) = (0.0, 0.0);
    let mut table = Vec::new();
    let (mut rows, mut neighbours) = (0, 0.0);
    for threads in [1, 2] {
        let mut timed = Timed::new(&scene, threads)?;
        rows = timed.simulation.step()?.particles;
        let world = timed.simulation.world_mut();
        neighbours = world.resource::<FluidNeighbours>().lists().pairs() as f64 / rows as f64;
        let execution = world.resource::<Execution>().clone();
        (stream, peak) = (stream_bandwidth(&execution), peak_arithmetic(&execution));
        table = all_passes(world);
        let mut times = vec![Vec::new(); table.len()];
        for _ in 0..RUNS {
            for (pass, times) in table.iter().zip(&mut times) {
                let start = Instant::now();
                world.run_system(pass.system)?;
                times.push(start.elapsed().as_secs_f64());
            }
        }
        results.push(
            times
                .iter_mut()
                .map(|times| 1e9 * median(times) / rows as f64)
                .collect(),
        );
    }
    println!(
        "\n{rows} particles, {neighbours:.1} neighbours; a copy {stream:.1} GB/s, fused multiply-add {peak:.0} \
         Gflop/s on two threads"
    );
    println!(
        "{:18} {:>8} {:>8} {:>6} {:>8} {:>8} {:>9} {:>8}",
        "pass", "ns/part.", "1 thr.", "ratio", "GB/s", "of copy", "Gflop/s", "of peak"
    );
    for (pass, (one, two)) in table.iter().zip(results[0].iter().zip(&results[1])) {
        let bytes = (pass.columns + pass.pair * neighbours + 8.0) / two;
        let operations = pass.operations * neighbours / two;
        print!(
            "{:18} {two:8.1} {one:8.1} {:6.2} {bytes:8.1} {:7.0}%",
            pass.name,
            one / two,
            100.0 * bytes / stream
        );
        if pass.operations > 0.0 {
            print!(" {operations:9.1} {:7.0}%", 100.0 * operations / peak);
        }
        println!();
    }
    Ok(())
}

fn main() -> Result<(), Failure> {
    let sizes: Vec<usize> = std::env::args()
        .skip(1)
        .filter_map(|argument| argument.parse().ok())
        .collect();
    let sizes = if sizes.is_empty() {
        vec![30_000, 130_000]
    } else {
        sizes
    };
    for &particles in &sizes {
        methods(particles)?;
        passes(particles)?;
    }
    Ok(())
}
