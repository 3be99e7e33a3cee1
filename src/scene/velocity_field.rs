//! Velocities of a body at the start that are not the same everywhere.

use std::{f64::consts::TAU, path::Path};

use glam::{DVec3, Vec3};
use serde::{Deserialize, Serialize};

use super::VelocityGrid;
use crate::measure::CurveError;

/// A field of velocities at the start.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub enum VelocityField {
    /// Rotation as a rigid body, `ω × (x − center)`.
    Rotation {
        /// A point of the axis \[m].
        #[cfg_attr(feature = "schema", schemars(with = "[f32; 3]"))]
        center: Vec3,
        /// ω, along the axis \[rad/s]; in 2-D along z.
        #[cfg_attr(feature = "schema", schemars(with = "[f32; 3]"))]
        angular_velocity: Vec3,
    },
    /// Taylor–Green vortices: with `k = 2π/wavelength` and ξ the place from `origin`,
    /// `speed (sin kξ_x cos kξ_y cos kξ_z, −cos kξ_x sin kξ_y cos kξ_z, 0)`. Nothing flows through the planes in which
    /// kξ_x or kξ_y is a multiple of π, so that slip walls may stand there. In 2-D ξ_z is 0, and the decay
    /// `exp(−2 ν k² t)` is exact.
    TaylorGreen {
        /// Largest speed \[m/s].
        speed: f32,
        /// Two vortices side by side \[m].
        wavelength: f32,
        /// Corner of a vortex \[m].
        #[serde(default)]
        #[cfg_attr(feature = "schema", schemars(with = "[f32; 3]"))]
        origin: Vec3,
    },
    /// Velocities at the points of a grid, linear in between.
    Table {
        /// A CSV file, relative to the scene file's folder (after [`load`](super::Scene::load): to the working
        /// directory): a line of names, the columns `x`, `y` \[m], `vx`, `vy` \[m/s] and, if the field has them, `z`
        /// and `vz`; a row for every point of a grid, whose planes need not be evenly apart. The body must lie in it.
        file: String,
    },
}

/// A field with its file read.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum ReadField {
    Formula(VelocityField),
    Grid(VelocityGrid),
}

impl ReadField {
    /// Velocity at a point \[m/s].
    pub(crate) fn at(&self, point: DVec3) -> DVec3 {
        match self {
            Self::Formula(field) => field.at(point),
            Self::Grid(grid) => grid.at(point),
        }
    }
}

impl VelocityField {
    /// Reads the file of the field, if it has one.
    pub(crate) fn read(&self) -> Result<ReadField, CurveError> {
        Ok(match self {
            Self::Table { file } => ReadField::Grid(VelocityGrid::load(Path::new(file))?),
            _ => ReadField::Formula(self.clone()),
        })
    }

    /// Velocity at a point \[m/s]. A file is read anew for every point, and counts for nothing if it cannot be.
    pub fn at(&self, point: DVec3) -> DVec3 {
        match *self {
            Self::Rotation {
                center,
                angular_velocity,
            } => angular_velocity.as_dvec3().cross(point - center.as_dvec3()),
            Self::TaylorGreen {
                speed,
                wavelength,
                origin,
            } => {
                let phase = TAU / f64::from(wavelength) * (point - origin.as_dvec3());
                let (sin, cos) = (phase.map(f64::sin), phase.map(f64::cos));
                let across = f64::from(speed) * cos.z;
                DVec3::new(across * sin.x * cos.y, -across * cos.x * sin.y, 0.0)
            }
            Self::Table { ref file } => {
                let grid = VelocityGrid::load(Path::new(file));
                grid.map_or(DVec3::ZERO, |grid| grid.at(point))
            }
        }
    }

    /// A bound on the speeds within `reach` of `center` \[m/s].
    pub(super) fn greatest_speed(&self, center: DVec3, reach: f32) -> f32 {
        match *self {
            Self::Rotation {
                center: axis,
                angular_velocity,
            } => angular_velocity.length() * (axis.distance(center.as_vec3()) + reach),
            Self::TaylorGreen { speed, .. } => speed.abs(),
            // A file that cannot be read counts for nothing: the scene's check names it.
            Self::Table { ref file } => {
                VelocityGrid::load(Path::new(file)).map_or(0.0, |grid| grid.greatest_speed() as f32)
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// By differences at points without a pattern: no divergence, the right rotation, no speed above the bound.
    #[test]
    fn fields_are_free_of_divergence_and_within_their_bounds() {
        let omega = Vec3::new(0.5, -1.0, 2.0);
        let rotation = VelocityField::Rotation {
            center: Vec3::new(0.1, 0.2, -0.3),
            angular_velocity: omega,
        };
        let vortices = VelocityField::TaylorGreen {
            speed: -0.7,
            wavelength: 0.4,
            origin: Vec3::new(0.1, 0.0, 0.05),
        };
        let step = 1e-5;
        for k in 0..50 {
            let k = f64::from(k);
            let x = DVec3::new((1.3 * k).sin(), (2.1 * k).cos(), (0.7 * k).sin());
            for field in [&rotation, &vortices] {
                let slope = |axis: DVec3| {
                    (field.at(x + step * axis) - field.at(x - step * axis)) / (2.0 * step)
                };
                let [dx, dy, dz] = [DVec3::X, DVec3::Y, DVec3::Z].map(slope);
                assert!((dx.x + dy.y + dz.z).abs() < 1e-6);
                let most = f64::from(field.greatest_speed(DVec3::ZERO, x.length() as f32));
                assert!(field.at(x).length() <= most * (1.0 + 1e-6));
                if *field == rotation {
                    let curl = DVec3::new(dy.z - dz.y, dz.x - dx.z, dx.y - dy.x);
                    assert!(curl.distance(2.0 * omega.as_dvec3()) < 1e-6);
                }
            }
        }
        // Slip walls may stand at half the wavelength.
        for y in [0.03, 0.2] {
            let at_wall = vortices.at(DVec3::new(0.3, y, 0.0));
            assert!(at_wall.x.abs() < 1e-7, "{at_wall}");
        }
    }
}
