//! Bodies of fluid: proper shapes, velocities and jitters.

use glam::Vec3;

use super::problem::{Checked, Problem, ensure};
use super::proper::{box_is_proper, is_flat, radius_is_proper, turns_in_plane};
use crate::scene::{Dimension, Scene, Shape};

pub(super) fn shapes(scene: &Scene) -> Checked {
    let dimension = scene.dimension;
    let has_fluid = !scene.bodies.is_empty() || !scene.emitters.is_empty();
    ensure(has_fluid, "bodies", || {
        "there is no body of fluid; add one, such as \
         `(shape: Box(min: (0, 0, 0), max: (0.5, 0.5, 0.5)))`"
            .to_owned()
    })?;
    for (index, body) in scene.bodies.iter().enumerate() {
        let path = format!("bodies.{index}.shape");
        shape(&body.shape, &path, dimension)?;
        turns_in_plane(format!("bodies.{index}.rotation"), body.rotation, dimension)?;
        is_flat(format!("bodies.{index}.velocity"), body.velocity, dimension)?;
        for (row, gradient) in body.velocity_gradient.into_iter().enumerate() {
            let path = format!("bodies.{index}.velocity_gradient");
            let across = if row == 2 {
                gradient
            } else {
                gradient * Vec3::Z
            };
            ensure(
                dimension == Dimension::Three || across == Vec3::ZERO,
                path,
                || {
                    "a 2-D scene is the plane z = 0; the third row of the gradient, and the third entry of every row, \
                     must be 0"
                    .to_owned()
                },
            )?;
        }
        let amplitude = body.jitter.map_or(0.0, |jitter| jitter.amplitude);
        ensure(
            (0.0..0.5).contains(&amplitude),
            format!("bodies.{index}.jitter.amplitude"),
            || {
                format!(
                    "the amplitude of the jitter is {amplitude} spacings; it must be from 0 to below 0.5, where \
                     particles could meet"
                )
            },
        )?;
    }
    Ok(())
}

fn shape(of: &Shape, path: &str, dimension: Dimension) -> Checked {
    match *of {
        Shape::Box { min, max } => box_is_proper(path, min, max, dimension)?,
        Shape::Sphere { center, radius } => {
            radius_is_proper(path, radius)?;
            is_flat(format!("{path}.center"), center, dimension)?;
        }
        Shape::Mesh(ref file) => {
            ensure(dimension == Dimension::Three, path, || {
                "a mesh needs `dimension: 3`; in 2-D a `Box` or a `Sphere` (a disc) can be used"
                    .to_owned()
            })?;
            scale_is_proper(path, file.scale)?;
        }
        Shape::Particles(ref file) => {
            scale_is_proper(path, file.scale)?;
            let particles = file.particles();
            let particles =
                particles.map_err(|message| Problem::new(format!("{path}.file"), message))?;
            let velocities = particles.velocities.iter().flatten();
            let flat = (particles.positions.iter())
                .chain(velocities)
                .all(|x| x.z == 0.0);
            ensure(
                dimension == Dimension::Three || flat,
                format!("{path}.file"),
                || {
                    "a 2-D scene is the plane z = 0; the particles of the file must have z = 0 and no velocity \
                 along z"
                    .to_owned()
                },
            )?;
        }
        Shape::Cylinder { start, end, radius } => {
            ensure(dimension == Dimension::Three, path, || {
                "a cylinder needs `dimension: 3`; in 2-D a `Box` or a `Sphere` (a disc) can be used"
                    .to_owned()
            })?;
            radius_is_proper(path, radius)?;
            ensure(start != end, format!("{path}.end"), || {
                "the cylinder ends where it starts; move `end`".to_owned()
            })?;
        }
    }
    Ok(())
}

fn scale_is_proper(path: &str, scale: f64) -> Checked {
    ensure(scale > 0.0, format!("{path}.scale"), || {
        format!("the scale is {scale}; it must be above 0")
    })
}
