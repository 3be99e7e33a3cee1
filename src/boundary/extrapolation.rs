//! Pressure of walls of several layers: that of the particle, continued hydrostatically (Adami, Hu & Adams 2012, eq.
//! 27, for each particle alone).
//!
//! A sample b has `p_b = p_i + ρ0 a·(x_b − x_i)` for a particle i, a the acceleration by gravity and body forces. The
//! part with p_i is twice the sum over the walls that every pressure force has ([`sums`](super::sums)); the other one
//! does not depend on the pressure and is an acceleration like that of gravity: `Σ_b V_b (a·x_ib) ∇W_ib`. A wall above
//! a particle without a pressure does not pull. Walls in motion are taken to move uniformly.

use bevy_ecs::prelude::*;
use glam::Vec3;

use crate::{
    boundary::sums::{BoundarySums, Walls},
    index::BoundarySamples,
    kernel::Kernel,
    pairs::Pairs,
    scene::BoundaryHandling,
    state::{Accelerations, Material, Phase, Pressures, Product, Stage},
};

/// Hydrostatic part of the pressure of walls.
pub(crate) const STAGE: Stage = Stage {
    needs: &[
        Product::Columns,
        Product::Index,
        Product::Walls,
        Product::Neighbours,
        Product::Forces,
    ],
    wanted: |scene| {
        scene.boundary_handling() == BoundaryHandling::Layers && !scene.boundaries.is_empty()
    },
    ..Stage::new("wall_pressure", Phase::Forces, |_| {
        push_hydrostatically.into_configs()
    })
};

/// What walls of several layers continue, by row. In scenes that measure forces on walls.
#[derive(Resource, Debug, Default)]
pub(crate) struct Continued {
    /// Accelerations by gravity and body forces \[m/s²].
    forces: Vec<Vec3>,
    /// Unit vectors into the wall of rows that it does not pull; zero of others.
    unpulled: Vec<Vec3>,
}

impl Continued {
    /// What a sample with a volume at `−x` from a row adds to its acceleration \[m/s²].
    #[inline]
    pub(crate) fn by_sample(&self, row: usize, (x, volume): (Vec3, f32), kernel: &Kernel) -> Vec3 {
        let force = self.forces.get(row).copied().unwrap_or_default();
        let inwards = self.unpulled.get(row).copied().unwrap_or_default();
        let push = of_sample(force, (x, volume), kernel);
        push - push.dot(inwards) * inwards
    }
}

#[inline]
fn of_sample(force: Vec3, (x, volume): (Vec3, f32), kernel: &Kernel) -> Vec3 {
    volume * force.dot(x) * kernel.gradient(x)
}

/// Adds the push of walls that continue gravity and body forces (phase `Forces`, after these).
fn push_hydrostatically(
    mut accelerations: ResMut<Accelerations>,
    continued: Option<ResMut<Continued>>,
    boundary: Res<BoundarySamples>,
    (walls, pressures): (Option<Res<BoundarySums>>, Res<Pressures>),
    material: Res<Material>,
    pairs: Pairs,
) {
    let walls = Walls::of(walls.as_deref());
    let reach = 0.5 * material.rest_density * material.kernel.support_radius;
    let positions = &pairs.positions().0;
    let push = |row: usize, samples: &[u32], acceleration: &mut Vec3| -> Vec3 {
        let (own, force) = (positions[row].truncate(), *acceleration);
        let mut sum = Vec3::ZERO;
        for &sample in samples {
            // A stale list may name samples that are gone: the sentinel has no volume.
            let Some(place) = boundary.packed.get(sample as usize) else {
                continue;
            };
            let x = material.period.nearest(own - place.truncate());
            sum += of_sample(force, (x, place.w), &material.kernel);
        }
        let inwards = walls.gradient(row).normalize_or_zero();
        let pull = sum.dot(inwards);
        let is_unpulled = pull > 0.0 && pressures.0[row] < reach * force.length();
        let unpulled = if is_unpulled { inwards } else { Vec3::ZERO };
        *acceleration += sum - pull * unpulled;
        unpulled
    };
    let rows = pairs.positions().rows();
    let accelerations = &mut accelerations.0[..rows];
    let Some(mut continued) = continued else {
        let columns = (accelerations, &mut vec![(); rows][..]);
        return pairs.update_near_boundary(columns, |row, samples, acceleration, ()| {
            push(row, samples, acceleration);
        });
    };
    let Continued { forces, unpulled } = &mut *continued;
    forces.clear();
    forces.extend_from_slice(accelerations);
    unpulled.clear();
    unpulled.resize(rows, Vec3::ZERO);
    let columns = (accelerations, &mut unpulled[..]);
    pairs.update_near_boundary(columns, |row, samples, acceleration, unpulled| {
        *unpulled = push(row, samples, acceleration);
    });
}
