//! The last resort at a wall: no particle passes the layer of samples.
//!
//! Pressure keeps the fluid off a wall, but a particle on its own has no pressure there: its density, wall included, is
//! below the rest density until it lies in the wall. Spray would leak. So after integration a particle that is more than
//! a quarter of the spacing behind the wall's face, where fluid under pressure does not get, is set back to there along
//! the normal and loses the velocity into the wall; the velocity along the wall stays.
//!
//! A sample speaks for the particles above it: those whose distance along the face is under 1.15 spacings. The middle of
//! four samples is 0.71 away, the last row of a face beside a tank's edge 0.83; the second row around a convex edge, which
//! must not be heard on the other side, at least 1.2. In a corner one face after the other is obeyed.
//!
//! It speaks only for particles that were in front of it at the start of the step: those behind it are on the other side
//! of a thin wall, and this one would pull them through.

use bevy_ecs::prelude::*;
use glam::{Vec3, Vec4};

use super::BoundarySamples;
use crate::{
    column::{PredictedPositions, Velocities},
    material::Material,
    pairs::Pairs,
};

/// How far a particle may get behind the face of a wall, in spacings.
const PENETRATION: f32 = 0.25;
/// Distance along the face up to which a sample counts, in spacings.
const SIDEWAYS: f32 = 1.15;
/// Corrections of one particle at most: three faces meet in a corner, and samples in its edges have normals between.
const CORRECTIONS: usize = 8;

/// Sets back what came too near to a wall (phase `Integrate`).
pub fn keep_outside(
    mut predicted: ResMut<PredictedPositions>,
    mut velocities: ResMut<Velocities>,
    boundary: Res<BoundarySamples>,
    material: Res<Material>,
    pairs: Pairs,
) {
    let rows = pairs.positions().rows();
    let wall = Wall {
        clearance: boundary.layer_depth - PENETRATION * material.spacing,
        boundary: &boundary,
        spacing: material.spacing,
    };
    let columns = (&mut predicted.0[..rows], &mut velocities.0[..rows]);
    let start = &pairs.positions().0;
    pairs.update_near_boundary(columns, |row, samples, position, velocity| {
        wall.keep_outside(start[row].truncate(), samples, position, velocity)
    });
}

struct Wall<'a> {
    boundary: &'a BoundarySamples,
    /// Smallest distance from the layer of samples [m].
    clearance: f32,
    spacing: f32,
}

impl Wall<'_> {
    fn keep_outside(&self, start: Vec3, samples: &[u32], position: &mut Vec4, velocity: &mut Vec4) {
        for _ in 0..CORRECTIONS {
            let Some((depth, normal)) = self.deepest(start, samples, position.truncate()) else {
                return;
            };
            *position += (depth * normal).extend(0.0);
            let inwards = velocity.truncate().dot(normal).min(0.0);
            *velocity -= (inwards * normal).extend(0.0);
        }
    }

    /// How far a point [m] that came from `start` is beyond the clearance of one of the `samples`, and that sample's
    /// normal.
    fn deepest(&self, start: Vec3, samples: &[u32], point: Vec3) -> Option<(f32, Vec3)> {
        let (clearance, sideways) = (self.clearance, SIDEWAYS * self.spacing);
        let mut deepest = None;
        for &sample in samples {
            // A stale list may name samples that are gone.
            let Some(&normal) = self.boundary.normals.get(sample as usize) else {
                continue;
            };
            let place = self.boundary.packed[sample as usize].truncate();
            let offset = point - place;
            let height = offset.dot(normal);
            let along = offset.length_squared() - height * height;
            let depth = clearance - height;
            if depth > deepest.map_or(0.0, |(depth, _)| depth)
                && along < sideways * sideways
                && (start - place).dot(normal) >= 0.0
            {
                deepest = Some((depth, normal));
            }
        }
        deepest
    }
}
