//! One run of overfall or of salva (the crate `salva3d`) on the corner dam break; prints the result as a line of JSON.
//! Without arguments it does nothing.
//!
//! `python3 benches/peers/compare.py` starts this and SPlisHSPlasH in turn and prints the ratios. Manually:
//!
//! `cargo bench --manifest-path benches/peers/Cargo.toml -- overfall STEPS WARM_UP THREADS [PATH=VALUE]…`
//!
//! `cargo bench --manifest-path benches/peers/Cargo.toml -- salva STEPS WARM_UP THREADS TOLERANCE`
#![allow(clippy::print_stdout, reason = "a benchmark talks to its reader")]

use std::{path::Path, time::Instant};

use overfall::{
    Override, Simulation,
    scene::Scene,
    state::{
        Densities, Material,
        particle::{Fluid, Position},
    },
};
use salva3d::{
    LiquidWorld,
    math::Vector,
    object::{Boundary, Fluid as Liquid, interaction_groups::InteractionGroups},
    solver::{ArtificialViscosity, DFSPHSolver, DfsphParameters},
};

type Failure = Box<dyn std::error::Error>;

/// Results of a run, times in ms.
#[derive(Default)]
struct Measured {
    particles: usize,
    boundary_particles: usize,
    times: Vec<f64>,
    iterations: Vec<f64>,
    mean_errors: Vec<f64>,
    largest_error: f64,
}

impl Measured {
    /// Adds the compression of the densities of a state.
    fn add_densities(&mut self, densities: &[f32], rest_density: f32) {
        let compression = |rho: &f32| f64::from(rho / rest_density - 1.0).max(0.0);
        let sum: f64 = densities.iter().map(compression).sum();
        self.mean_errors.push(sum / densities.len() as f64);
        let largest = densities.iter().map(compression).fold(0.0, f64::max);
        self.largest_error = self.largest_error.max(largest);
    }

    fn print(self) {
        let mean = |values: &[f64]| values.iter().sum::<f64>() / values.len().max(1) as f64;
        let line = serde_json::json!({
            "particles": self.particles,
            "boundary_particles": self.boundary_particles,
            "ms_per_step": mean(&self.times),
            "iterations": mean(&self.iterations),
            "mean_density_error": mean(&self.mean_errors),
            "max_density_error": self.largest_error,
        });
        println!("{line}");
    }
}

fn corner_dam_break(overrides: &[String]) -> Result<Scene, Failure> {
    let overrides: Result<Vec<_>, _> = overrides.iter().map(|set| Override::parse(set)).collect();
    let file =
        Path::new(env!("CARGO_MANIFEST_DIR")).join("../../assets/scenes/corner_dam_break_130k.ron");
    Ok(Scene::load(&file, &overrides?)?)
}

fn run_overfall(
    steps: usize,
    warm_up: usize,
    threads: usize,
    overrides: &[String],
) -> Result<(), Failure> {
    let scene = corner_dam_break(overrides)?;
    let mut simulation = Simulation::with_threads(&scene, threads)?;
    let mut measured = Measured::default();
    for step in 0..warm_up + steps {
        let start = Instant::now();
        let report = simulation.step()?;
        let elapsed = start.elapsed().as_secs_f64();
        if step >= warm_up {
            measured.times.push(1e3 * elapsed);
            measured.iterations.push(report.iterations.into());
            let densities = simulation.world().resource::<Densities>();
            measured.add_densities(densities, scene.fluid.rest_density);
        }
        measured.particles = report.particles;
    }
    measured.boundary_particles = overfall::sampling::sample(&scene)?.len();
    measured.print();
    Ok(())
}

/// DFSPH with our particles and walls. Its densities are not public: our loop sums them over its positions, with its
/// particle mass and the given walls.
fn run_salva(steps: usize, warm_up: usize, threads: usize, tolerance: f32) -> Result<(), Failure> {
    rayon::ThreadPoolBuilder::new()
        .num_threads(threads)
        .build_global()?;
    let scene = corner_dam_break(&[])?;
    let overfall::scene::TimeStep::Fixed(dt) = scene.time_step else {
        return Err("the scene has a fixed time step".into());
    };
    let mut probe = Simulation::with_threads(&scene, threads)?;
    let vector = |x: glam::Vec3| Vector::new(x.x, x.y, x.z);
    let world = probe.world_mut();
    let mut query = world.query_filtered::<&Position, bevy_ecs::prelude::With<Fluid>>();
    let fluid: Vec<_> = query.iter(world).map(|x| vector(x.0)).collect();
    let walls: Vec<_> = overfall::sampling::sample(&scene)?
        .iter()
        .map(|sample| vector(sample.position))
        .collect();

    let solver: DFSPHSolver = DFSPHSolver::with_parameters(DfsphParameters {
        max_density_error: tolerance,
        max_divergence_error: tolerance,
        ..DfsphParameters::default()
    });
    let radius = scene.spacing / 2.0;
    let mut liquid_world = LiquidWorld::new(solver, radius, scene.support(), 1.0);
    let mut liquid = Liquid::new(
        fluid,
        radius,
        scene.fluid.rest_density,
        InteractionGroups::default(),
    );
    liquid
        .nonpressure_forces
        .push(Box::new(ArtificialViscosity::new(0.01, 0.0)));
    let volume = liquid.default_particle_volume();
    let boundary_particles = walls.len();
    let handle = liquid_world.add_fluid(liquid);
    liquid_world.add_boundary(Boundary::new(walls, InteractionGroups::default()));
    let gravity = vector(scene.gravity);

    let mut measured = Measured {
        boundary_particles,
        ..Measured::default()
    };
    for step in 0..warm_up + steps {
        let start = Instant::now();
        liquid_world.step(dt, &gravity);
        if step >= warm_up {
            measured.times.push(1e3 * start.elapsed().as_secs_f64());
        }
    }
    let positions = &liquid_world
        .fluids()
        .get(handle)
        .ok_or("the liquid is gone")?
        .positions;
    measured.particles = positions.len();
    let world = probe.world_mut();
    world.resource_mut::<Material>().particle_mass = scene.fluid.rest_density * volume;
    let mut query = world.query_filtered::<&mut Position, bevy_ecs::prelude::With<Fluid>>();
    for (mut x, theirs) in query.iter_mut(world).zip(positions) {
        x.0 = glam::Vec3::new(theirs.x, theirs.y, theirs.z);
    }
    // A step may fail; that does not matter here, because it computes the densities first.
    let _ = probe.step();
    measured.add_densities(
        probe.world().resource::<Densities>(),
        scene.fluid.rest_density,
    );
    measured.print();
    Ok(())
}

fn main() -> Result<(), Failure> {
    let arguments: Vec<String> = std::env::args()
        .skip(1)
        .filter(|argument| argument != "--bench")
        .collect();
    match arguments.as_slice() {
        [] => Ok(()),
        [program, steps, warm_up, threads, rest @ ..] => {
            let (steps, warm_up, threads) = (steps.parse()?, warm_up.parse()?, threads.parse()?);
            match (program.as_str(), rest) {
                ("overfall", overrides) => run_overfall(steps, warm_up, threads, overrides),
                ("salva", [tolerance]) => run_salva(steps, warm_up, threads, tolerance.parse()?),
                _ => Err(
                    "the program is `overfall` with overrides or `salva` with a tolerance".into(),
                ),
            }
        }
        _ => Err("arguments: overfall|salva STEPS WARM_UP THREADS …".into()),
    }
}
