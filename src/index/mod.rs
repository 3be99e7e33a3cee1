//! Spatial indices: candidates for neighbours (paper section 4).
//!
//! One trait, and one file or folder per structure. An index sorts rows into cells. [`crate::neighbours`] requests the
//! rows of a cell and the candidates around it, tests distances and writes the lists.

mod boundary;
mod brute_force;
mod build;
mod by_row;
mod compact_hashing;
mod domain;
mod entries;
mod grid;
mod hash;
mod images;
mod index_sort;
mod periodic;
mod radix_sort;
mod spatial_hashing;
mod structure;
mod table;
mod uniform_grid;
mod update;
pub mod z_curve;
mod z_index_sort;

pub use boundary::BoundarySamples;
pub use brute_force::BruteForce;
pub use build::build;
pub(crate) use build::{build_for_walls, bytes_per_particle, table_bytes};
pub use compact_hashing::CompactHashing;
pub use entries::{Entries, Run};
pub use grid::Grid;
pub use images::Images;
pub use index_sort::IndexSort;
pub use spatial_hashing::SpatialHashing;
pub use structure::SpatialIndex;
pub use uniform_grid::UniformGrid;
pub(crate) use update::STAGE;
pub use update::{FluidIndex, update_index};
pub use z_index_sort::ZIndexSort;

#[cfg(test)]
mod tests;
