//! Index sort (paper 4.2): handles sorted by row-major cell index; every cell refers to its first handle.
//!
//! Requires a bounding box: 4 bytes for every cell in it, used or empty, at most
//! [`MAX_CELLS`](crate::state::MAX_CELLS).
//!
//! - Handles are sorted in every step by a parallel radix sort (6.1.2).
//! - A parallel reduction inserts the references into the grid (4.2.1).
//! - The query runs over the sorted handles in parallel (4.2.2); points of a cell share their candidates.
//!
//! Deviations. Only handles are sorted, not particles with all attributes; rows follow the Z-curve as for the other
//! structures. The table is complete (`table.rs`), and positions are copied into cell order (`entries.rs`).

use super::structure::Structure;
use glam::{IVec3, Vec4};
use rayon::prelude::*;

use super::{
    Grid, SpatialIndex,
    domain::{self, Domain},
    entries::{Entries, Run},
    radix_sort::RadixSort,
    table::{SortedCells, handle, row_major_runs},
};
use crate::state::DomainTooLarge;
use crate::state::Execution;

/// The structure of the paper's Figure 1.
pub struct IndexSort {
    grid: Grid,
    domain: Domain,
    sort: RadixSort,
    cells: SortedCells,
}

/// The structure's row.
pub(in crate::index) const ROW: Structure = Structure {
    build: |grid, _| Box::new(IndexSort::new(grid)),
    table: Some(domain::unpadded),
    bytes_per_particle: 37.0,
};

impl IndexSort {
    /// An empty index.
    pub fn new(grid: Grid) -> Self {
        Self {
            grid,
            domain: Domain::default(),
            sort: RadixSort::default(),
            cells: SortedCells::default(),
        }
    }
}

impl SpatialIndex for IndexSort {
    fn update(&mut self, points: &[Vec4], execution: &Execution) -> Result<(), DomainTooLarge> {
        self.domain
            .fit(&self.grid, points, domain::unpadded, execution)?;
        let (grid, domain) = (&self.grid, &self.domain);
        let cells = domain::unpadded(domain.size.map(u64::from)) as u32;
        let handles = points.par_iter().enumerate().map(|(row, &point)| {
            let key = domain.row_major(domain.place(grid.cell_of(point)));
            handle(key, row as u32)
        });
        self.sort.sort(handles, cells, execution);
        let sorted = |k| self.sort.get(k);
        self.cells.take(sorted, cells as usize, points, execution);
        Ok(())
    }

    fn rebuild(&mut self, points: &[Vec4], execution: &Execution) -> Result<(), DomainTooLarge> {
        self.update(points, execution)
    }

    fn grid(&self) -> &Grid {
        &self.grid
    }

    fn partitions(&self) -> usize {
        self.cells.partitions()
    }

    fn partition_len(&self, partition: usize) -> usize {
        self.cells.partition(partition).len()
    }

    fn next_cell(&self, partition: usize, from: usize) -> Option<(IVec3, &[u32])> {
        let (key, rows) = self.cells.next_cell(partition, from)?;
        Some((self.domain.cell(key), rows))
    }

    fn entries(&self) -> &Entries {
        &self.cells.entries
    }

    fn runs(&self, center: IVec3, out: &mut Vec<Run>) {
        let run = |first, last| self.cells.run(first, last);
        row_major_runs(&self.domain, self.grid.reach, center, run, out);
    }

    fn bytes(&self) -> usize {
        self.sort.bytes() + self.cells.bytes()
    }
}
