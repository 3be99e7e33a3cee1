//! What several checks ask of points, vectors and round or box-shaped things.

use glam::{DVec3, Vec3};

use super::problem::{Checked, ensure};
use crate::scene::Dimension;

/// Number of axes in use, x first.
pub(super) fn axes(dimension: Dimension) -> usize {
    match dimension {
        Dimension::Two => 2,
        Dimension::Three => 3,
    }
}

pub(super) const AXIS_NAMES: [&str; 3] = ["x", "y", "z"];

/// A box has an extent on every axis in use; in 2-D it holds the plane z = 0.
pub(super) fn box_is_proper(path: &str, min: Vec3, max: Vec3, dimension: Dimension) -> Checked {
    for axis in 0..axes(dimension) {
        ensure(min[axis] < max[axis], format!("{path}.max"), || {
            let name = AXIS_NAMES[axis];
            format!(
                "the box ends at {name} = {} m and starts at {name} = {} m; `max` must be above `min`",
                max[axis], min[axis]
            )
        })?;
    }
    let in_plane = dimension == Dimension::Three || (min.z <= 0.0 && max.z >= 0.0);
    ensure(in_plane, format!("{path}.min"), || {
        format!(
            "z from {} to {} m misses the plane z = 0 of a 2-D scene; write 0 for both",
            min.z, max.z
        )
    })
}

pub(super) fn radius_is_proper(path: &str, radius: f32) -> Checked {
    ensure(radius > 0.0, format!("{path}.radius"), || {
        format!("the radius is {radius} m; it must be above 0")
    })
}

/// In 2-D a point or a vector lies in the plane z = 0.
pub(super) fn is_flat(path: impl Into<String>, value: Vec3, dimension: Dimension) -> Checked {
    let flat = dimension == Dimension::Three || value.z == 0.0;
    ensure(flat, path, || {
        format!(
            "z is {} in a 2-D scene, which is the plane z = 0; write 0",
            value.z
        )
    })
}

/// In 2-D a shape turns about z alone.
pub(super) fn turns_in_plane(path: String, rotation: DVec3, dimension: Dimension) -> Checked {
    let flat = rotation.x == 0.0 && rotation.y == 0.0;
    ensure(dimension == Dimension::Three || flat, path, || {
        format!(
            "the angles are {}° about x and {}° about y in a 2-D scene, which turns about z alone; write 0 for both",
            rotation.x, rotation.y
        )
    })
}
