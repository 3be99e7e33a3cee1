//! Spatial indices: who may be near whom (paper section 4).
//!
//! One trait, a file for each structure. An index sorts rows into cells; [`crate::neighbours`] asks it for the rows
//! of a cell and for the candidates around it, tests distances and writes lists.

mod brute_force;
mod by_row;
mod compact_hashing;
mod domain;
mod entries;
mod grid;
mod hash;
mod index_sort;
mod radix_sort;
mod spatial_hashing;
mod table;
mod uniform_grid;
pub mod z_curve;
mod z_index_sort;

use bevy_ecs::prelude::*;
use glam::{DVec3, IVec3, Vec4};

pub use brute_force::BruteForce;
pub use compact_hashing::CompactHashing;
pub use domain::{DomainTooLarge, MAX_CELLS};
pub use entries::{Entries, Run};
pub use grid::Grid;
pub use index_sort::IndexSort;
pub use spatial_hashing::SpatialHashing;
pub use uniform_grid::UniformGrid;
pub use z_index_sort::ZIndexSort;

use crate::{
    column::Positions,
    execution::Execution,
    scene::{self, IndexStructure, Scene},
    step::{Failure, FailureCause},
};

/// A structure that sorts points into cells. Rows are indices into the slice of points given last.
pub trait SpatialIndex: Send + Sync + 'static {
    /// Takes over new positions. Rows may have come, gone or changed what they name. A dense structure fails if the
    /// points lie too far apart; it holds the points before, then.
    fn update(&mut self, points: &[Vec4], execution: &Execution) -> Result<(), DomainTooLarge>;

    /// Takes over positions whose rows were put into another order: builds everything anew.
    fn rebuild(&mut self, points: &[Vec4], execution: &Execution) -> Result<(), DomainTooLarge>;

    /// The cells' geometry.
    fn grid(&self) -> &Grid;

    /// Number of places that a search goes through: cells, or blocks of entries or rows. They hold all points.
    fn places(&self) -> usize;

    /// Number of points in `place`.
    fn place_len(&self, place: usize) -> usize;

    /// The `from`-th point of `place` and those after it that lie in the same spatial cell, which comes first;
    /// `None` behind the last. A pull and no callback: the search that asks is compiled for an instruction set, and a
    /// callback would not be.
    fn group(&self, place: usize, from: usize) -> Option<(IVec3, &[u32])>;

    /// All rows in the order of the cells.
    fn entries(&self) -> &Entries;

    /// Appends runs of entries that hold every point within reach of spatial cell `center`, each once. Points further
    /// away may be among them.
    fn runs(&self, center: IVec3, out: &mut Vec<Run>);

    /// The same around the cell of a group of `place`, by what a structure knows of its places: to look up even the
    /// cell itself takes compact hashing 13 % of a query.
    fn runs_around(&self, place: usize, center: IVec3, out: &mut Vec<Run>) {
        let _ = place;
        self.runs(center, out);
    }

    /// Hints that a search comes to `place` next. Worth it where the points around a place are scattered in memory.
    fn prefetch_around(&self, place: usize) {
        let _ = place;
    }

    /// Memory held [bytes].
    fn bytes(&self) -> usize;
}

/// Index of the fluid particles.
#[derive(Resource)]
pub struct FluidIndex {
    /// The structure that the scene asks for.
    pub structure: Box<dyn SpatialIndex>,
    /// Whether the rows were reordered since the last update.
    pub reordered: bool,
}

/// The structure of a scene.
pub fn build(scene: &Scene) -> Box<dyn SpatialIndex> {
    let scene::Index {
        structure,
        cell_size,
    } = scene.index;
    let grid = Grid::new(scene.dimension, scene.support_radius(), cell_size);
    let particles_a_cell = (cell_size * scene.support()).powi(u8::from(scene.dimension).into());
    match structure {
        IndexStructure::UniformGrid => Box::new(UniformGrid::new(grid)),
        IndexStructure::IndexSort => Box::new(IndexSort::new(grid)),
        IndexStructure::ZIndexSort => Box::new(ZIndexSort::new(grid)),
        IndexStructure::SpatialHashing => Box::new(SpatialHashing::new(grid, particles_a_cell)),
        IndexStructure::CompactHashing => Box::new(CompactHashing::new(grid, particles_a_cell)),
        IndexStructure::BruteForce => Box::new(BruteForce::new(grid)),
    }
}

/// What the tables of a scene's structure take for the cells of a box, used or not [bytes]. Fails if they are too many;
/// the corners of the box are in metres.
pub(crate) fn table_bytes(scene: &Scene, low: DVec3, high: DVec3) -> Result<u64, DomainTooLarge> {
    let table_size: domain::TableSize = match scene.index.structure {
        IndexStructure::UniformGrid | IndexStructure::IndexSort => domain::unpadded,
        IndexStructure::ZIndexSort => z_index_sort::padded,
        IndexStructure::SpatialHashing
        | IndexStructure::CompactHashing
        | IndexStructure::BruteForce => return Ok(0),
    };
    let grid = Grid::new(
        scene.dimension,
        scene.support_radius(),
        scene.index.cell_size,
    );
    let cell = |corner: DVec3| grid.cell_of(corner.as_vec3().extend(0.0));
    let cells = domain::needed(&grid, cell(low), cell(high), table_size)?;
    Ok(4 * table_size(cells))
}

/// Brings the index up to date with the rows (phase `RebuildIndex`).
pub fn update_index(
    mut index: ResMut<FluidIndex>,
    mut failure: ResMut<Failure>,
    positions: Res<Positions>,
    execution: Res<Execution>,
) {
    let update = if index.reordered {
        index.structure.rebuild(positions.points(), &execution)
    } else {
        index.structure.update(positions.points(), &execution)
    };
    match update {
        Ok(()) => index.reordered = false,
        Err(error) => failure.record(FailureCause::DomainTooLarge(error), Some(error.row)),
    }
}

#[cfg(test)]
mod tests;
