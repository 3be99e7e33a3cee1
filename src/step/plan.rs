//! What a run of a scene would do, told without doing it.

use super::{InstallError, Phase};
use crate::scene::Scene;

/// The plan of a run.
#[derive(Debug, Clone, Default, PartialEq)]
#[non_exhaustive]
pub struct Plan {
    /// Fluid particles.
    pub particles: usize,
    /// Boundary particles.
    pub boundary_particles: usize,
    /// Support radius h [m].
    pub support_radius: f32,
    /// Mass of a fluid particle [kg; kg/m in 2-D].
    pub particle_mass: f32,
    /// Every phase with the names of its systems, in the order they run in.
    pub phases: Vec<(Phase, Vec<String>)>,
    /// What is stored for a fluid particle, and how much of it [bytes].
    pub bytes_per_particle: Vec<(String, f64)>,
    /// What limits the time step, and to how much [s]; infinite if it does not.
    pub time_step_limits: Vec<(String, f32)>,
    /// Neighbours of a particle within the fluid.
    pub expected_neighbours: f32,
}

/// Plans a run of a scene.
///
/// # Errors
/// As [`Simulation::new`](super::Simulation::new).
pub fn plan(_scene: &Scene) -> Result<Plan, InstallError> {
    Ok(Plan::default())
}
