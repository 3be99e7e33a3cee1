//! Gravity: the same acceleration for every particle.

use bevy_ecs::prelude::*;

use crate::{
    column::{Accelerations, Positions},
    material::Material,
};

/// Sets every acceleration to gravity (phase `Forces`, first).
pub fn apply_gravity(
    mut accelerations: ResMut<Accelerations>,
    positions: Res<Positions>,
    material: Res<Material>,
) {
    accelerations.0.clear();
    accelerations.0.resize(positions.rows(), material.gravity);
}
