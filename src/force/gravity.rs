//! Gravity: the same acceleration for every particle.

use bevy_ecs::prelude::*;

use crate::state::{Accelerations, Clock, Execution, Material, Phase, Product, Stage};

/// Gravity.
pub(crate) const STAGE: Stage = Stage {
    needs: &[Product::Columns, Product::Forces],
    ..Stage::new("gravity", Phase::Forces, |_| apply_gravity.into_configs())
};

/// Adds gravity to every acceleration (phase `Forces`).
pub fn apply_gravity(
    mut accelerations: ResMut<Accelerations>,
    (material, clock): (Res<Material>, Res<Clock>),
    execution: Res<Execution>,
) {
    let part = material.part_of_gravity(clock.time, clock.dt.into());
    let gravity = part * material.gravity;
    execution.for_each_chunk(&mut accelerations.0, |_, chunk| {
        for acceleration in chunk {
            *acceleration += gravity;
        }
    });
}
