//! Square and cubic lattices in shapes ([`Lattice`]), jitter, and the layers of emitters ([`Inlet`]).
//!
//! Everything is computed in f64 with IEEE operations only and rounded once: the same scene gives the same particles on
//! every machine.

mod inlet;
mod jitter;
mod lattice;
#[cfg(test)]
mod tests;

use glam::{DVec3, Vec3};

use super::Dimension;

pub(crate) use crate::mesh::split_mix;
pub(crate) use inlet::{Inlet, rectangle_axes};
pub(crate) use jitter::Displacement;
use lattice::frame;
pub(crate) use lattice::{Lattice, RESOLUTION, tolerance};

/// A fluid particle to be spawned.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ParticleSeed {
    /// \[m]; z is zero in 2-D.
    pub position: Vec3,
    /// \[m/s]
    pub velocity: Vec3,
}

/// Two directions along a flat wall; with the normal they form an orthonormal frame. In 2-D the first lies in the plane
/// z = 0. `normal` must not be zero.
pub fn wall_axes(normal: Vec3, dimension: Dimension) -> (Vec3, Vec3) {
    let normal = normal.as_dvec3().normalize();
    match dimension {
        Dimension::Two => (DVec3::new(-normal.y, normal.x, 0.0).as_vec3(), Vec3::Z),
        Dimension::Three => {
            let (first, second) = frame(normal);
            (first.as_vec3(), second.as_vec3())
        }
    }
}
