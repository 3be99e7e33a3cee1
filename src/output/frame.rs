//! The state of all particles at one time.

use glam::Vec3;

/// The state of all fluid particles at one time: the source of frame files and pictures.
///
/// The columns have one row per particle; [`FIELDS`](super::FIELDS) describes them.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Frame {
    /// Number of the step, 0 before the first.
    pub step: u64,
    /// Simulated time \[s].
    pub time: f64,
    /// Permanent numbers of the particles: see [`ParticleId`](crate::state::particle::ParticleId).
    pub ids: Vec<u32>,
    /// \[m]
    pub positions: Vec<Vec3>,
    /// \[m/s]
    pub velocities: Vec<Vec3>,
    /// \[kg/m³]
    pub densities: Vec<f32>,
    /// \[Pa]
    pub pressures: Vec<f32>,
}

impl Frame {
    /// Number of particles.
    pub fn len(&self) -> usize {
        self.positions.len()
    }

    /// Whether the frame holds no particle.
    pub fn is_empty(&self) -> bool {
        self.positions.is_empty()
    }

    /// Makes room for exactly so many more particles.
    pub(super) fn reserve(&mut self, particles: usize) {
        self.ids.reserve_exact(particles);
        self.positions.reserve_exact(particles);
        self.velocities.reserve_exact(particles);
        self.densities.reserve_exact(particles);
        self.pressures.reserve_exact(particles);
    }

    /// Largest speed \[m/s]; 0 without particles. NaN is ignored.
    pub fn max_speed(&self) -> f32 {
        let squared = self.velocities.iter().map(|v| v.length_squared());
        squared.fold(0.0, f32::max).sqrt()
    }
}
