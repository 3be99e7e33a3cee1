//! Removes a scene from a world.

use std::collections::HashSet;

use bevy_ecs::{component::ComponentId, entity_disabling::Disabled, prelude::*};

use super::schedule::Labels;
use crate::state::particle::{Boundary, Fluid};

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

/// Ids of the resources of a world.
pub(super) fn resources(world: &World) -> HashSet<ComponentId> {
    world.iter_resources().map(|(id, ..)| id).collect()
}

/// Records the resources that were added to the world since `before`.
pub(super) fn note_installed(world: &mut World, before: &HashSet<ComponentId>) {
    let new = resources(world)
        .into_iter()
        .filter(|id| !before.contains(id));
    let resources = new.collect();
    world.insert_resource(Installed {
        resources,
        running: false,
    });
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
    world.remove_resource::<Installed>();
    type Particle = (Or<(With<Fluid>, With<Boundary>)>, Allow<Disabled>);
    let mut particles = world.query_filtered::<Entity, Particle>();
    let particles: Vec<Entity> = particles.iter(world).collect();
    for particle in particles {
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
    Ok(())
}
