//! Copies the state of a world into a frame.

use bevy_ecs::prelude::*;

use super::Frame;
use crate::state::Clock;
use crate::state::particle::{Density, Fluid, ParticleId, Position, Pressure, Velocity};

impl Frame {
    /// Copies the state of all fluid particles of a world in which a scene is installed, as of the last step.
    pub fn from_world(world: &mut World) -> Self {
        let clock = world.get_resource::<Clock>().copied().unwrap_or_default();
        let mut frame = Self {
            step: clock.step,
            time: clock.time,
            ..Self::default()
        };
        let mut particles = world
            .query_filtered::<(&ParticleId, &Position, &Velocity, &Density, &Pressure), With<Fluid>>();
        // Columns that grow would have room for twice as many.
        frame.reserve(particles.iter(world).len());
        for (id, position, velocity, density, pressure) in particles.iter(world) {
            frame.ids.push(id.get());
            frame.positions.push(position.0);
            frame.velocities.push(velocity.0);
            frame.densities.push(density.0);
            frame.pressures.push(pressure.0);
        }
        frame
    }
}
