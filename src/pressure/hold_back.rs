//! Walls hold back rows at a free surface.
//!
//! Samples of a wall push a row with its own pressure. At a free surface a row has none, and the pressure of the rows
//! below would push it into the wall: it left the surface of still water with 0.1 sqrt(g H). After the solve, which
//! stays linear in the pressures, such a row loses the part of its acceleration that points into the wall.

use bevy_ecs::prelude::*;
use glam::Vec3;

use crate::{
    boundary::sums::{BoundarySums, Walls},
    scene::Scene,
    state::{Execution, PressureAccelerations, Pressures},
};

/// What walls held back in this step, by row \[m/s²]; in scenes that measure forces.
#[derive(Resource, Debug, Default)]
pub(crate) struct HeldBack(pub(crate) Vec<Vec3>);

/// Whether a scene's walls hold rows back: not with an equation of state, whose force is the gradient of its energy,
/// nor with PCISPH, which promises the density at the positions that it has predicted.
pub(super) fn is_wanted(scene: &Scene) -> bool {
    let iterations = scene.pressure.iterations();
    !scene.boundaries.is_empty() && iterations.is_some_and(|iterations| iterations.is_linear)
}

/// Holds back rows without a pressure (phase `Pressure`, after the solve).
pub(super) fn hold_back(
    mut accelerations: ResMut<PressureAccelerations>,
    mut held: Option<ResMut<HeldBack>>,
    pressures: Res<Pressures>,
    walls: Res<BoundarySums>,
    execution: Res<Execution>,
) {
    let walls = Walls::of(Some(&walls));
    let inwards = |row: usize, acceleration: Vec3| {
        if pressures.0[row] == 0.0 && walls.share(row) > 0.0 {
            let inwards = walls.gradient(row).normalize_or_zero();
            acceleration.dot(inwards).max(0.0) * inwards
        } else {
            Vec3::ZERO
        }
    };
    if let Some(held) = &mut held {
        held.0.resize(accelerations.0.len(), Vec3::ZERO);
        execution.for_each_chunk(&mut held.0, |first, held| {
            for (row, (held, acceleration)) in
                (first..).zip(held.iter_mut().zip(&accelerations.0[first..]))
            {
                *held = inwards(row, *acceleration);
            }
        });
    }
    execution.for_each_chunk(&mut accelerations.0, |first, accelerations| {
        for (row, acceleration) in (first..).zip(accelerations) {
            *acceleration -= inwards(row, *acceleration);
        }
    });
}
