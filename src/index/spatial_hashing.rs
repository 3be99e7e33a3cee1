//! Spatial hashing (paper 4.4; Teschner et al. 2003): a hash table whose cells reserve memory for k entries each.
//!
//! The table has two hash cells per point, addressed by equation 3, each with k reserved entries: O(m k) memory. It is
//! cleared and filled serially in every step. The query iterates over particles, which the paper found faster than
//! over the table (6.1.4: 50 ms instead of 86). Points of different spatial cells may share a hash cell; the distance
//! test rejects them, and each hash cell is visited once per query.
//!
//! Deviations. Entries beyond k, which the paper does not discuss, go to a list sorted by hash cell. Consecutive rows
//! of one cell share their candidates. Positions are not copied to the entries: this would quadruple the memory of a
//! table that is 90 % empty.

use super::structure::Structure;
use glam::{IVec3, Vec4};
use rayon::prelude::*;

use super::{
    Grid, SpatialIndex,
    by_row::ByRow,
    entries::{Entries, PADDING, Run},
    hash::{CellHash, MIN_TABLE},
};
use crate::state::DomainTooLarge;
use crate::state::Execution;

/// Hash cells per point (4.4: "a hash table size of two times the number of particles is appropriate").
const CELLS_PER_POINT: f32 = 2.0;

/// The structure of section 4.4.
pub struct SpatialHashing {
    grid: Grid,
    hash: CellHash,
    cells_per_point: f32,
    /// The paper's k.
    reserved: usize,
    /// Number of points in every hash cell.
    lengths: Vec<u32>,
    /// k entries per hash cell, then the overflowing entries, in the order of `overflow`.
    entries: Entries,
    /// Hash cell and row of points beyond k, sorted.
    overflow: Vec<(u32, u32)>,
    by_row: ByRow<IVec3>,
}

/// The structure's row.
pub(in crate::index) const ROW: Structure = Structure {
    build: |grid, expected| Box::new(SpatialHashing::new(grid, expected)),
    table: None,
    // Two hash cells, each with 1.5 times the points of a full cell.
    bytes_per_particle: 216.0,
};

impl SpatialHashing {
    /// An empty index for `particles_per_cell` particles in a cell filled with fluid.
    pub fn new(grid: Grid, particles_per_cell: f32) -> Self {
        Self {
            grid,
            hash: CellHash::new(MIN_TABLE),
            cells_per_point: CELLS_PER_POINT,
            // Half as many again, so that a compressed cell rarely overflows.
            reserved: (1.5 * particles_per_cell).ceil().clamp(2.0, 1024.0) as usize,
            lengths: Vec::new(),
            entries: Entries::default(),
            overflow: Vec::new(),
            by_row: ByRow::default(),
        }
    }

    /// As [`new`](Self::new), but always with the smallest table, so that nearly every cell collides.
    #[cfg(test)]
    pub(crate) fn with_smallest_table(grid: Grid, particles_per_cell: f32) -> Self {
        let mut index = Self::new(grid, particles_per_cell);
        index.cells_per_point = 0.0;
        index
    }

    fn insert(&mut self) {
        let Self {
            hash,
            reserved,
            lengths,
            entries,
            overflow,
            by_row,
            ..
        } = self;
        let table = hash.size * *reserved;
        lengths.clear();
        lengths.resize(hash.size, 0);
        overflow.clear();
        entries.words.resize(table);
        let words = &mut *entries.words;
        for (row, &cell) in by_row.cells.iter().enumerate() {
            let place = hash.of(cell);
            let length = &mut lengths[place as usize];
            if (*length as usize) < *reserved {
                words[place as usize * *reserved + *length as usize] = row as u32;
            } else {
                overflow.push((place, row as u32));
            }
            *length += 1;
        }
        overflow.sort_unstable();
        entries.words.resize(table + overflow.len() + PADDING);
        for (word, &(_, row)) in entries.words[table..].iter_mut().zip(&*overflow) {
            *word = row;
        }
    }
}

impl SpatialIndex for SpatialHashing {
    fn update(&mut self, points: &[Vec4], execution: &Execution) -> Result<(), DomainTooLarge> {
        // Who shares a hash cell, and so the order of neighbours, follows from the points alone: not from how many
        // there were before.
        self.hash = CellHash::for_points(points.len(), self.cells_per_point);
        let grid = &self.grid;
        execution.install(|| {
            points
                .par_iter()
                .map(|&point| grid.cell_of(point))
                .collect_into_vec(&mut self.by_row.cells);
        });
        self.by_row.count_rows();
        self.insert();
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
        self.by_row.next_cell(partition, from)
    }

    fn entries(&self) -> &Entries {
        &self.entries
    }

    fn runs(&self, center: IVec3, out: &mut Vec<Run>) {
        let first = out.len();
        let mut seen = [0u64; 4];
        for &offset in &self.grid.neighbourhood {
            let place = self.hash.of(center.wrapping_add(offset));
            let Some(&len @ 1..) = self.lengths.get(place as usize) else {
                continue;
            };
            let start = place * self.reserved as u32;
            let (word, bit) = (place as usize / 64 % 4, 1 << (place % 64));
            if seen[word] & bit != 0 && out[first..].iter().any(|run| run.start == start) {
                continue;
            }
            seen[word] |= bit;
            let within = len.min(self.reserved as u32);
            out.push(Run { start, len: within });
            if len > within {
                let place = self.overflow.partition_point(|entry| entry.0 < place);
                let table = self.lengths.len() * self.reserved;
                out.push(Run {
                    start: (table + place) as u32,
                    len: len - within,
                });
            }
        }
    }

    fn bytes(&self) -> usize {
        self.lengths.capacity() * size_of::<u32>()
            + self.entries.bytes()
            + self.overflow.capacity() * size_of::<(u32, u32)>()
            + self.by_row.bytes()
    }
}
