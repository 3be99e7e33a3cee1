//! Limits on the time step by motion and pressure.

use crate::state::{Limit, Material};

const FORCE_FACTOR: f32 = 0.25;
/// Part of the longest step in which a lattice is stable under its pressure. The first row beside a wall, and fluid
/// under an impact, have more pressure than their depth.
const PRESSURE_FACTOR: f32 = 0.5;

/// Limits by the motion, for a factor λ of the speed.
pub fn motion_limits(factor: f32, h: f32, max_speed: f32, max_acceleration: f32) -> [Limit; 2] {
    [
        ("speed", factor * h / max_speed),
        ("force", FORCE_FACTOR * (h / max_acceleration).sqrt()),
    ]
}

/// Longest time step [s] under a pressure [Pa], if `sqrt(p/ρ)` may cover so many spacings in a stable one.
pub(crate) fn pressure_limit(pressure_step: f32, material: &Material, pressure: f32) -> f32 {
    PRESSURE_FACTOR * pressure_step * material.spacing / (pressure / material.rest_density).sqrt()
}

/// What the control of a time step knows of a scene's physics.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct StepLimits {
    /// The least limit that does not change in a run [s].
    pub constant: f32,
    /// Spacings that `sqrt(p/ρ)` may cover in a stable step [-]; infinite with an equation of state, whose sound is
    /// faster.
    pub pressure_step: f32,
    /// Whether pressure iterates, and if so whether its corrections have momentum.
    pub momentum: Option<bool>,
}
