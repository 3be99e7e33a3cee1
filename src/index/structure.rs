//! The interface between spatial structures and the neighbour search.

use glam::{IVec3, Vec4};

use super::{
    domain::TableSize,
    entries::{Entries, Run},
    grid::Grid,
    images::Images,
};
use crate::state::{DomainTooLarge, Execution};

/// A spatial structure: its constructor and its memory. Declared beside its code.
pub(super) struct Structure {
    /// An empty index over a grid, given the expected number of particles in a cell filled with fluid.
    pub(super) build: fn(Grid, f32) -> Box<dyn SpatialIndex>,
    /// Number of table entries (4 bytes each) for a box of cells; none if empty cells take no memory.
    pub(super) table: Option<TableSize>,
    /// Memory, measured with eight particles per cell \[bytes per particle].
    pub(super) bytes_per_particle: f64,
}

/// A structure that sorts points into cells. Rows are indices into the slice of points given last.
pub trait SpatialIndex: Send + Sync + 'static {
    /// Updates the index for new positions. Rows may have been added, removed or renamed. A dense structure fails if
    /// the points are too far apart; it then keeps the previous points.
    fn update(&mut self, points: &[Vec4], execution: &Execution) -> Result<(), DomainTooLarge>;

    /// Rebuilds the index for positions whose rows were permuted.
    fn rebuild(&mut self, points: &[Vec4], execution: &Execution) -> Result<(), DomainTooLarge>;

    /// Geometry of the cells.
    fn grid(&self) -> &Grid;

    /// Points and their images beyond the faces of periodic axes: rows behind the last that was given are images.
    fn images(&self) -> Option<&Images> {
        None
    }

    /// Number of partitions that a search iterates over: cells, or blocks of entries or rows. Together they hold all
    /// points.
    fn partitions(&self) -> usize;

    /// Number of points in `partition`.
    fn partition_len(&self, partition: usize) -> usize;

    /// The spatial cell of the `from`-th point of `partition`, and that point with those after it in the same cell;
    /// `None` behind the last. A pull instead of a callback: the calling search is compiled for an instruction set,
    /// and a callback would not be.
    fn next_cell(&self, partition: usize, from: usize) -> Option<(IVec3, &[u32])>;

    /// All rows in cell order.
    fn entries(&self) -> &Entries;

    /// Appends runs of entries that contain every point within reach of spatial cell `center`, each once. Points
    /// farther away may be among them.
    fn runs(&self, center: IVec3, out: &mut Vec<Run>);

    /// As [`runs`](Self::runs), for a cell that [`next_cell`](Self::next_cell) returned for `partition`. Saves
    /// look-ups: even that of the cell itself takes compact hashing 13 % of a query.
    fn runs_around(&self, partition: usize, center: IVec3, out: &mut Vec<Run>) {
        let _ = partition;
        self.runs(center, out);
    }

    /// Prefetches data for the next search of `partition`. Useful if the points around a partition are scattered in
    /// memory.
    fn prefetch_around(&self, partition: usize) {
        let _ = partition;
    }

    /// Memory held \[bytes].
    fn bytes(&self) -> usize;
}
