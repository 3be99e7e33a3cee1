//! Forces beside gravity, and velocities at the start that are not the same everywhere.

use std::{f32::consts::TAU, path::Path};

use glam::Vec3;

use super::problem::{Checked, Problem, ensure};
use super::proper::{AXIS_NAMES, axes, is_angle, is_flat, is_followed};
use super::size::box_of_body;
use crate::scene::{
    AccelerationTable, BodyForce, Dimension, FluidBody, ForceWave, Scene, VelocityField,
    VelocityGrid,
};

/// Part of a wave that may be missing at the seam of a period: 2π is written with four digits or more \[-].
const SEAM: f32 = 1e-3;

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
                ensure(read.greatest() > 0.0, &path, || {
                    "all accelerations in it are 0; write some in m/s², or leave the force out"
                        .to_owned()
                })?;
                ensure(flat, path, || {
                    "a 2-D scene is the plane z = 0; column `az` must be 0 or left out".to_owned()
                })?;
            }
            BodyForce::Wave(wave) => of_wave(scene, wave, &path)?,
        }
    }
    Ok(())
}

fn of_wave(scene: &Scene, wave: &ForceWave, path: &str) -> Checked {
    let (amplitude, k) = (wave.amplitude, wave.wave_number);
    is_flat(format!("{path}.amplitude"), amplitude, scene.dimension)?;
    is_flat(format!("{path}.wave_number"), k, scene.dimension)?;
    ensure(amplitude != Vec3::ZERO, format!("{path}.amplitude"), || {
        "the force is zero everywhere; write an acceleration in m/s², or leave it out".to_owned()
    })?;
    ensure(k != Vec3::ZERO || wave.frequency != 0.0, path, || {
        "the force is the same everywhere at all times; add it to `gravity`, or write a `wave_number` (rad/m) or a \
         `frequency` (1/s)"
            .to_owned()
    })?;
    is_followed(format!("{path}.frequency"), wave.frequency)?;
    is_angle(format!("{path}.phase"), wave.phase, "the phase")?;
    let (length, least) = (TAU / k.length(), 4.0 * scene.spacing);
    ensure(length >= least, format!("{path}.wave_number"), || {
        format!(
            "the wavelength, 2π over the wave number, is {length:.4} m; it must be at least {least} m, four spacings, \
             for particles to feel it"
        )
    })?;
    for (axis, name) in AXIS_NAMES.iter().enumerate() {
        let Some([low, high]) = scene.period().faces(axis) else {
            continue;
        };
        let period = high - low;
        let waves = k[axis] * period / TAU;
        let off = (waves - waves.round()).abs();
        ensure(off <= SEAM, format!("{path}.wave_number"), || {
            format!(
                "{name} is periodic, and {waves:.4} waves are no whole number in a period of {period} m; along {name} \
                 the wave number must be a multiple of {} rad/m, as {}",
                TAU / period,
                waves.round() * TAU / period
            )
        })?;
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
                is_no_zero(
                    angular_velocity != Vec3::ZERO,
                    format!("{path}.angular_velocity"),
                    "the angular velocity",
                )?;
                let about_z = angular_velocity * (Vec3::X + Vec3::Y) == Vec3::ZERO;
                let in_plane = scene.dimension == Dimension::Three || about_z;
                ensure(in_plane, format!("{path}.angular_velocity"), || {
                    "a 2-D scene is the plane z = 0 and turns about z alone; x and y must be 0"
                        .to_owned()
                })?;
            }
            Some(&VelocityField::TaylorGreen {
                speed,
                wavelength,
                origin,
            }) => {
                is_no_zero(speed != 0.0, format!("{path}.speed"), "the speed")?;
                is_flat(format!("{path}.origin"), origin, scene.dimension)?;
                let away = origin.as_dvec3().abs().max_element() / f64::from(wavelength.abs());
                let angle = (f64::from(TAU) * away) as f32;
                is_angle(format!("{path}.origin"), angle, "the way to the origin")?;
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

fn is_no_zero(moves: bool, path: String, what: &str) -> Checked {
    ensure(moves, path, || {
        format!("{what} is zero; leave `velocity_field` out for a body at rest")
    })
}

fn table(scene: &Scene, body: &FluidBody, path: &str, file: &str) -> Checked {
    let path = format!("{path}.file");
    let grid = VelocityGrid::load(Path::new(file));
    let grid = grid.map_err(|error| Problem::new(&path, error.to_string()))?;
    let is_flat = scene.dimension == Dimension::Two;
    ensure(!(is_flat && grid.leaves_the_plane()), &path, || {
        "a 2-D scene is the plane z = 0; column `vz` must be 0 or left out".to_owned()
    })?;
    is_no_zero(grid.moves(), path.clone(), "every velocity in it")?;
    let one_plane = grid.only_z();
    ensure(
        !is_flat || one_plane.is_none_or(|z| z == 0.0),
        &path,
        || "a 2-D scene is the plane z = 0; column `z` must be 0 or left out".to_owned(),
    )?;
    ensure(is_flat || one_plane.is_none(), &path, || {
        "the grid has one plane of `z`; write planes at both ends of the body, or leave `z` out for a field that does \
         not change along z"
            .to_owned()
    })?;
    // The first particles are half a spacing within the body.
    let (low, high) = box_of_body(body);
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
