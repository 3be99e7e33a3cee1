//! Fills the bodies of a scene with particles on a square or cubic lattice ([`Lattice`]), with an optional jitter.
//!
//! Everything is computed in f64 with IEEE operations only and rounded once: the same scene gives the same particles on
//! every machine.

mod inlet;
mod jitter;
mod lattice;
#[cfg(test)]
mod tests;

use glam::{DVec2, DVec3, Vec3};

use super::{Dimension, FluidBody, Scene, Shape};
use jitter::Displacement;

pub(crate) use inlet::{Inlet, rectangle_axes};
pub(crate) use jitter::split_mix;
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

/// The particles of all bodies of a scene that [`Scene::check`] accepts: body after body, within a body along x
/// first, then y, then z (along a cylinder's axis last).
pub fn fluid_particles(scene: &Scene) -> Vec<ParticleSeed> {
    let mut seeds = Vec::new();
    for_each_particle(scene, |seed| seeds.push(seed));
    seeds
}

/// Calls `visit` with each particle that [`fluid_particles`] would return, without storing them.
pub(crate) fn for_each_particle(scene: &Scene, mut visit: impl FnMut(ParticleSeed)) {
    for body in &scene.bodies {
        for_each_particle_of(body, scene, &mut visit);
    }
}

/// The same for one of its bodies.
pub(crate) fn for_each_particle_of(
    body: &FluidBody,
    scene: &Scene,
    mut visit: impl FnMut(ParticleSeed),
) {
    let spacing = f64::from(scene.spacing);
    let velocity_at = body.velocities();
    let period = scene.period();
    let mut displace = Displacement::new(body.jitter, spacing, scene.dimension);
    Lattice::new(&body.shape, spacing, scene.dimension).for_each(|point| {
        let position = point + displace.next();
        visit(ParticleSeed {
            position: period.wrap_exactly(position).as_vec3(),
            velocity: velocity_at(position).as_vec3(),
        });
    });
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

/// Volume of a shape \[m³; m² in 2-D].
pub(crate) fn volume(shape: &Shape, dimension: Dimension) -> f64 {
    use std::f64::consts::PI;
    match (*shape, dimension) {
        (Shape::Box { min, max }, _) => {
            let size = max.as_dvec3() - min.as_dvec3();
            match dimension {
                Dimension::Two => DVec2::new(size.x, size.y).element_product(),
                Dimension::Three => size.element_product(),
            }
        }
        (Shape::Sphere { radius, .. }, Dimension::Two) => PI * f64::from(radius).powi(2),
        (Shape::Sphere { radius, .. }, Dimension::Three) => {
            4.0 / 3.0 * PI * f64::from(radius).powi(3)
        }
        (Shape::Cylinder { start, end, radius }, _) => {
            PI * f64::from(radius).powi(2) * (end.as_dvec3() - start.as_dvec3()).length()
        }
    }
}
