//! Limits on the time step by motion and pressure.

use crate::state::{Limit, Material};

const FORCE_FACTOR: f32 = 0.25;
/// Safety factor on the longest step in which a lattice is stable under its pressure. The first row beside a wall, and
/// fluid under an impact, have more pressure than hydrostatic.
const PRESSURE_FACTOR: f32 = 0.5;

/// Limits by motion, for a CFL factor λ.
pub fn motion_limits(factor: f32, h: f32, max_speed: f32, max_acceleration: f32) -> [Limit; 2] {
    [
        ("speed", factor * h / max_speed),
        ("force", FORCE_FACTOR * (h / max_acceleration).sqrt()),
    ]
}

/// Longest time step \[s] under a pressure \[Pa], if `sqrt(p/ρ)` may cover `pressure_step` spacings.
pub(crate) fn pressure_limit(pressure_step: f32, material: &Material, pressure: f32) -> f32 {
    PRESSURE_FACTOR * pressure_step * material.spacing / (pressure / material.rest_density).sqrt()
}

/// Limits by a scene's physics, for the time step control.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct StepLimits {
    /// The smallest limit that is constant in a run \[s].
    pub constant: f32,
    /// Number of spacings that `sqrt(p/ρ)` may cover in a stable step \[-]; infinite with an equation of state, whose
    /// sound is faster.
    pub pressure_step: f32,
    /// None if pressure does not iterate; otherwise whether its corrections have momentum.
    pub momentum: Option<bool>,
}
