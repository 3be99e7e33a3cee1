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

/// Angles of a shape are some of the circle; in 2-D it turns about z alone.
pub(super) fn turns_in_plane(path: String, rotation: DVec3, dimension: Dimension) -> Checked {
    let most = rotation.abs().max_element();
    ensure(most <= MOST_DEGREES, &path, || {
        format!("the angles are up to {most:e}°; they repeat every 360°: write them from 0 to 360")
    })?;
    let flat = rotation.x == 0.0 && rotation.y == 0.0;
    ensure(dimension == Dimension::Three || flat, path, || {
        format!(
            "the angles are {}° about x and {}° about y in a 2-D scene, which turns about z alone; write 0 for both",
            rotation.x, rotation.y
        )
    })
}

/// Largest angle of a shape \[degrees].
const MOST_DEGREES: f64 = 1e6;

/// Largest angle: 160 turns, which single precision knows to 6e-5 \[rad].
const MOST_TURNS: f32 = 1e3;

/// An angle is one of the circle: of a larger number its digits say nothing.
pub(super) fn is_angle(path: String, angle: f32, what: &str) -> Checked {
    ensure(angle.abs() <= MOST_TURNS, path, || {
        let apart = angle.abs().next_up() - angle.abs();
        format!(
            "{what} is {angle:e} rad, where numbers in single precision are {apart:.1e} rad apart; it repeats every \
             2π: write it from 0 to 6.2832, and at most {MOST_TURNS:e}"
        )
    })
}

/// Largest frequency, which steps of 1e-9 s follow \[1/s].
const MOST_FREQUENT: f32 = 5e7;

/// A frequency that steps can follow.
pub(super) fn is_followed(path: String, frequency: f32) -> Checked {
    ensure(frequency.abs() <= MOST_FREQUENT, path, || {
        format!(
            "the frequency is {frequency:e} Hz, and a step may be a twentieth of the period: it must be at most \
             {MOST_FREQUENT:e}, for steps of 1e-9 s"
        )
    })
}
