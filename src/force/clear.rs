//! The start of the forces.

use bevy_ecs::prelude::*;
use glam::Vec3;

use crate::state::{Accelerations, Execution, Phase, Positions, Product, Stage};

/// Zero accelerations, to which forces are added.
pub(crate) const STAGE: Stage = Stage {
    needs: &[Product::Columns],
    makes: &[Product::Forces],
    ..Stage::new("clear_forces", Phase::Forces, |_| {
        clear_forces.into_configs()
    })
};

/// Sets every acceleration to zero (phase `Forces`, first).
pub fn clear_forces(
    mut accelerations: ResMut<Accelerations>,
    positions: Res<Positions>,
    execution: Res<Execution>,
) {
    accelerations.0.resize(positions.rows(), Vec3::ZERO);
    execution.for_each_chunk(&mut accelerations.0, |_, chunk| chunk.fill(Vec3::ZERO));
}
