//! Setting a scene up in a world.

use std::path::PathBuf;

use bevy_ecs::prelude::*;

use super::{
    clock::{Clock, Failure},
    order::{Order, OrderError},
    report::{StepError, StepOutcome, StepReport},
    schedule::{InTurn, Step, add_schedules},
    start::{self, StartDensity},
    timer::PhaseTimer,
};
use crate::{
    boundary::{self, BoundarySamples, direct_forcing::DirectForcing, sums::WallSums},
    column::{
        Accelerations, Densities, Positions, PredictedPositions, PressureAccelerations, Pressures,
        Velocities,
    },
    execution::Execution,
    force::{ArtificialViscosity, Cohesion, LaminarViscosity},
    index::{self, DomainTooLarge, FluidIndex, z_curve},
    integrate::{Domain, GuardLimits, Motion},
    material::Material,
    mesh::MeshError,
    neighbours::{BoundaryNeighbours, FluidNeighbours},
    pairs::PairSlopes,
    particle::{self, Boundary, BoundaryNormal, BoundaryVolume, Density, Position, Velocity},
    pressure::{
        PressureSolve, dfsph, iisph, pcisph,
        solve::Convergence,
        state_equation::EquationOfState,
        warm_start::{self, WarmStart},
    },
    reorder::ReorderState,
    scene::{
        BoundaryHandling, Neighbours, PressureMethod, Scene, SceneError, SurfaceTension, Viscosity,
        shapes,
    },
    time_step,
};

