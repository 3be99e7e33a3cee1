//! Emitters: particles that enter at the end of a step.

use bevy_ecs::prelude::*;
use glam::Vec3;

use super::{
    changes::Changes,
    held::Held,
    sources::{Emitters, Entering, Turnover},
};
use crate::{
    reorder::{self, Reordered},
    state::{
        Clock, Material,
        particle::{Density, Fluid, Position, Pressure, Velocity},
    },
};

/// Where other fluid is nearer than this, a place is taken \[spacings].
const TAKEN: f32 = 0.7;

/// Leaves out particles that would enter on top of free fluid: water flows behind the face of an emitter that stands
/// in it. Two particles in one place would have twice the density at rest.
fn keep_free_places(world: &mut World, entering: &mut Vec<Entering>) {
    let Some(&(first, _, _)) = entering.first() else {
        return;
    };
    let &Material {
        period, spacing, ..
    } = world.resource::<Material>();
    let closest = TAKEN * spacing;
    // The box around all of them, as seen from the first.
    let arms = entering.iter().map(|(place, _, _)| *place - first);
    let (low, high) = arms.fold((Vec3::ZERO, Vec3::ZERO), |(low, high), arm| {
        (low.min(arm), high.max(arm))
    });
    let (middle, half) = (first + 0.5 * (low + high), 0.5 * (high - low) + closest);
    let mut fluid = world.query_filtered::<(&Position, &Held), With<Fluid>>();
    let others: Vec<Vec3> = (fluid.iter(world))
        .filter(|(_, held)| **held == Held(0))
        .map(|(position, _)| position.0)
        .filter(|position| {
            let arm = period.nearest(*position - middle);
            arm.abs().cmple(half).all()
        })
        .collect();
    entering.retain(|(place, _, _)| {
        let mut apart = others.iter().map(|other| period.nearest(*place - *other));
        apart.all(|arm| arm.length() >= closest)
    });
}

/// Spawns the particles that have entered (phase `Reorder`, after the rows were reordered).
pub(super) fn emit(world: &mut World) {
    let time = world.resource::<Clock>().time;
    let (mut entering, longest) = world.resource_mut::<Emitters>().enter(time);
    let due = entering.len();
    keep_free_places(world, &mut entering);
    world.resource_mut::<Turnover>().without_place += (due - entering.len()) as u64;
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
