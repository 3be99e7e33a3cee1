//! The neighbour lists of the fluid, computed in every step.

use bevy_ecs::prelude::*;

use super::{
    lists::NeighbourLists,
    search::{Search, search},
};
use crate::{
    index::{BoundarySamples, FluidIndex},
    state::{Execution, Failure, FailureCause, ListsTooLong, Positions},
};

/// Lists of the fluid particles (absent when neighbours are recomputed).
#[derive(Resource, Default)]
pub struct FluidNeighbours {
    /// The lists.
    pub(crate) lists: NeighbourLists,
    /// Number of searches so far.
    pub(crate) generation: u64,
}

/// Lists of the boundary particles around every fluid particle.
#[derive(Resource)]
pub struct BoundaryNeighbours(pub(crate) NeighbourLists);

impl FluidNeighbours {
    /// The lists.
    pub fn lists(&self) -> &NeighbourLists {
        &self.lists
    }
}

impl BoundaryNeighbours {
    /// The lists.
    pub fn lists(&self) -> &NeighbourLists {
        &self.0
    }
}

impl Default for BoundaryNeighbours {
    fn default() -> Self {
        Self(NeighbourLists::mostly_empty())
    }
}

/// Finds the neighbours among the fluid (phase `FindNeighbours`).
pub fn find_fluid_neighbours(
    mut lists: ResMut<FluidNeighbours>,
    mut failure: ResMut<Failure>,
    index: Res<FluidIndex>,
    positions: Res<Positions>,
    execution: Res<Execution>,
) {
    lists.generation += 1;
    let task = Search::among_themselves(&*index.structure, positions.points());
    note(search(&task, &mut lists.lists, &execution), &mut failure);
}

/// Finds the neighbours among the boundary (phase `FindNeighbours`).
pub fn find_boundary_neighbours(
    mut lists: ResMut<BoundaryNeighbours>,
    mut failure: ResMut<Failure>,
    index: Res<FluidIndex>,
    boundary: Res<BoundarySamples>,
    positions: Res<Positions>,
    execution: Res<Execution>,
) {
    let task = Search {
        of: &*index.structure,
        points: positions.points(),
        among: &*boundary.index,
        among_points: boundary.points(),
        same: false,
    };
    note(search(&task, &mut lists.0, &execution), &mut failure);
}

/// Records lists that are too long as the step's failure.
fn note(result: Result<(), ListsTooLong>, failure: &mut Failure) {
    if let Err(error) = result {
        let row = match error {
            ListsTooLong::OfRow { row, .. } => Some(row),
            ListsTooLong::Together { .. } => None,
        };
        failure.record(FailureCause::ListsTooLong(error), row);
    }
}
