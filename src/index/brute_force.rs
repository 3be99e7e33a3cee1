//! Tests every pair: the reference that the other structures are compared with.

use super::structure::Structure;
use glam::{IVec3, Vec4};

use super::{
    Grid, SpatialIndex,
    entries::{Entries, Run},
};
use crate::state::DomainTooLarge;
use crate::state::Execution;

/// Points per parallel task.
const BLOCK: usize = 64;

/// A structure without cells: all points are candidates.
#[derive(Debug, Clone)]
pub struct BruteForce {
    grid: Grid,
    entries: Entries,
    len: usize,
}

/// The structure's row.
pub(in crate::index) const ROW: Structure = Structure {
    build: |grid, _| Box::new(BruteForce::new(grid)),
    table: None,
    bytes_per_particle: 16.0,
};

impl BruteForce {
    /// The grid only provides the support radius.
    pub fn new(grid: Grid) -> Self {
        Self {
            grid,
            entries: Entries::default(),
            len: 0,
        }
    }

    fn block(&self, partition: usize) -> &[u32] {
        &self.entries.all_rows()[partition * BLOCK..self.len.min((partition + 1) * BLOCK)]
    }
}

impl SpatialIndex for BruteForce {
    fn update(&mut self, points: &[Vec4], execution: &Execution) -> Result<(), DomainTooLarge> {
        self.len = points.len();
        self.entries.resize(self.len);
        for (k, row) in self.entries.all_rows_mut().iter_mut().enumerate() {
            *row = k as u32;
        }
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
        self.len.div_ceil(BLOCK)
    }

    fn partition_len(&self, partition: usize) -> usize {
        self.block(partition).len()
    }

    fn next_cell(&self, partition: usize, from: usize) -> Option<(IVec3, &[u32])> {
        let rows = &self.block(partition)[from..];
        (!rows.is_empty()).then_some((IVec3::ZERO, rows))
    }

    fn entries(&self) -> &Entries {
        &self.entries
    }

    fn runs(&self, _: IVec3, out: &mut Vec<Run>) {
        out.push(Run {
            start: 0,
            len: self.len as u32,
        });
    }

    fn bytes(&self) -> usize {
        self.entries.bytes()
    }
}
