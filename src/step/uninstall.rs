//! Removes a scene from a world.

use std::{
    collections::HashSet,
    panic::{AssertUnwindSafe, catch_unwind},
};

use bevy_ecs::{component::ComponentId, entity_disabling::Disabled, prelude::*};

use super::schedule::{Labels, Step};
use crate::state::{
    Execution,
    particle::{Boundary, Fluid},
    seal::Seal,
};

/// What [`install`](super::install) added to a world.
#[derive(Resource, Debug)]
struct Installed {
    /// Resources that did not exist before; stages may have inserted them.
    resources: Vec<ComponentId>,
    /// Whether a step is being taken.
    running: bool,
}

/// Why a scene cannot be removed from a world.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum UninstallError {
    /// No scene is installed.
    #[error("no scene is installed in this world")]
    NotInstalled,
    /// A system of the step called it.
    #[error("a system cannot take the scene away in the middle of its step; do it between steps")]
    WithinStep,
}

type Particle = (Or<(With<Fluid>, With<Boundary>)>, Allow<Disabled>);

/// Ids of the resources of a world.
fn resources(world: &World) -> HashSet<ComponentId> {
    world.iter_resources().map(|(id, ..)| id).collect()
}

fn particles(world: &mut World) -> Vec<Entity> {
    let mut particles = world.query_filtered::<Entity, Particle>();
    particles.iter(world).collect()
}

/// What a world holds before a scene is installed.
pub(super) struct Before {
    pub(super) resources: HashSet<ComponentId>,
    particles: HashSet<Entity>,
}

impl Before {
    pub(super) fn of(world: &mut World) -> Self {
        Self {
            resources: resources(world),
            particles: particles(world).into_iter().collect(),
        }
    }

    /// Removes what a scene has put into the world since, `others` of its entities included. The host's observers may
    /// panic again.
    pub(super) fn restore(&self, world: &mut World, mut others: Vec<Entity>) {
        others.extend(particles(world));
        for entity in others
            .into_iter()
            .filter(|entity| !self.particles.contains(entity))
        {
            let gone = || world.try_despawn(entity).ok();
            catch_unwind(AssertUnwindSafe(gone)).ok();
        }
        for resource in resources(world).difference(&self.resources) {
            world.remove_resource_by_id(*resource);
        }
        if let Some(mut schedules) = world.get_resource_mut::<Schedules>() {
            schedules.remove(Step);
        }
    }
}

/// Records the resources that were added to the world since `before`, and returns them.
pub(super) fn note_installed(world: &mut World, before: &HashSet<ComponentId>) -> Vec<ComponentId> {
    world.init_resource::<Seal>();
    let new = resources(world)
        .into_iter()
        .filter(|id| !before.contains(id));
    let resources: Vec<_> = new.collect();
    world.insert_resource(Installed {
        resources: resources.clone(),
        running: false,
    });
    resources
}

/// Records whether a step is being taken.
pub(super) fn set_running(world: &mut World, running: bool) {
    if let Some(mut installed) = world.get_resource_mut::<Installed>() {
        installed.running = running;
    }
}

/// Removes the scene from a world: all fluid and boundary particles, also those that the host spawned; the schedule
/// [`Step`](super::Step) and those of solvers, with the systems that the host added to them; the resources that
/// [`install`](super::install) and the stages inserted. What the host had before stays, its own stages and threads
/// included. The same or another scene may then be installed and runs as in a new world.
///
/// This also removes a scene of which a panic destroyed a part.
pub fn uninstall(world: &mut World) -> Result<(), UninstallError> {
    let Some(installed) = world.get_resource::<Installed>() else {
        return Err(UninstallError::NotInstalled);
    };
    if installed.running {
        return Err(UninstallError::WithinStep);
    }
    let resources = installed.resources.clone();
    for particle in particles(world) {
        // Despawning a particle also despawns its children, which may be particles, too.
        world.try_despawn(particle).ok();
    }
    if let Some(labels) = world.remove_resource::<Labels>()
        && let Some(mut schedules) = world.get_resource_mut::<Schedules>()
    {
        for label in labels.0 {
            schedules.remove(label);
        }
    }
    for resource in resources {
        world.remove_resource_by_id(resource);
    }
    if let Some(mut execution) = world.get_resource_mut::<Execution>() {
        execution.set_team(None);
    }
    // Last: after the panic of a host's observer the rest can still be removed.
    world.remove_resource::<Installed>();
    Ok(())
}

/// Whether a scene is installed in a world.
pub(super) fn is_installed(world: &World) -> bool {
    world.contains_resource::<Installed>()
}

/// Why nothing may be read or changed as a whole, as between steps.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum NotBetweenSteps {
    /// A system of the step called it.
    #[error("a system cannot do this in the middle of a step; do it between steps")]
    WithinStep,
    /// A resource of the scene is gone.
    #[error(
        "the world lacks the resource `{0}` of the scene, which a host removed; insert it again"
    )]
    LacksResource(String),
}

/// Fails unless a world is between two steps, with all that the scene has put into it.
pub(crate) fn between_steps(world: &World) -> Result<(), NotBetweenSteps> {
    if is_running(world) {
        return Err(NotBetweenSteps::WithinStep);
    }
    match lost_resource(world) {
        Some(name) => Err(NotBetweenSteps::LacksResource(name)),
        None => Ok(()),
    }
}

/// Whether a step is being taken.
pub(super) fn is_running(world: &World) -> bool {
    let installed = world.get_resource::<Installed>();
    installed.is_some_and(|installed| installed.running)
}

/// Name of a resource of the scene that the world lacks, if there is one.
pub(super) fn lost_resource(world: &World) -> Option<String> {
    let installed = world.get_resource::<Installed>()?;
    let mut ids = installed.resources.iter();
    let lost = *ids.find(|&&id| !world.contains_resource_by_id(id))?;
    let name = world.components().get_name(lost)?;
    Some(name.shortname().to_string())
}
