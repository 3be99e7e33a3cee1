//! Compact hashing (paper 4.5): a hash table of handles and a compact list of the cells that hold points.
//!
//! - The table has 2 N handles (4.4: "two times the number of particles"), placed by equation 3; a handle names a used
//!   cell. N here is the number of points at the last rebuild; the table follows when it grows or falls by half.
//! - A used cell reserves a block of k entries in one pool and moves to twice as many when they are full, and back when
//!   two thirds of half of them would do.
//! - [`update`](super::SpatialIndex::update) compares every point's cell with the last step's and moves only those
//!   that changed (4.5.1; `comparison.rs`, `moves.rs`). Cells that are empty then leave the list.
//! - A used cell knows whether it holds points of more than one spatial cell (4.5.3).
//! - [`rebuild`](super::SpatialIndex::rebuild) inserts the points in the order of their rows. Where rows follow the
//!   Z-curve, used cells that follow each other are near each other (4.5.4).
//! - The query goes over the used cells in parallel (4.5.2).
//!
//! Deviations. Entries hold a copy of their positions (see `entries.rs`); one loop over the entries both compares and
//! copies. A used cell keeps its spatial coordinates: candidates are taken from it only where they are the ones that
//! were asked for, so two neighbouring cells that share a hash cell are not seen twice. When more than a quarter of the
//! points changed their cell (a host spawned in the middle of the rows), all are inserted anew.
//!
//! A used cell links to the used cells around it, so that a query computes no hash (see `links.rs`); who comes or goes
//! tells the 26 around. Two used cells of a hundred hold several spatial cells, and to tell their points apart by
//! position for each of 27 queries took a seventh of all: the points of one of the cells come first and are counted,
//! and those of another, which are mostly the rest, are told by the last. Blocks begin with a cache line, and those
//! around the next cell are prefetched: with two threads the query of 131 072 points took a tenth less, of a million a
//! seventh.
//!
//! Tried and dropped: look-ups remembered by each thread for the cells nearby (a quarter of the query, where links take
//! a tenth; for cells of h/2, which have no links, 9.7 µs a point for 8.6 without), links that are looked up and set by
//! the query that needs them (a quarter), a bit for every place of the table that is in use (no difference), unknown
//! cells looked up together, so that their loads overlap (slower), what is around every cell near walls kept with the
//! walls (12 % of their search, 3 % of the whole, for 50 bytes a wall particle).

mod arrivals;
mod cells;
mod comparison;
mod linking;
mod links;
mod movers;
mod moves;
mod pool;
mod spatial_index;
mod used_cell;

pub use cells::CompactHashing;
pub(super) use cells::ROW;
