//! Whether single precision carries a scene: its coordinates, its masses, and its kernel.

use glam::DVec3;

use super::problem::{Checked, Problem, ensure};
use super::proper::{AXIS_NAMES, axes};
use super::size::{box_of_body, box_of_boundary};
use crate::kernel::Kernel;
use crate::mesh::Mesh;
use crate::scene::shapes::RESOLUTION;
use crate::scene::{Dimension, Scene};

/// Range of masses, volumes and factors of the kernel: their products with each other stay normal numbers.
const LARGEST: f32 = 1e35;
const SMALLEST: f32 = 1e-35;

/// Coordinates must say where a particle is to a part of its spacing: motion that is finer is lost.
pub(super) fn coordinates(scene: &Scene, meshes: &[Option<Mesh>]) -> Checked {
    let bodies = scene.bodies.iter().enumerate().map(|(index, body)| {
        let (low, high) = box_of_body(body);
        (format!("bodies.{index}.shape"), [low, high])
    });
    let solids = scene.boundaries.iter().zip(meshes).enumerate();
    let solids = solids.map(|(index, (boundary, mesh))| {
        let corners = match (boundary, mesh) {
            (_, Some(mesh)) => {
                let (min, max) = mesh.bounds();
                [min, max]
            }
            (_, None) => {
                let (min, max) = box_of_boundary(boundary, scene.dimension, 0.0);
                [min, max]
            }
        };
        (format!("boundaries.{index}"), corners)
    });
    // What leaves at one face comes in at the other.
    let faces = scene.periodic.axes().map(|faces| faces.unwrap_or_default());
    let faces = [0, 1].map(|end| DVec3::from(faces.map(|faces| f64::from(faces[end]))));
    bodies
        .chain(solids)
        .chain([("periodic".to_owned(), faces)])
        .try_for_each(|(path, corners)| of_one(scene, path, corners))
}

pub(super) fn of_one(scene: &Scene, path: String, corners: [DVec3; 2]) -> Result<(), Problem> {
    let spacing = f64::from(scene.spacing);
    let largest = RESOLUTION * spacing / f64::from(f32::EPSILON);
    for axis in 0..axes(scene.dimension) {
        let at = corners
            .map(|corner| corner[axis])
            .into_iter()
            .fold(0.0, |a: f64, b| if b.abs() > a.abs() { b } else { a });
        ensure(at.abs() <= largest, path.clone(), || {
            format!(
                "it reaches {} = {at:.6e} m, where coordinates in single precision are {:.2e} m apart, more than \
                 1/100 of the spacing of {} m; move the scene to the origin, within {largest:.2e} m of it, or enlarge \
                 the spacing",
                AXIS_NAMES[axis],
                at.abs() * f64::from(f32::EPSILON),
                scene.spacing,
            )
        })?;
    }
    Ok(())
}

/// The mass of a particle and the slope of its kernel are normal numbers, and so are their squares.
pub(super) fn mass(scene: &Scene) -> Checked {
    let kernel = Kernel::of(scene);
    let dimension = match scene.dimension {
        Dimension::Two => 2,
        Dimension::Three => 3,
    };
    let volume = scene.spacing.powi(dimension);
    let mass = scene.fluid.rest_density * volume;
    let is_usable = |x: f32| (SMALLEST..=LARGEST).contains(&x);
    ensure(
        is_usable(volume) && is_usable(kernel.gradient_scale),
        "spacing",
        || {
            format!(
                "a spacing of {:e} m makes particles of {volume:e} m{}, beyond what single precision carries; lengths \
                 are in metres",
                scene.spacing,
                if dimension == 2 { "²" } else { "³" }
            )
        },
    )?;
    // Pressures are divided by its square.
    let density = scene.fluid.rest_density;
    let density_is_usable = is_usable(density * density);
    ensure(
        is_usable(mass) && density_is_usable,
        "fluid.rest_density",
        || {
            format!(
                "a rest density of {:e} kg/m³ makes particles of {mass:e} kg, which is beyond single precision; water \
                 has 1000",
                scene.fluid.rest_density
            )
        },
    )
}
