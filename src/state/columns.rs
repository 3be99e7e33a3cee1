//! Columns of all fluid particles, indexed by row: what the systems of a step work on.
//!
//! Tables of the ECS hold the particles as they were spawned, in one table or in several.
//! [`transfer`](super::transfer) copies them into these columns at the start of a step and back at its end. In between
//! every column is one slice. The choice of packed copies is measured in `docs/decisions/columns.md`.

use bevy_ecs::prelude::*;
use glam::{Vec3, Vec4};

/// Position of the entry behind the last row: so far away that every kernel is zero there. Lanes of a neighbour loop
/// that have no neighbour read it.
pub const SENTINEL: Vec4 = Vec4::new(1e18, 1e18, 1e18, 0.0);

/// Coordinates [m] and components of velocities [m/s] from which a step refuses a particle: squares overflow at 1e19,
/// and
/// [`SENTINEL`] must be further away than any particle.
pub(crate) const TOO_LARGE: f32 = 1e17;

/// Who is in which row: the entities, in the order in which [`gather_columns`] met them last.
#[derive(Resource, Debug, Clone, Default)]
pub struct Rows {
    /// The entity of every row.
    pub entities: Vec<Entity>,
    /// Whether rows named other particles before. What earlier steps left behind by row is of no use then.
    pub changed: bool,
}

/// Positions [m]; the fourth entry is the pressure term `p/ρ²` of the pressure force. A sentinel ends them.
#[derive(Resource, Debug, Clone)]
pub struct Positions(pub Vec<Vec4>);

/// Velocities [m/s]; the fourth entry is the density [kg/m³] where viscosity wants it. A sentinel of zero
/// ends them.
#[derive(Resource, Debug, Clone)]
pub struct Velocities(pub Vec<Vec4>);

/// Densities [kg/m³; kg/m² in 2-D].
#[derive(Resource, Debug, Clone, Default)]
pub struct Densities(pub Vec<f32>);

/// Pressures [Pa].
#[derive(Resource, Debug, Clone, Default)]
pub struct Pressures(pub Vec<f32>);

/// Accelerations by all forces but pressure [m/s²].
#[derive(Resource, Debug, Clone, Default)]
pub struct Accelerations(pub Vec<Vec3>);

/// Accelerations by pressure [m/s²].
#[derive(Resource, Debug, Clone, Default)]
pub struct PressureAccelerations(pub Vec<Vec3>);

/// Positions at the end of the step [m], while it is not certain that the step is good. A sentinel ends them.
#[derive(Resource, Debug, Clone)]
pub struct PredictedPositions(pub Vec<Vec4>);

impl Default for PredictedPositions {
    fn default() -> Self {
        Self(vec![SENTINEL])
    }
}

impl Default for Positions {
    fn default() -> Self {
        Self(vec![SENTINEL])
    }
}

impl Positions {
    /// The positions without the sentinel.
    pub fn points(&self) -> &[Vec4] {
        &self.0[..self.0.len() - 1]
    }

    /// Number of fluid particles.
    pub fn rows(&self) -> usize {
        self.0.len() - 1
    }
}

impl Default for Velocities {
    fn default() -> Self {
        Self(vec![Vec4::ZERO])
    }
}
