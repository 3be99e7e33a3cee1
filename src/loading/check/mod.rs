//! What a scene must fulfil before it runs. The first problem is reported: a later one is often its consequence.

mod bodies;
mod carried;
mod gauges;
mod numbers;
mod size;
mod solids;
mod stability;

use glam::Vec3;

pub(crate) use size::Size;

use crate::scene::{Dimension, Scene};

/// What is wrong with a field, and what would be right.
#[derive(Debug, Clone, PartialEq)]
pub(in crate::loading) struct Problem {
    /// Path of the field, as `--set` takes it.
    pub(in crate::loading) path: String,
    pub(in crate::loading) message: String,
}

impl Problem {
    pub(in crate::loading) fn new(path: impl Into<String>, message: impl Into<String>) -> Self {
        Self {
            path: path.into(),
            message: message.into(),
        }
    }
}

type Checked = Result<(), Problem>;

/// From the single numbers to what they make together; each check relies on those before it. Says what room the scene
/// needs.
pub(in crate::loading) fn check(scene: &Scene) -> Result<Size, Problem> {
    numbers::finite(scene)?;
    numbers::numbers(scene)?;
    carried::mass(scene)?;
    stability::least_time_step(scene)?;
    bodies::shapes(scene)?;
    solids::shapes(scene)?;
    gauges::gauges(scene)?;
    let meshes = solids::meshes(scene)?;
    let size = size::count(scene, &meshes)?;
    carried::coordinates(scene, &meshes)?;
    bodies::places(scene, &meshes)?;
    Ok(size)
}

fn ensure(right: bool, path: impl Into<String>, message: impl FnOnce() -> String) -> Checked {
    if right {
        Ok(())
    } else {
        Err(Problem::new(path, message()))
    }
}

/// Number of axes in use, x first.
fn axes(dimension: Dimension) -> usize {
    match dimension {
        Dimension::Two => 2,
        Dimension::Three => 3,
    }
}

const AXIS_NAMES: [&str; 3] = ["x", "y", "z"];

/// A box has an extent on every axis in use; in 2-D it holds the plane z = 0.
fn box_is_proper(path: &str, min: Vec3, max: Vec3, dimension: Dimension) -> Checked {
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

fn radius_is_proper(path: &str, radius: f32) -> Checked {
    ensure(radius > 0.0, format!("{path}.radius"), || {
        format!("the radius is {radius} m; it must be above 0")
    })
}

/// In 2-D a point or a vector lies in the plane z = 0.
fn is_flat(path: impl Into<String>, value: Vec3, dimension: Dimension) -> Checked {
    let flat = dimension == Dimension::Three || value.z == 0.0;
    ensure(flat, path, || {
        format!(
            "z is {} in a 2-D scene, which is the plane z = 0; write 0",
            value.z
        )
    })
}
