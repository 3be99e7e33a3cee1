//! Neighbour lists: rows in one flat array, in an order that no number of threads changes.
//!
//! [`search`] goes through the cells of an index in parallel (paper 4.5.2), tests the candidates around each and writes
//! the hits. Every block of cells has a region of the flat array, sized by what it needed in the last step;
//! what finds no room there goes to the end. A particle is not in its own list.
//!
//! Not done, and why. Half the search, every pair tested once and written to both lists: the tests are a sixth of the
//! query by a profile, so half of them is less than what scattered writes to lists of other cells, their counting in a
//! first pass and their sorting would cost. Lists of 16-bit offsets: a density pass over them took 10 % less time in a
//! trial, at half the memory; but rows along the Z-curve are further apart than 32 767 wherever it crosses one of its
//! large borders, so every list would need a second form, and every loop a branch for it.

mod lists;
mod search;

use bevy_ecs::prelude::*;

pub use lists::NeighbourLists;
pub use search::{OnTheSpot, Search, search, tested_pairs};

use crate::{
    index::{BoundarySamples, FluidIndex},
    pairs::PairSlopes,
    state::ListsTooLong,
    state::{Execution, Failure, FailureCause, Positions},
};

/// Lists of the fluid particles (absent when neighbours are recomputed).
#[derive(Resource, Default)]
pub struct FluidNeighbours(pub NeighbourLists);

/// Lists of the boundary particles around every fluid particle.
#[derive(Resource, Default)]
pub struct BoundaryNeighbours(pub NeighbourLists);

/// Finds the neighbours among the fluid (phase `FindNeighbours`).
pub fn find_fluid_neighbours(
    mut lists: ResMut<FluidNeighbours>,
    mut slopes: ResMut<PairSlopes>,
    mut failure: ResMut<Failure>,
    index: Res<FluidIndex>,
    positions: Res<Positions>,
    execution: Res<Execution>,
) {
    slopes.forget();
    let task = Search::among_themselves(&*index.structure, positions.points());
    note(search(&task, &mut lists.0, &execution), &mut failure);
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

/// Makes lists that are too long the step's failure.
fn note(result: Result<(), ListsTooLong>, failure: &mut Failure) {
    if let Err(error) = result {
        let row = match error {
            ListsTooLong::OfRow { row, .. } => Some(row),
            ListsTooLong::Together { .. } => None,
        };
        failure.record(FailureCause::ListsTooLong(error), row);
    }
}
