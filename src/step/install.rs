//! Setting a scene up in a world.

use std::{
    panic::{AssertUnwindSafe, catch_unwind, resume_unwind},
    path::Path,
    sync::Arc,
};

use bevy_ecs::prelude::*;

use super::{
    advance::Owed,
    compose,
    constants::SceneMaterial,
    error::InstallError,
    installed::{Installed, NamedFile},
    memory,
    order::{limits_of, order_of},
    report::StepOutcome,
    schedule::{Step, build_schedules},
    sealed::seal_installed,
    start::{FluidStart, Walls},
    start_density, start_slabs,
    timer::PhaseTimer,
    uninstall::{Before, is_installed, note_installed},
};
use crate::{
    communicator::{Communicator, Team},
    flow, gauge, input,
    pairs::choice::KernelChoice,
    pressure::warm_start,
    ranks,
    registry::Stages,
    scene::Scene,
    state::{BodyForces, Clock, Execution, Failure, Material, Stage, particle::number_particles},
    time_step::{self, StepLimits},
};

/// Installs `scene` in a world: spawns its particles, inserts the resources of its step, adds the schedule `Step`.
///
/// The host then calls [`take_step`](super::take_step), or runs the schedule itself and reads [`StepOutcome`]. An
/// [`Execution`] that the world already has is used; otherwise one with a thread per core is created. Between steps the
/// host may tag, move, spawn (`(Fluid, Position(…))` is enough) and despawn fluid particles; after it changed boundary
/// particles it calls [`refresh_boundary`](crate::boundary::refresh_boundary).
///
/// [`uninstall`](super::uninstall()) removes the scene again.
///
/// After an error, and after the panic of a host's observer or stage, the world holds nothing of the scene, and another
/// one may be installed.
///
/// # Panics
///
/// If an observer or a stage of the host panics.
pub fn install(world: &mut World, scene: &Scene) -> Result<(), InstallError> {
    if is_installed(world) {
        return Err(InstallError::Occupied);
    }
    let schedules = world.get_resource::<Schedules>();
    let systems = schedules.and_then(|schedules| schedules.get(Step));
    if let Some(systems) = systems.map(Schedule::systems_len).filter(|&len| len > 0) {
        return Err(InstallError::StepHasSystems { systems });
    }
    let size = scene.checked_size()?;
    let stages = world.get_resource::<Stages>().cloned().unwrap_or_default();
    let order = order_of(scene, &stages)?;
    let execution = match world.get_resource::<Execution>() {
        Some(execution) => execution.clone(),
        None => Execution::new(0).map_err(InstallError::Threads)?,
    };
    memory::check(scene, &size, 0.0, execution.threads())?;
    // Everything that can fail comes before the first change of the world.
    let files = fingerprints(scene);
    let material = Material::new(scene);
    let fluid = FluidStart::new(scene, &execution)?;
    let walls = Walls::new(scene, &execution)?;
    let body_forces = BodyForces::new(scene)?;
    if start_density::is_small(scene, &size) {
        let samples = walls.as_ref().map(|walls| &walls.samples);
        start_density::of(scene, &fluid.seeds, samples, &execution)?;
    } else {
        let samples = walls.as_ref().map_or(&[][..], |walls| &walls.sampled);
        start_slabs::of_large(scene, &size, Some(samples), &execution)?;
    }
    let before = Before::of(world);
    let schedules = build_schedules(world, scene, &order, execution.threads())?;
    let with_kernels = order.with_kernels();
    let limits = step_limits(scene, &stages, &with_kernels);
    let mut spare = Vec::new();
    let put = |world: &mut World, spare: &mut Vec<Entity>| {
        world.insert_resource(execution);
        warm_start::require_means(world, scene);
        flow::require_held(world, scene);
        number_particles(world);
        *spare = spare_entities(world);
        fluid.spawn(world, &material);
        let mut insert = |world: &mut World| {
            spare.drain(..).for_each(|entity| {
                world.despawn(entity);
            });
            insert_resources(world, scene, &material, &limits);
        };
        match walls {
            Some(walls) => walls.spawn(world, scene, insert),
            None => insert(world),
        }
        if !scene.body_forces.is_empty() {
            world.insert_resource(body_forces);
        }
        for stage in order.installed() {
            (stage.install)(world, scene);
        }
        ranks::install(world, scene);
        compose::install(world, &order);
        gauge::install(world, scene);
        world.insert_resource(Installed {
            scene: scene.clone(),
            files,
            stages: order.names(),
            due: order.stages().map(|planned| planned.due).collect(),
            reads_stale: order.reads_stale(),
            with_kernels,
        });
        schedules.add(world);
        let new = note_installed(world, &before.resources);
        seal_installed(world, &new);
    };
    // An observer or a stage of the host may panic.
    if let Err(panic) = catch_unwind(AssertUnwindSafe(|| put(world, &mut spare))) {
        before.restore(world, spare);
        resume_unwind(panic);
    }
    Ok(())
}

