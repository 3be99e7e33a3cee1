//! What a spatial structure does for the search.

use glam::{IVec3, Vec4};

use super::{
    domain::TableSize,
    entries::{Entries, Run},
    grid::Grid,
};
use crate::state::{DomainTooLarge, Execution};

/// A spatial structure: how it is made, and what it takes. Declared beside its code.
pub(super) struct Structure {
    /// An empty index over a grid, which expects so many particles in a cell where there is fluid.
    pub(super) build: fn(Grid, f32) -> Box<dyn SpatialIndex>,
    /// Cells of the table that covers a box of cells, 4 bytes each; none if empty cells take no memory.
    pub(super) table: Option<TableSize>,
    /// Memory, measured with eight particles per cell [bytes per particle].
    pub(super) bytes_per_particle: f64,
}

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
