//! Setting a scene up in a world.

use std::{
    panic::{AssertUnwindSafe, catch_unwind, resume_unwind},
    path::PathBuf,
};

use bevy_ecs::prelude::*;

use super::{
    memory,
    order::{Order, OrderError},
    report::{StepOutcome, StepReport},
    schedule::{InTurn, Labels, Step, build_schedules},
    start::{FluidStart, Walls},
    start_density::{self, StartDensity},
    timer::PhaseTimer,
};
use crate::{
    force::{ArtificialViscosity, Cohesion, LaminarViscosity, NumericalViscosity},
    gauge,
    index::{self, FluidIndex},
    input::read_text,
    integrate::{Domain, GuardLimits, Motion},
    mesh::MeshError,
    neighbours::FluidNeighbours,
    pairs::PairSlopes,
    pressure::{
        PressureSolve, dfsph, iisph, pcisph,
        solve::Convergence,
        state_equation::EquationOfState,
        warm_start::{self, WarmStart},
    },
    reorder::ReorderState,
    scene::{Neighbours, PressureMethod, Scene, SceneError, SurfaceTension, Viscosity},
    state::{
        Accelerations, Densities, DomainTooLarge, Execution, Material, Positions,
        PredictedPositions, PressureAccelerations, Pressures, Rows, Velocities,
        particle::number_particles,
    },
    state::{Clock, Failure, FailureCause, StepError},
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
        100.0 * .0.max_error, .0.place.x, .0.place.y, .0.place.z, 100.0 * start_density::LARGEST_ERROR
    )]
    Compressed(StartDensity),
    /// The file of a mesh is gone or has become unusable since the scene was checked.
    #[error(transparent)]
    Mesh(#[from] MeshError),
    /// The system gave no threads.
    #[error("could not start threads: {0}")]
    Threads(#[from] rayon::ThreadPoolBuildError),
    /// The system gave no threads for systems that run side by side.
    #[error("could not start threads for systems: {0}")]
    TaskThreads(std::io::Error),
    /// The machine has too little memory for the scene.
    #[error(
        "the scene needs about {needed} of memory, and there are {machine}: {parts}; a spacing of {better} m would do, or a \
         smaller scene"
    )]
    Memory {
        /// What it needs.
        needed: String,
        /// What there is.
        machine: String,
        /// What it is needed for.
        parts: String,
        /// A spacing that would do [m].
        better: String,
    },
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
            let text = read_text(path).map_err(|error| InstallError::OrderFile {
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
///
/// After an error the world holds nothing of the scene, and another may be installed.
pub fn install(world: &mut World, scene: &Scene) -> Result<(), InstallError> {
    if world.contains_resource::<Clock>() {
        return Err(InstallError::Occupied);
    }
    let size = scene.checked_size()?;
    let order = order_of(scene)?;
    memory::check(scene, &size)?;
    let execution = match world.get_resource::<Execution>() {
        Some(execution) => execution.clone(),
        None => Execution::new(0)?,
    };
    // All that may fail comes before the first change of the world.
    let material = Material::new(scene);
    let fluid = FluidStart::new(scene, &execution)?;
    let walls = Walls::new(scene, &execution)?;
    if start_density::is_asked(&size) {
        let samples = walls.as_ref().map(|walls| &walls.samples);
        start_density::of(scene, &fluid.seeds, samples, &execution)?;
    }
    let schedules = build_schedules(world, scene, &order, fluid.seeds.len(), execution.threads())?;
    world.insert_resource(execution);
    warm_start::require_means(world, scene);
    number_particles(world);
    fluid.spawn(world, &material);
    insert_step_resources(world, scene, &material);
    if let Some(walls) = walls {
        walls.spawn(world, scene);
    }
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
    gauge::install(world, scene);
    schedules.add(world);
    Ok(())
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
    world.init_resource::<Rows>();
    world.init_resource::<Positions>();
    world.init_resource::<PredictedPositions>();
    world.init_resource::<Velocities>();
    world.init_resource::<Densities>();
    world.init_resource::<Pressures>();
    world.init_resource::<Accelerations>();
    world.init_resource::<PressureAccelerations>();
}

fn insert_forces(world: &mut World, scene: &Scene) {
    match scene.fluid.viscosity {
        Viscosity::None => {}
        Viscosity::Laminar {
            kinematic_viscosity,
            numerical,
        } => {
            world.insert_resource(LaminarViscosity(kinematic_viscosity));
            if numerical > 0.0 {
                world.insert_resource(NumericalViscosity(numerical));
            }
        }
        Viscosity::Artificial { alpha, sound_speed } => {
            world.insert_resource(ArtificialViscosity { alpha, sound_speed });
        }
    }
    if let SurfaceTension::BeckerTeschner { kappa } = scene.fluid.surface_tension {
        world.insert_resource(Cohesion(kappa));
    }
}

/// Takes one step of the scene that is installed in `world`. After an error the world holds the last good state. Fails,
/// too, if no scene is installed, or if a panic that the host caught took a part of it away.
///
/// Where its systems run one after the other ([`Executor`](crate::scene::Executor)) all of the step runs in the pool of
/// the loops, which then wake no thread each; in a world with data that is bound to a thread it runs on the thread that
/// calls.
///
/// # Panics
///
/// If a system of the host's panics. The tables then hold the last good state, and the next step can be taken: the
/// state before the step or, where systems run beside each other, that after it, since the engine's own go on to the
/// end.
pub fn take_step(world: &mut World) -> Result<StepReport, StepError> {
    if let Some(reason) = what_is_missing(world) {
        let clock = world.get_resource::<Clock>().copied().unwrap_or_default();
        return Err(StepError {
            step: clock.step + 1,
            time: clock.time,
            particle: None,
            cause: FailureCause::NotInstalled { reason },
        });
    }
    if world.contains_resource::<InTurn>() && world.storages().non_sends.is_empty() {
        let execution = world.resource::<Execution>().clone();
        execution.install(|| run_step(world));
    } else {
        run_step(world);
    }
    world.resource::<StepOutcome>().0.clone()
}

/// Runs the schedule of the step. If a system panics, the schedule is put back before the panic goes on.
fn run_step(world: &mut World) {
    let ran = world.try_schedule_scope(Step, |world, step| {
        catch_unwind(AssertUnwindSafe(|| step.run(world)))
    });
    if let Ok(Err(panic)) = ran {
        resume_unwind(panic);
    }
}

/// Why no step can be taken in this world, if none can.
fn what_is_missing(world: &World) -> Option<&'static str> {
    let Some(labels) = world.get_resource::<Labels>() else {
        return Some("no scene is installed in this world; call `install` first");
    };
    let schedules = world.get_resource::<Schedules>();
    let present = |label| schedules.is_some_and(|schedules| schedules.contains(label));
    let all = labels.0.iter().all(|&label| present(label));
    let lost = !all || !world.contains_resource::<Execution>();
    lost.then_some(
        "a panic or the host took a part of the scene out of the world; install it in a new one, and run steps by \
         `take_step`, which keeps them through a panic",
    )
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

    /// Takes one step that does not pass `until` [s]: the last before it is shortened, and ends there exactly.
    pub fn step_until(&mut self, until: f64) -> Result<StepReport, StepError> {
        self.set_until(Some(until));
        // After a panic of a host's system the next step has its own length again.
        let taken = catch_unwind(AssertUnwindSafe(|| self.step()));
        self.set_until(None);
        taken.unwrap_or_else(|panic| resume_unwind(panic))
    }

    fn set_until(&mut self, until: Option<f64>) {
        // A host may have taken the clock away: then the step says so.
        if let Some(mut clock) = self.world.get_resource_mut::<Clock>() {
            clock.until = until;
        }
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
