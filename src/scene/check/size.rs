//! How many particles a scene asks for: too many are refused before memory is taken.

use super::{Checked, axes, ensure};
use crate::mesh::Mesh;
use crate::scene::shapes::volume;
use crate::scene::{BoundaryShape, Dimension, Scene};

/// More particles than any machine this is meant for holds; a larger number is a slip in the units.
const MAX_PARTICLES: f64 = 200e6;

/// Columns, index and about 30 neighbours a particle [B]; for orientation only.
const BYTES_A_PARTICLE: f64 = 300.0;

/// What the message offers instead.
const PLENTY: f64 = 10e6;

pub(super) fn count(scene: &Scene, meshes: &[Option<Mesh>]) -> Checked {
    let dimension = axes(scene.dimension) as i32;
    let spacing = f64::from(scene.spacing);
    let fluid: f64 = (scene.bodies.iter())
        .map(|body| volume(&body.shape, scene.dimension) / spacing.powi(dimension))
        .sum();
    let solid: f64 = (scene.boundaries.iter().zip(meshes))
        .map(|(boundary, mesh)| match mesh {
            Some(mesh) => mesh.area(),
            None => surface(boundary, scene.dimension),
        })
        .map(|area| area / spacing.powi(dimension - 1))
        .sum();
    let total = fluid + solid;
    ensure(total <= MAX_PARTICLES, "spacing", || {
        let exponent = if fluid >= solid {
            dimension
        } else {
            dimension - 1
        };
        let better = spacing * (total / PLENTY).powf(1.0 / f64::from(exponent));
        format!(
            "a spacing of {} m makes about {:.0} million particles ({:.0} million of them boundary), which need about \
             {:.0} GB; a spacing of {better:.2e} m makes about {:.0} million",
            scene.spacing,
            total / 1e6,
            solid / 1e6,
            total * BYTES_A_PARTICLE / 1e9,
            PLENTY / 1e6
        )
    })
}

/// Surface of a boundary [m²; m in 2-D].
fn surface(boundary: &BoundaryShape, dimension: Dimension) -> f64 {
    use std::f64::consts::PI;
    match (boundary, dimension) {
        (BoundaryShape::Tank { min, max, .. } | BoundaryShape::Box { min, max }, _) => {
            let size = max.as_dvec3() - min.as_dvec3();
            match dimension {
                Dimension::Two => 2.0 * (size.x + size.y),
                Dimension::Three => 2.0 * (size.x * size.y + size.y * size.z + size.z * size.x),
            }
        }
        (BoundaryShape::Sphere { radius, .. }, Dimension::Two) => 2.0 * PI * f64::from(*radius),
        (BoundaryShape::Sphere { radius, .. }, Dimension::Three) => {
            4.0 * PI * f64::from(*radius).powi(2)
        }
        (BoundaryShape::Plane { half_size, .. }, _) => {
            (2.0 * f64::from(*half_size)).powi(axes(dimension) as i32 - 1)
        }
        // Its file says.
        (BoundaryShape::Mesh(_), _) => 0.0,
    }
}
