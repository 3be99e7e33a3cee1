//! Motions of boundaries.

use std::path::Path;

use glam::{DVec3, Vec3};

use super::carried;
use super::problem::{Checked, Problem, ensure};
use super::proper::{axes, is_angle, is_flat, is_followed};
use super::size::box_of_boundary;
use crate::mesh::Mesh;
use crate::scene::{
    BoundaryShape, Bounds, Dimension, MotionTable, Scene, TimeStep, Viscosity, WallCourse,
    WallMotion, WallSlip,
};

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
            phase,
        } => {
            is_followed(field("frequency"), frequency)?;
            is_angle(field("phase"), phase, "the phase")?;
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
            ensure(table.moves(), field("file"), || {
                "its `x` is the same in every row; write where the wall is at two times at least, or leave `motion` \
                 out for a wall that stands"
                    .to_owned()
            })
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

/// Walls that hold the fluid do so by its viscosity.
pub(super) fn slip(scene: &Scene) -> Checked {
    for (index, wall) in scene.boundaries.iter().enumerate() {
        let path = format!("boundaries.{index}.slip");
        if let WallSlip::Partial { length } = wall.slip() {
            ensure(length > 0.0, format!("{path}.length"), || {
                format!("the slip length is {length} m; it must be above 0, or write `NoSlip`")
            })?;
        }
        let laminar = matches!(
            scene.fluid.viscosity,
            Viscosity::Laminar { kinematic_viscosity, .. } if kinematic_viscosity > 0.0
        );
        ensure(wall.slip() == WallSlip::Free || laminar, path, || {
            "a wall holds the fluid by its laminar viscosity, and this fluid has none; write \
             `viscosity: Laminar(kinematic_viscosity: …)`, or leave `slip` out"
                .to_owned()
        })?;
    }
    Ok(())
}

/// Times at which a wall is looked at, evenly over the run.
const LOOKS: u32 = 100;

/// Where walls get to in the run, and whether steps can follow them.
pub(super) fn courses(scene: &Scene, meshes: &[Option<Mesh>]) -> Checked {
    for (index, (wall, mesh)) in scene.boundaries.iter().zip(meshes).enumerate() {
        let Some(motion) = wall.motion() else {
            continue;
        };
        let path = format!("boundaries.{index}.motion");
        let corners = mesh.as_ref().map(Mesh::bounds);
        followed(scene, wall, corners)?;
        let course = WallCourse::new(motion);
        let course = course.map_err(|error| Problem::new(&path, error.to_string()))?;
        let (low, high) = corners.unwrap_or_else(|| box_of_boundary(wall, scene.dimension, 0.0));
        let round = scene.period().axes();
        let around = |time: f64| {
            let pose = course.pose(time);
            let corners = (0..8).map(|k| {
                let end = |last: bool, axis: usize| [low[axis], high[axis]][usize::from(last)];
                let corner = DVec3::new(end(k & 1 > 0, 0), end(k & 2 > 0, 1), end(k & 4 > 0, 2));
                pose.place(corner.as_vec3())
            });
            let empty = [DVec3::INFINITY, DVec3::NEG_INFINITY];
            let [min, max] = corners.fold(empty, |[min, max], x| [min.min(x), max.max(x)]);
            // Along a periodic axis it comes back.
            [
                DVec3::select(round, low, min),
                DVec3::select(round, high, max),
            ]
        };
        for time in looks(motion, scene.duration.into()) {
            let corners = around(time);
            carried::of_one(scene, path.clone(), corners).map_err(|problem| Problem {
                message: format!(
                    "at {time:.4} s {}; or the motion must end before",
                    problem.message
                ),
                ..problem
            })?;
            if let Some(domain) = scene.domain {
                stays(scene, wall, &path, (domain, time), [around(0.0), corners])?;
            }
        }
    }
    Ok(())
}

/// The times at which a wall may be farthest, and others between.
fn looks(motion: &WallMotion, duration: f64) -> Vec<f64> {
    let mut times: Vec<f64> = (0..=LOOKS)
        .map(|k| duration * f64::from(k) / f64::from(LOOKS))
        .collect();
    match *motion {
        WallMotion::Velocity { end, .. } | WallMotion::Rotation { end, .. } => {
            times.extend(end.map(f64::from));
        }
        WallMotion::Oscillation {
            frequency, phase, ..
        } => {
            // Where the sine is ±1: four times hold both ends.
            let period = 1.0 / f64::from(frequency);
            let first = 0.25 - f64::from(phase) / std::f64::consts::TAU;
            let parts = (0..4).map(|k| (first + 0.5 * f64::from(k)).rem_euclid(2.0));
            times.extend(parts.map(|part| part * period));
        }
        WallMotion::Table { ref file, .. } => {
            let table = MotionTable::load(Path::new(file)).unwrap_or_default();
            times.extend(table.times());
        }
    }
    times.retain(|time| (0.0..=duration).contains(time));
    times
}

/// A wall that stands in the domain stays in it; a tank does with all that it holds.
fn stays(
    scene: &Scene,
    wall: &BoundaryShape,
    path: &str,
    (Bounds { min, max }, time): (Bounds, f64),
    [at_start, now]: [[DVec3; 2]; 2],
) -> Checked {
    let (min, max) = (min.as_dvec3(), max.as_dvec3());
    let rounding = 1e-3 * f64::from(scene.spacing);
    let mut all = 0..axes(scene.dimension);
    let holds = matches!(wall, BoundaryShape::Tank { .. });
    let fits = |[low, high]: [DVec3; 2], axis: usize| {
        if holds {
            low[axis] >= min[axis] - rounding && high[axis] <= max[axis] + rounding
        } else {
            low[axis] <= max[axis] && high[axis] >= min[axis]
        }
    };
    if !all.clone().all(|axis| fits(at_start, axis)) {
        return Ok(());
    }
    ensure(all.all(|axis| fits(now, axis)), path, || {
        let (low, high) = (now[0].as_vec3(), now[1].as_vec3());
        let what = if holds {
            "the tank carries its fluid out of"
        } else {
            "the wall has left"
        };
        format!(
            "at {time:.4} s {what} `domain`: it is from {low} to {high} m then; stop it before, turn it round, or \
             enlarge `domain`"
        )
    })
}

/// A wall may not move more than half the support radius in a step that is fixed.
fn followed(scene: &Scene, wall: &BoundaryShape, mesh: Option<(DVec3, DVec3)>) -> Checked {
    let TimeStep::Fixed(dt) = scene.time_step else {
        return Ok(());
    };
    let corners = mesh.map(|(low, high)| [low.as_vec3(), high.as_vec3()]);
    let in_plane = scene.dimension == Dimension::Two;
    let speed = wall.greatest_speed(in_plane, corners).unwrap_or_default();
    let limit = 0.5 * scene.support_radius();
    ensure(speed * dt <= limit, "time_step", || {
        format!(
            "a wall moves with up to {speed:.3} m/s, {:.3e} m in a step of {dt:e} s; it may move half the support \
             radius, {limit:.3e} m: `Fixed({:.0e})` would do, or `Cfl()`",
            speed * dt,
            0.8 * limit / speed
        )
    })
}
