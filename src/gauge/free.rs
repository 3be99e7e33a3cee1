//! Velocities before walls correct them.

use bevy_ecs::prelude::*;
use glam::Vec4;

use crate::state::{Execution, Positions, Velocities};

/// Velocities before walls correct them \[m/s]; in scenes that measure forces.
#[derive(Resource, Debug, Default)]
pub(crate) struct FreeVelocities(pub Vec<Vec4>);

/// Stores the velocities after integration (phase `Integrate`, before contact).
pub(crate) fn keep_velocities(
    mut kept: ResMut<FreeVelocities>,
    velocities: Res<Velocities>,
    positions: Res<Positions>,
    execution: Res<Execution>,
) {
    let rows = positions.rows();
    kept.0.resize(rows, Vec4::ZERO);
    execution.copy(&mut kept.0, &velocities.0[..rows]);
}
