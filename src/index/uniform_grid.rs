//! Basic uniform grid (paper 4.1): a dense grid over the bounding box, filled serially, queried in parallel over
//! particles.
//!
//! Requires a bounding box: 4 bytes for every cell in it, used or empty, at most
//! [`MAX_CELLS`](crate::state::MAX_CELLS).
//!
//! Points are inserted serially, because two threads that insert into one cell would race; only cell indices (eq. 2)
//! are computed in parallel. The query iterates over particles: "we do not have to traverse the whole, sparsely filled
//! grid" (6.1.1).
//!
//! Deviations. Instead of a growing list per cell, with one allocation each, points are counted first and a cell is a
//! part of one array. Consecutive rows of one cell share their candidates, and positions are copied into cell order.

use super::structure::Structure;
use glam::{IVec3, Vec4};
use rayon::prelude::*;

use super::{
    Grid, SpatialIndex,
    by_row::ByRow,
    domain::{self, Domain},
    entries::{Entries, Run},
    table::row_major_runs,
};
use crate::state::DomainTooLarge;
use crate::state::Execution;

/// The structure of section 4.1.
pub struct UniformGrid {
    grid: Grid,
    domain: Domain,
    /// Indices of the cells of all rows.
    by_row: ByRow<u32>,
    /// End of every cell's entries: those of cell c begin at `ends[c - 1]`.
    ends: Vec<u32>,
    entries: Entries,
}

/// The structure's row.
pub(in crate::index) const ROW: Structure = Structure {
    build: |grid, _| Box::new(UniformGrid::new(grid)),
    table: Some(domain::unpadded),
    bytes_per_particle: 25.0,
};

impl UniformGrid {
    /// An empty index.
    pub fn new(grid: Grid) -> Self {
        Self {
            grid,
            domain: Domain::default(),
            by_row: ByRow::default(),
            ends: Vec::new(),
            entries: Entries::default(),
        }
    }

    fn insert(&mut self) {
        let cells = &self.by_row.cells;
        let ends = &mut self.ends;
        ends.clear();
        ends.resize(
            domain::unpadded(self.domain.size.map(u64::from)) as usize,
            0,
        );
        for &cell in cells {
            ends[cell as usize] += 1;
        }
        // Start of every cell; insertion turns it into the end.
        let mut begin = 0;
        for end in ends.iter_mut() {
            begin += std::mem::replace(end, begin);
        }
        let rows = self.entries.all_rows_mut();
        for (row, &cell) in cells.iter().enumerate() {
            let place = &mut ends[cell as usize];
            rows[*place as usize] = row as u32;
            *place += 1;
        }
    }
}

impl SpatialIndex for UniformGrid {
    fn update(&mut self, points: &[Vec4], execution: &Execution) -> Result<(), DomainTooLarge> {
        self.domain
            .fit(&self.grid, points, domain::unpadded, execution)?;
        let (grid, domain) = (&self.grid, &self.domain);
        execution.install(|| {
            points
                .par_iter()
                .map(|&point| domain.row_major(domain.place(grid.cell_of(point))))
                .collect_into_vec(&mut self.by_row.cells);
        });
        self.by_row.count_rows();
        self.entries.resize(points.len());
        self.insert();
        self.entries.copy_positions(points, execution);
        Ok(())
    }

    fn rebuild(&mut self, points: &[Vec4], execution: &Execution) -> Result<(), DomainTooLarge> {
        self.update(points, execution)
    }

    fn grid(&self) -> &Grid {
        &self.grid
    }

    fn partitions(&self) -> usize {
        self.by_row.partitions()
    }

    fn partition_len(&self, partition: usize) -> usize {
        self.by_row.partition(partition).len()
    }

    fn next_cell(&self, partition: usize, from: usize) -> Option<(IVec3, &[u32])> {
        let (cell, rows) = self.by_row.next_cell(partition, from)?;
        Some((self.domain.cell(cell), rows))
    }

    fn entries(&self) -> &Entries {
        &self.entries
    }

    fn runs(&self, center: IVec3, out: &mut Vec<Run>) {
        let run = |first: u32, last: u32| {
            let start = first.checked_sub(1).map_or(0, |c| self.ends[c as usize]);
            let len = self.ends[last as usize] - start;
            Run { start, len }
        };
        row_major_runs(&self.domain, self.grid.reach, center, run, out);
    }

    fn bytes(&self) -> usize {
        self.by_row.bytes() + self.ends.capacity() * size_of::<u32>() + self.entries.bytes()
    }
}
