//! Neighbour lists: rows in one flat array, in an order that does not depend on the number of threads.
//!
//! `search` iterates over the cells of an index in parallel (paper 4.5.2), tests the candidates around each cell and
//! writes the hits. Every block of cells has a region of the flat array, sized by the last step; lists that do not fit
//! are appended. A particle is not in its own list.
//!
//! Rejected: testing each pair once and writing it to both lists, because the tests are only a sixth of the query and
//! scattered writes cost more. Rejected: lists of 16-bit offsets, 10 % faster in a density pass at half the memory,
//! because rows along the Z-curve can be more than 32 767 apart and every loop would need a second form.

mod find;
mod lists;
mod search;
mod stages;
mod tested;
mod verlet;

pub use find::{
    BoundaryNeighbours, FluidNeighbours, find_boundary_neighbours, find_fluid_neighbours,
};
pub use lists::NeighbourLists;
pub use search::{Recomputed, Search, search};
pub(crate) use stages::{INDEX, STAGE};
pub use tested::tested_pairs;
pub use verlet::KeptLists;
pub(crate) use verlet::REMEMBERED;