/// Installs `scene` as one of several ranks, worlds that share its particles: this world holds the particles of its own
/// rows, and every step gives them the bits that they have on one rank.
///
/// All ranks install the same scene and take the same steps, each in a thread of its own: a step waits for the others.
/// They need pools of their own, too: an [`Execution`] per rank. Walls are on every rank. Particles go to another rank
/// when rows are reordered, and a host's own components stay behind. A host may change the constants of a step if it
/// does so on all ranks, and may not spawn, despawn or tag particles.
///
/// # Errors
/// Those of [`install`], and [`InstallError::Unsupported`] if the scene asks for what does not run on several ranks.
///
/// # Panics
///
/// As [`install`].
pub fn install_on_rank(
    world: &mut World,
    scene: &Scene,
    communicator: Arc<dyn Communicator>,
) -> Result<(), InstallError> {
    if communicator.ranks() == 1 {
        return install(world, scene);
    }
    if let Some(unsupported) = ranks::unsupported(scene) {
        return Err(InstallError::Unsupported(unsupported));
    }
    let before = world.get_resource::<Execution>().cloned();
    let mut execution = match &before {
        Some(execution) => execution.clone(),
        None => Execution::new(0).map_err(InstallError::Threads)?,
    };
    execution.set_team(Some(Team::new(communicator)));
    world.insert_resource(execution);
    let installed = install(world, scene);
    if installed.is_err() {
        match before {
            Some(execution) => world.insert_resource(execution),
            None => {
                world.remove_resource::<Execution>();
            }
        }
    }
    installed
}

/// More resources than a scene and its stages have.
const MOST_RESOURCES: u32 = 256;

/// Entities from before the particles, whose numbers resources take over when they are despawned.
///
/// A resource is a component of an entity of its own, in a sparse set: an array of 4 bytes for every entity up to it.
/// Forty resources after the particles would take 160 bytes more for each particle than before them.
fn spare_entities(world: &mut World) -> Vec<Entity> {
    (0..MOST_RESOURCES)
        .map(|_| world.spawn_empty().id())
        .collect()
}

/// The files that a scene names. One that cannot be read has no content: whoever needs it has refused it.
fn fingerprints(scene: &Scene) -> Vec<NamedFile> {
    let mut scene = scene.clone();
    let of = |path: &mut String| {
        let (length, sum) = input::fingerprint(Path::new(path)).unwrap_or_default();
        (std::mem::take(path), length, sum)
    };
    scene.files_mut().map(of).collect()
}

/// What the control of a scene's time step knows of its physics, stages with kernels of their own included.
pub(super) fn step_limits(
    scene: &Scene,
    stages: &Stages,
    with_kernels: &[(Stage, KernelChoice)],
) -> StepLimits {
    let mut limits = stages.step_limits(scene);
    let of_kernels = limits_of(with_kernels, scene);
    limits.constant = of_kernels
        .iter()
        .fold(limits.constant, |least, of| least.min(of.1));
    limits
}

/// Inserts the resources of every step, whatever its stages are.
fn insert_resources(world: &mut World, scene: &Scene, material: &Material, limits: &StepLimits) {
    let dt = time_step::install(world, scene, limits);
    world.insert_resource(Clock {
        next_dt: dt,
        dt,
        ..Clock::default()
    });
    world.insert_resource(*material);
    world.insert_resource(SceneMaterial(*material));
    world.init_resource::<Failure>();
    world.init_resource::<PhaseTimer>();
    world.init_resource::<StepOutcome>();
    world.init_resource::<Owed>();
}
