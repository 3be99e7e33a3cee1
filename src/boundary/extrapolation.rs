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
    install: |world, _| {
        world.init_resource::<Continued>();
    },
    bytes: |_, _| vec![("accelerations that walls continue", 12.0)],
    ..Stage::new("wall_pressure", Phase::Forces, |_| {
        push_hydrostatically.into_configs()
    })
};

/// Accelerations by gravity and body forces of all rows \[m/s²]. In scenes with walls of several layers.
#[derive(Resource, Debug, Default)]
pub(crate) struct Continued(Vec<Vec3>);

impl Continued {
    /// What a sample with a volume at `−x` from a row adds to its acceleration \[m/s²].
    #[inline]
    pub(crate) fn by_sample(&self, row: usize, (x, volume): (Vec3, f32), kernel: &Kernel) -> Vec3 {
        let acceleration = self.0.get(row).copied().unwrap_or_default();
        volume * acceleration.dot(x) * kernel.gradient(x)
    }
}

/// Adds the push of walls that continue gravity and body forces (phase `Forces`, after these).
fn push_hydrostatically(
    mut accelerations: ResMut<Accelerations>,
    mut continued: ResMut<Continued>,
    boundary: Res<BoundarySamples>,
    (walls, pressures): (Option<Res<BoundarySums>>, Res<Pressures>),
    material: Res<Material>,
    pairs: Pairs,
) {
    let walls = Walls::of(walls.as_deref());
    let reach = 0.5 * material.rest_density * material.kernel.support_radius;
    let rows = pairs.positions().rows();
    let positions = &pairs.positions().0;
    continued.0.clear();
    continued.0.extend_from_slice(&accelerations.0[..rows]);
    let continued = &*continued;
    let columns = (&mut accelerations.0[..rows], &mut vec![(); rows][..]);
    pairs.update_near_boundary(columns, |row, samples, acceleration: &mut Vec3, ()| {
        let own = positions[row].truncate();
        let mut sum = Vec3::ZERO;
        for &sample in samples {
            // A stale list may name samples that are gone: the sentinel has no volume.
            let Some(place) = boundary.packed.get(sample as usize) else {
                continue;
            };
            let x = material.period.nearest(own - place.truncate());
            sum += continued.by_sample(row, (x, place.w), &material.kernel);
        }
        let inwards = walls.gradient(row).normalize_or_zero();
        let pull = sum.dot(inwards).max(0.0);
        if pressures.0[row] < reach * acceleration.length() {
            sum -= pull * inwards;
        }
        *acceleration += sum;
    });
}
