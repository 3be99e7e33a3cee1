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

mod find;
mod lists;
mod search;

pub(crate) use find::STAGE;
pub use find::{
    BoundaryNeighbours, FluidNeighbours, find_boundary_neighbours, find_fluid_neighbours,
};
pub use lists::NeighbourLists;
pub use search::{OnTheSpot, Search, search, tested_pairs};
