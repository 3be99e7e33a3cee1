//! Velocities of a body at the start that are not the same everywhere.

use std::f64::consts::TAU;

use glam::{DVec3, Vec3};
use serde::{Deserialize, Serialize};

/// A field of velocities at the start.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub enum VelocityField {
    /// Rotation as a rigid body, `ω × (x − center)`.
    Rotation {
        /// A point of the axis [m].
        center: Vec3,
        /// ω, along the axis [rad/s]; in 2-D along z.
        angular_velocity: Vec3,
    },
    /// Taylor–Green vortices: with `k = 2π/wavelength` and ξ the place from `origin`,
    /// `speed (sin kξ_x cos kξ_y cos kξ_z, −cos kξ_x sin kξ_y cos kξ_z, 0)`. Nothing flows through the planes in which kξ_x
    /// or kξ_y is a multiple of π, so that slip walls may stand there. In 2-D ξ_z is 0, and the decay
    /// `exp(−2 ν k² t)` is exact.
    TaylorGreen {
        /// Largest speed [m/s].
        speed: f32,
        /// Two vortices side by side [m].
        wavelength: f32,
        /// Corner of a vortex [m].
        #[serde(default)]
        origin: Vec3,
    },
}

impl VelocityField {
    /// Velocity at a point [m/s].
    pub fn at(&self, point: DVec3) -> DVec3 {
        match *self {
            Self::Rotation {
                center,
                angular_velocity,
            } => angular_velocity
                .as_dvec3()
                .cross(point - center.as_dvec3()),
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
        }
    }

    /// A bound on the speeds within `reach` of `center` [m/s].
    pub(super) fn greatest_speed(&self, center: DVec3, reach: f32) -> f32 {
        match *self {
            Self::Rotation {
                center: axis,
                angular_velocity,
            } => angular_velocity.length() * (axis.distance(center.as_vec3()) + reach),
            Self::TaylorGreen { speed, .. } => speed.abs(),
        }
    }
}
