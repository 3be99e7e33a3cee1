//! Taking a scene out of a world again.

use std::collections::HashSet;

use bevy_ecs::{component::ComponentId, entity_disabling::Disabled, prelude::*};

use super::schedule::Labels;
use crate::state::particle::{Boundary, Fluid};

/// What [`install`](super::install) put into a world.
#[derive(Resource, Debug)]
struct Installed {
    /// Resources that were not there before, whichever stage brought them.
    resources: Vec<ComponentId>,
    /// Whether a step is being taken.
    running: bool,
}

/// Why a scene cannot be taken out of a world.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum UninstallError {
    /// There is none.
    #[error("no scene is installed in this world")]
    NotInstalled,
    /// A system of the step asks for it.
    #[error("a system cannot take the scene away in the middle of its step; do it between steps")]
    WithinStep,
}

/// Ids of the resources of a world.
pub(super) fn resources(world: &World) -> HashSet<ComponentId> {
    world.iter_resources().map(|(id, ..)| id).collect()
}

/// Notes what came into the world since it had these resources.
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

/// Notes whether a step is being taken.
pub(super) fn set_running(world: &mut World, running: bool) {
    if let Some(mut installed) = world.get_resource_mut::<Installed>() {
        installed.running = running;
    }
}

/// Takes the scene out of a world: all fluid and boundary particles, those that the host spawned included; the schedule
/// [`Step`](super::Step) and those of solvers, with the systems that the host added to them; the resources that
/// [`install`](super::install) and the stages brought. What the host had before, stages and threads of its own
/// included, stays. Another scene, or the same, may then be installed, and runs as in a new world.
///
/// A scene of which a panic took a part away is taken out as well.
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
        // Children of a particle go with it, and may be particles, too.
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
