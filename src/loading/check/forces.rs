//! Forces beside gravity, and velocities at the start that are not the same everywhere.

use std::path::Path;

use glam::Vec3;

use super::problem::{Checked, Problem, ensure};
use super::proper::{AXIS_NAMES, axes, is_flat};
use super::size::box_of_body;
use crate::scene::{
    AccelerationTable, BodyForce, Dimension, FluidBody, Scene, VelocityField, VelocityGrid,
};

pub(super) fn body_forces(scene: &Scene) -> Checked {
    for (index, force) in scene.body_forces.iter().enumerate() {
        let path = format!("body_forces.{index}");
        match force {
            BodyForce::Central(central) => {
                is_flat(format!("{path}.center"), central.center, scene.dimension)?;
                let acts = central.linear != 0.0 || central.constant != 0.0;
                ensure(acts, path, || {
                    "the force is zero everywhere; set `linear` (1/s²) or `constant` (m/s²), or leave it out".to_owned()
                })?;
            }
            BodyForce::Table(table) => {
                let path = format!("{path}.file");
                let read = AccelerationTable::load(Path::new(&table.file));
                let read = read.map_err(|error| Problem::new(&path, error.to_string()))?;
                let flat = scene.dimension == Dimension::Three || !read.leaves_the_plane();
                ensure(flat, path, || {
                    "a 2-D scene is the plane z = 0; column `az` must be 0 or left out".to_owned()
                })?;
            }
        }
    }
    Ok(())
}

pub(super) fn velocity_fields(scene: &Scene) -> Checked {
    for (index, body) in scene.bodies.iter().enumerate() {
        let path = format!("bodies.{index}.velocity_field");
        match body.velocity_field.as_ref() {
            None => {}
            Some(VelocityField::Table { file }) => table(scene, body, &path, file)?,
            Some(&VelocityField::Rotation {
                center,
                angular_velocity,
            }) => {
                is_flat(format!("{path}.center"), center, scene.dimension)?;
                let about_z = angular_velocity * (Vec3::X + Vec3::Y) == Vec3::ZERO;
                let in_plane = scene.dimension == Dimension::Three || about_z;
                ensure(in_plane, format!("{path}.angular_velocity"), || {
                    "a 2-D scene is the plane z = 0 and turns about z alone; x and y must be 0"
                        .to_owned()
                })?;
            }
            Some(&VelocityField::TaylorGreen {
                wavelength, origin, ..
            }) => {
                is_flat(format!("{path}.origin"), origin, scene.dimension)?;
                let least = 4.0 * scene.spacing;
                ensure(wavelength >= least, format!("{path}.wavelength"), || {
                    format!(
                        "the wavelength is {wavelength} m; it must be at least {least} m, four spacings, for particles \
                         to carry it"
                    )
                })?;
            }
        }
    }
    Ok(())
}

fn table(scene: &Scene, body: &FluidBody, path: &str, file: &str) -> Checked {
    let path = format!("{path}.file");
    let grid = VelocityGrid::load(Path::new(file));
    let grid = grid.map_err(|error| Problem::new(&path, error.to_string()))?;
    let flat = scene.dimension == Dimension::Three || !grid.leaves_the_plane();
    ensure(flat, &path, || {
        "a 2-D scene is the plane z = 0; column `vz` must be 0 or left out".to_owned()
    })?;
    // The first particles are half a spacing within the body.
    let (low, high) = box_of_body(&body.shape);
    let half = 0.5 * f64::from(scene.spacing) * (1.0 + 1e-3);
    let (low, high) = (low + half, high - half);
    let [first, last] = grid.corners();
    for (axis, name) in AXIS_NAMES.iter().enumerate().take(axes(scene.dimension)) {
        let covered = first[axis] <= low[axis].min(high[axis]) && last[axis] >= high[axis];
        ensure(covered, &path, || {
            format!(
                "the table reaches from {name} = {} to {} m, the particles of the body from {:.6} to {:.6} m; it must \
                 cover them",
                first[axis], last[axis], low[axis], high[axis]
            )
        })?;
    }
    Ok(())
}
