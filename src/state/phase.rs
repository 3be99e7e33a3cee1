//! The phases of a step, in order.

use bevy_ecs::prelude::*;
use serde::{Deserialize, Serialize};

/// A phase of the step. Hosts order their own systems against these sets.
#[derive(
    SystemSet, Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord, Serialize, Deserialize,
)]
#[serde(rename_all = "snake_case")]
#[non_exhaustive]
pub enum Phase {
    /// Brings columns into rows and the spatial index up to date with the positions (paper 4.1–4.5).
    RebuildIndex,
    /// Writes the neighbour lists (paper 5.3.1).
    FindNeighbours,
    /// Density with its boundary contribution (paper eq. 1).
    Density,
    /// Gravity, viscosity, surface tension, as the scene asks (paper 5); with viscosity also the first pressure force,
    /// where iterations start with one (see [`first_force`](crate::pressure::first_force)).
    Forces,
    /// State equation, or iterations until the density error is small (paper 5.1, 5.2).
    Pressure,
    /// Velocities and positions, the failure guard, the next time step (paper 5).
    Integrate,
    /// Moves rows into Z-curve order (paper 4.5.4).
    Reorder,
    /// Measures of the step.
    Observe,
}

impl Phase {
    /// Every phase, in order.
    pub const ALL: [Self; 8] = [
        Self::RebuildIndex,
        Self::FindNeighbours,
        Self::Density,
        Self::Forces,
        Self::Pressure,
        Self::Integrate,
        Self::Reorder,
        Self::Observe,
    ];

    /// Name in reports and files.
    pub fn name(self) -> &'static str {
        match self {
            Self::RebuildIndex => "rebuild_index",
            Self::FindNeighbours => "find_neighbours",
            Self::Density => "density",
            Self::Forces => "forces",
            Self::Pressure => "pressure",
            Self::Integrate => "integrate",
            Self::Reorder => "reorder",
            Self::Observe => "observe",
        }
    }
}
