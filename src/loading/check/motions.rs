//! Motions of boundaries.

use std::path::Path;

use glam::Vec3;

use super::problem::{Checked, Problem, ensure};
use super::proper::is_flat;
use crate::scene::{Dimension, MotionTable, Scene, WallMotion};

pub(super) fn motions(scene: &Scene) -> Checked {
    for (index, wall) in scene.boundaries.iter().enumerate() {
        if let Some(motion) = wall.motion() {
            of_one(scene, motion, &format!("boundaries.{index}.motion"))?;
        }
    }
    Ok(())
}

fn of_one(scene: &Scene, motion: &WallMotion, path: &str) -> Checked {
    let dimension = scene.dimension;
    let field = |name: &str| format!("{path}.{name}");
    match *motion {
        WallMotion::Velocity {
            velocity,
            start,
            end,
        } => {
            is_flat(field("velocity"), velocity, dimension)?;
            is_no_zero(field("velocity"), velocity, "the velocity")?;
            times(path, start, end)
        }
        WallMotion::Rotation {
            center,
            angular_velocity,
            start,
            end,
        } => {
            is_flat(field("center"), center, dimension)?;
            let about_z = angular_velocity.x == 0.0 && angular_velocity.y == 0.0;
            let in_plane = dimension == Dimension::Three || about_z;
            ensure(in_plane, field("angular_velocity"), || {
                "a 2-D scene is the plane z = 0 and turns about z alone; x and y must be 0"
                    .to_owned()
            })?;
            is_no_zero(
                field("angular_velocity"),
                angular_velocity,
                "the angular velocity",
            )?;
            times(path, start, end)
        }
        WallMotion::Oscillation {
            amplitude,
            frequency,
            ..
        } => {
            is_flat(field("amplitude"), amplitude, dimension)?;
            is_no_zero(field("amplitude"), amplitude, "the amplitude")?;
            ensure(frequency > 0.0, field("frequency"), || {
                format!("the frequency is {frequency} Hz; it must be above 0")
            })
        }
        WallMotion::Table {
            ref file,
            direction,
        } => {
            is_flat(field("direction"), direction, dimension)?;
            is_no_zero(field("direction"), direction, "the direction")?;
            let table = MotionTable::load(Path::new(file));
            let table = table.map_err(|error| Problem::new(field("file"), error.to_string()))?;
            match table.time_given_twice() {
                None => Ok(()),
                Some(time) => Err(Problem::new(
                    field("file"),
                    format!(
                        "{file}: the time {time} s is given twice; a wall is in one place at a time"
                    ),
                )),
            }
        }
    }
}

fn is_no_zero(path: String, value: Vec3, what: &str) -> Checked {
    ensure(value != Vec3::ZERO, path, || {
        format!("{what} is zero; leave `motion` out for a wall that stands")
    })
}

fn times(path: &str, start: f32, end: Option<f32>) -> Checked {
    ensure(start >= 0.0, format!("{path}.start"), || {
        format!("the wall sets off at {start} s; it must not be before 0")
    })?;
    let Some(end) = end else {
        return Ok(());
    };
    ensure(end > start, format!("{path}.end"), || {
        format!("the wall stops at {end} s and sets off at {start} s; `end` must be above `start`")
    })
}
