//! Compact hashing (paper 4.5): a hash table of handles and a compact list of the cells that contain points.
//!
//! The table has 2 N handles (4.4), addressed by equation 3; a handle names a used cell. A used cell reserves a block
//! of k entries in one pool and doubles its memory when it is full. [`update`](super::SpatialIndex::update) only moves
//! points that changed their cell (4.5.1). A flag marks used cells with points of several spatial cells (4.5.3).
//! [`rebuild`](super::SpatialIndex::rebuild) inserts points in row order, so that along the Z-curve consecutive used
//! cells are close in space (4.5.4). The query runs over used cells in parallel (4.5.2).
//!
//! Deviations: entries store a copy of the positions, a used cell stores its coordinates, and links lead to the used
//! cells around it (10 % of the query instead of 25 % for look-ups). If more than a quarter of the points changed
//! their cell, the index is rebuilt. Measurements and rejected variants: `docs/decisions/compact_hashing.md`.

mod arrivals;
mod cells;
mod comparison;
mod departed;
mod linking;
mod links;
mod moves;
mod pool;
mod spatial_index;
mod used_cell;

pub use cells::CompactHashing;
pub(super) use cells::ROW;
