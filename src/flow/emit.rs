//! Emitters: particles that enter at the end of a step.

use bevy_ecs::prelude::*;

use super::{
    changes::Changes,
    held::Held,
    sources::{Emitters, Turnover},
};
use crate::{
    reorder::{self, Reordered},
    state::{
        Clock, Material,
        particle::{Density, Fluid, Position, Pressure, Velocity},
    },
};

/// Spawns the particles that have entered (phase `Reorder`, after the rows were reordered).
pub(super) fn emit(world: &mut World) {
    let time = world.resource::<Clock>().time;
    let (entering, longest) = world.resource_mut::<Emitters>().enter(time);
    if entering.is_empty() {
        return;
    }
    // The next step was chosen without them.
    let mut clock = world.resource_mut::<Clock>();
    clock.next_dt = clock.next_dt.min(longest);
    let density = Density(world.resource::<Material>().rest_density);
    let particles = entering.into_iter().map(|(place, velocity, emitter)| {
        (
            Fluid,
            Position(place),
            Velocity(velocity),
            density,
            Pressure(0.0),
            Held(emitter),
        )
    });
    // In the table where the others are: rows of one table keep their order in a checkpoint.
    let spawned: Vec<Entity> = if reorder::is_marked(world) {
        let particles = particles.map(|particle| (particle, Reordered));
        world.spawn_batch(particles).collect()
    } else {
        world.spawn_batch(particles).collect()
    };
    world.resource_mut::<Turnover>().emitted += spawned.len() as u64;
    if let Some(mut changes) = world.get_resource_mut::<Changes>() {
        changes.came.extend(spawned);
    }
}