/// Why a scene could not be set up.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum InstallError {
    /// The world runs a scene already.
    #[error("a scene is installed in this world already; a world holds one")]
    Occupied,
    /// The scene contradicts itself.
    #[error(transparent)]
    Scene(#[from] SceneError),
    /// The scene's spatial index cannot cover its fluid.
    #[error("fluid: {0}")]
    Fluid(DomainTooLarge),
    /// The scene's spatial index cannot cover its walls.
    #[error("boundary: {0}")]
    Boundary(DomainTooLarge),
    /// The fluid starts so compressed that it would explode.
    #[error(
        "the fluid starts {:.1} % above its rest density at ({:.4}, {:.4}, {:.4}) m, more than {:.0} %: a wall, or other \
         fluid, is nearer there than it may be; move the fluid away from there by a part of the spacing, or let walls that \
         are thinner than 1.2 spacings be thicker",
        100.0 * .0.max_error, .0.place.x, .0.place.y, .0.place.z, 100.0 * start::LARGEST_ERROR
    )]
    Compressed(StartDensity),
    /// The file of a mesh is gone or has become unusable since the scene was checked.
    #[error(transparent)]
    Mesh(#[from] MeshError),
    /// The system gave no threads.
    #[error("could not start threads: {0}")]
    Threads(#[from] rayon::ThreadPoolBuildError),
    /// The order file cannot be read.
    #[error("order file {}: {error}", .path.display())]
    OrderFile {
        /// The file.
        path: PathBuf,
        /// Why.
        error: std::io::Error,
    },
    /// The order is refused.
    #[error("{}: {error}", .path.as_ref().map_or_else(|| "default order".into(), |path| path.display().to_string()))]
    Order {
        /// The file, unless it is the default order.
        path: Option<PathBuf>,
        /// Why.
        error: OrderError,
    },
    /// Bevy refused the schedule.
    #[error("the schedule cannot be built: {0}")]
    Schedule(String),
}

/// The order of a scene, checked.
pub(super) fn order_of(scene: &Scene) -> Result<Order, InstallError> {
    let path = scene.order.as_ref().map(PathBuf::from);
    let order = match &path {
        None => Ok(Order::standard()),
        Some(path) => {
            let text = std::fs::read_to_string(path).map_err(|error| InstallError::OrderFile {
                path: path.clone(),
                error,
            })?;
            Order::parse(&text)
        }
    };
    let checked = order.and_then(|order| order.check(scene).map(|()| order));
    checked.map_err(|error| InstallError::Order { path, error })
}

/// Refuses an order file that cannot be.
pub(crate) fn check_order(scene: &Scene) -> Result<(), InstallError> {
    order_of(scene).map(|_| ())
}

/// Sets `scene` up in a world: spawns its particles, inserts what its step needs, adds the schedule [`Step`].
///
/// The host calls [`take_step`], or runs the schedule itself and finds the result in [`StepOutcome`]. An [`Execution`]
/// in the world is used; otherwise one with a thread for every core is made. Between steps the host may tag, move,
/// spawn (`(Fluid, Position(…))` is enough) and despawn fluid particles; after a change of boundary particles it calls
/// [`refresh_boundary`](crate::boundary::refresh_boundary).
pub fn install(world: &mut World, scene: &Scene) -> Result<(), InstallError> {
    if world.contains_resource::<Clock>() {
        return Err(InstallError::Occupied);
    }
    scene.check()?;
    let order = order_of(scene)?;
    if !world.contains_resource::<Execution>() {
        world.insert_resource(Execution::new(0)?);
    }
    warm_start::require_means(world, scene);
    let material = Material::new(scene);
    let particles = spawn_fluid(world, scene, &material)?;
    insert_step_resources(world, scene, &material);
    insert_boundary(world, scene)?;
    let (walls, execution) = (world.get_resource(), world.resource());
    start::density(scene, walls, execution)?;
    insert_forces(world, scene);
    match scene.pressure {
        PressureMethod::Sesph(sesph) => world.insert_resource(EquationOfState(sesph.equation)),
        PressureMethod::Pcisph(parameters) => pcisph::install(world, &parameters, &material),
        PressureMethod::Iisph(parameters) => iisph::install(world, parameters),
        PressureMethod::Dfsph(parameters) => dfsph::install(world, parameters),
    }
    if let Some(convergence) = Convergence::of(&scene.pressure) {
        world.insert_resource(convergence);
    }
    if let Some(start) = WarmStart::of(&scene.pressure) {
        warm_start::install(world, start);
    }
    add_schedules(world, scene, &order, particles)
}

/// Spawns the fluid, along the Z-curve if rows are to be kept in its order, and says how many there are.
fn spawn_fluid(
    world: &mut World,
    scene: &Scene,
    material: &Material,
) -> Result<usize, InstallError> {
    let seeds = shapes::fluid_particles(scene);
    let mut order: Vec<z_curve::Handle> = (0..seeds.len() as u32).map(|row| (0, row)).collect();
    let points: Vec<_> = seeds.iter().map(|seed| seed.position.extend(0.0)).collect();
    let execution = world.resource::<Execution>().clone();
    // What could not be indexed in the first step is refused before it.
    index::build(scene)
        .rebuild(&points, &execution)
        .map_err(InstallError::Fluid)?;
    if scene.reorder_interval > 0 {
        z_curve::sort_handles(&points, index::build(scene).grid(), &execution, &mut order);
    }
    let density = Density(material.rest_density);
    world.spawn_batch(order.into_iter().map(|(_, row)| {
        let seed = &seeds[row as usize];
        (
            particle::Fluid,
            Position(seed.position),
            Velocity(seed.velocity),
            density,
            particle::Pressure(0.0),
        )
    }));
    Ok(seeds.len())
}

fn insert_step_resources(world: &mut World, scene: &Scene, material: &Material) {
    let dt = time_step::install(world, scene);
    if let Some(bounds) = scene.domain {
        world.insert_resource(Domain(bounds));
    }
    if scene.reorder_interval > 0 {
        world.insert_resource(ReorderState::new(scene.reorder_interval));
    }
    if scene.neighbours == Neighbours::Stored {
        world.init_resource::<FluidNeighbours>();
        world.init_resource::<PairSlopes>();
    }
    world.insert_resource(Clock {
        next_dt: dt,
        dt,
        ..Clock::default()
    });
    world.insert_resource(*material);
    world.insert_resource(GuardLimits(scene.limits));
    world.insert_resource(FluidIndex {
        structure: index::build(scene),
        reordered: true,
    });
    world.init_resource::<Failure>();
    world.init_resource::<PhaseTimer>();
    world.init_resource::<StepOutcome>();
    world.init_resource::<Motion>();
    world.init_resource::<PressureSolve>();
    world.init_resource::<Positions>();
    world.init_resource::<PredictedPositions>();
    world.init_resource::<Velocities>();
    world.init_resource::<Densities>();
    world.init_resource::<Pressures>();
    world.init_resource::<Accelerations>();
    world.init_resource::<PressureAccelerations>();
}

fn insert_boundary(world: &mut World, scene: &Scene) -> Result<(), InstallError> {
    if scene.boundaries.is_empty() {
        return Ok(());
    }
    let sampled = boundary::sample(scene)?;
    let execution = world.resource::<Execution>().clone();
    let samples =
        BoundarySamples::new(scene, &sampled, &execution).map_err(InstallError::Boundary)?;
    let volumes: Vec<f32> = samples.points().iter().map(|sample| sample.w).collect();
    world.spawn_batch(sampled.into_iter().zip(volumes).map(|(sample, volume)| {
        (
            Boundary,
            Position(sample.position),
            BoundaryNormal(sample.normal),
            BoundaryVolume(volume),
        )
    }));
    world.insert_resource(samples);
    world.init_resource::<WallSums>();
    if let BoundaryHandling::DirectForcing(parameters) = scene.boundary_handling {
        let direct = DirectForcing::new(parameters, world.resource::<Material>());
        world.insert_resource(direct);
    }
    if scene.neighbours == Neighbours::Stored {
        world.init_resource::<BoundaryNeighbours>();
    }
    Ok(())
}

fn insert_forces(world: &mut World, scene: &Scene) {
    match scene.fluid.viscosity {
        Viscosity::None => {}
        Viscosity::Laminar {
            kinematic_viscosity,
        } => world.insert_resource(LaminarViscosity(kinematic_viscosity)),
        Viscosity::Artificial { alpha, sound_speed } => {
            world.insert_resource(ArtificialViscosity { alpha, sound_speed });
        }
    }
    if let SurfaceTension::BeckerTeschner { kappa } = scene.fluid.surface_tension {
        world.insert_resource(Cohesion(kappa));
    }
}

/// Takes one step of the scene that is installed in `world`. After an error the world holds the last good state.
///
/// Where its systems run one after the other ([`Executor`](crate::scene::Executor)) all of the step runs in the pool of the
/// loops, which then wake no thread each; in a world with data that is bound to a thread it runs on the thread that calls.
pub fn take_step(world: &mut World) -> Result<StepReport, StepError> {
    if world.contains_resource::<InTurn>() && world.storages().non_sends.is_empty() {
        let execution = world.resource::<Execution>().clone();
        execution.install(|| world.run_schedule(Step));
    } else {
        world.run_schedule(Step);
    }
    world.resource::<StepOutcome>().0.clone()
}

/// A scene running in a world of its own.
pub struct Simulation {
    world: World,
}

impl Simulation {
    /// Spawns the scene's particles into a new world, with as many threads as the machine has cores.
    pub fn new(scene: &Scene) -> Result<Self, InstallError> {
        Self::with_threads(scene, 0)
    }

    /// As [`new`](Self::new), with a number of threads; 0 takes all cores.
    pub fn with_threads(scene: &Scene, threads: usize) -> Result<Self, InstallError> {
        let mut world = World::new();
        world.insert_resource(Execution::new(threads)?);
        install(&mut world, scene)?;
        Ok(Self { world })
    }

    /// Takes one step. After an error the world holds the last good state.
    pub fn step(&mut self) -> Result<StepReport, StepError> {
        take_step(&mut self.world)
    }

    /// Simulated time [s].
    pub fn time(&self) -> f64 {
        self.world.resource::<Clock>().time
    }

    /// The world that holds the particles.
    pub fn world(&self) -> &World {
        &self.world
    }

    /// The world, to tag, spawn and despawn particles between steps.
    pub fn world_mut(&mut self) -> &mut World {
        &mut self.world
    }
}
