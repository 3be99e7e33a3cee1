//! What a run writes: frames, series, history, summary, pictures.

use glam::Vec3;

/// The state of all fluid particles at one time: what frames and pictures are made from.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Frame {
    /// Number of the step, 0 before the first.
    pub step: u64,
    /// Simulated time [s].
    pub time: f64,
    /// A particle's lasting number.
    pub ids: Vec<u32>,
    /// [m]
    pub positions: Vec<Vec3>,
    /// [m/s]
    pub velocities: Vec<Vec3>,
    /// [kg/m³]
    pub densities: Vec<f32>,
    /// [Pa]
    pub pressures: Vec<f32>,
}
