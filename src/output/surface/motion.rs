//! Velocities of the fluid at the vertices of its surface.

use glam::{DMat3, DVec3, Vec3};
use rayon::prelude::*;
use rstar::RTree;
use rstar::primitives::GeomWithData;

/// Share of the reach below which a spread of particles counts as none: a slope over less would be made of noise.
const LEAST_SPREAD: f64 = 0.03;

/// Particles of a frame, to be searched from points of the surface.
pub(super) struct Motion {
    tree: RTree<GeomWithData<[f64; 3], DVec3>>,
    reach: f64,
}

impl Motion {
    /// The particles' motion, as points within `reach` \[m] feel it.
    pub(super) fn new(positions: &[Vec3], velocities: &[Vec3], reach: f64) -> Self {
        let particles = positions
            .iter()
            .zip(velocities)
            .map(|(position, velocity)| {
                GeomWithData::new(position.as_dvec3().to_array(), velocity.as_dvec3())
            });
        Self {
            tree: RTree::bulk_load(particles.collect()),
            reach,
        }
    }

    pub(super) fn at_all(&self, points: &[Vec3]) -> Vec<Vec3> {
        points.par_iter().map(|point| self.at(*point)).collect()
    }

    /// The velocity of a linear function that is fitted to the particles around a point. All of them are inside the
    /// fluid, on one side of the point: a mean of them would be the velocity half a spacing below the surface.
    ///
    /// Where particles have no spread along a direction (a drop of one, a thread), the function is constant along it.
    fn at(&self, point: Vec3) -> Vec3 {
        let point = point.as_dvec3();
        let around = self
            .tree
            .locate_within_distance(point.to_array(), self.reach * self.reach);
        let near: Vec<(f64, DVec3, DVec3)> = around
            .map(|particle| {
                let offset = DVec3::from_array(*particle.geom()) - point;
                let far = offset.length_squared() / (self.reach * self.reach);
                ((1.0 - far).max(0.0).powi(3), offset, particle.data)
            })
            .collect();
        let total: f64 = near.iter().map(|(weight, ..)| weight).sum();
        if total <= 0.0 {
            let nearest = self.tree.nearest_neighbor(point.to_array());
            return nearest.map_or(Vec3::ZERO, |particle| particle.data.as_vec3());
        }
        let mean = |of: fn(&(f64, DVec3, DVec3)) -> DVec3| {
            near.iter().map(|row| row.0 * of(row)).sum::<DVec3>() / total
        };
        let (centre, velocity) = (mean(|row| row.1), mean(|row| row.2));
        let least = (LEAST_SPREAD * self.reach).powi(2);
        let (mut spread, mut slope) = (DMat3::from_diagonal(DVec3::splat(least)), DMat3::ZERO);
        for (weight, offset, of_particle) in &near {
            let (x, v) = (*offset - centre, *of_particle - velocity);
            let share = weight / total;
            spread += outer(share * x, x);
            slope += outer(share * v, x);
        }
        (velocity - slope * spread.inverse() * centre).as_vec3()
    }
}

fn outer(left: DVec3, right: DVec3) -> DMat3 {
    DMat3::from_cols(left * right.x, left * right.y, left * right.z)
}
