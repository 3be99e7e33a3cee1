//! Positions in the box that repeats, in scenes with periodic axes.

use bevy_ecs::prelude::*;
use glam::Vec4;

use super::{
    columns::{Positions, PredictedPositions},
    execution::Execution,
    material::Material,
};

/// Wraps the positions that a step starts from (phase `RebuildIndex`): a host may have put particles anywhere.
pub fn wrap_start(
    mut positions: ResMut<Positions>,
    material: Res<Material>,
    execution: Res<Execution>,
) {
    let rows = positions.rows();
    wrap(&mut positions.0[..rows], &material, &execution);
}

/// Wraps the positions at the end of a step (phase `Integrate`, after walls have corrected the motion).
pub fn wrap_end(
    mut predicted: ResMut<PredictedPositions>,
    positions: Res<Positions>,
    material: Res<Material>,
    execution: Res<Execution>,
) {
    let rows = positions.rows();
    wrap(&mut predicted.0[..rows], &material, &execution);
}

fn wrap(points: &mut [Vec4], material: &Material, execution: &Execution) {
    let period = material.period;
    execution.for_each_chunk(points, |_, points| {
        for point in points {
            *point = period.wrap(point.truncate()).extend(point.w);
        }
    });
}
