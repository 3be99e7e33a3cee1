//! Gravity: the same acceleration for every particle.

use bevy_ecs::prelude::*;

use crate::state::{Accelerations, Execution, Material, Positions};

/// Sets every acceleration to gravity (phase `Forces`, first).
pub fn apply_gravity(
    mut accelerations: ResMut<Accelerations>,
    positions: Res<Positions>,
    material: Res<Material>,
    execution: Res<Execution>,
) {
    accelerations.0.resize(positions.rows(), material.gravity);
    execution.for_each_chunk(&mut accelerations.0, |_, chunk| {
        chunk.fill(material.gravity)
    });
}
