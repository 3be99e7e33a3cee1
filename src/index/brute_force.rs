//! Every point against every other: the reference that the structures are compared with.

use glam::{IVec3, Vec4};

use super::{Grid, SpatialIndex};
use crate::{execution::Execution, simd::Candidates};

/// Points that one task queries.
const BLOCK: usize = 64;

/// No structure at all.
#[derive(Debug, Clone)]
pub struct BruteForce {
    grid: Grid,
    rows: Vec<u32>,
}

impl BruteForce {
    /// The grid serves its support radius alone.
    pub fn new(grid: Grid) -> Self {
        Self {
            grid,
            rows: Vec::new(),
        }
    }

    fn block(&self, cell: usize) -> &[u32] {
        &self.rows[cell * BLOCK..self.rows.len().min((cell + 1) * BLOCK)]
    }
}

impl SpatialIndex for BruteForce {
    fn update(&mut self, points: &[Vec4], _: &Execution) {
        self.rows.clear();
        self.rows.extend(0..points.len() as u32);
    }

    fn rebuild(&mut self, points: &[Vec4], execution: &Execution) {
        self.update(points, execution);
    }

    fn grid(&self) -> &Grid {
        &self.grid
    }

    fn cells(&self) -> usize {
        self.rows.len().div_ceil(BLOCK)
    }

    fn cell_len(&self, cell: usize) -> usize {
        self.block(cell).len()
    }

    fn group(&self, cell: usize, from: usize) -> Option<(IVec3, &[u32])> {
        let rows = &self.block(cell)[from..];
        (!rows.is_empty()).then_some((IVec3::ZERO, rows))
    }

    fn candidates(&self, _: IVec3, points: &[Vec4], out: &mut Candidates) {
        out.extend(&self.rows, points);
    }

    fn bytes(&self) -> usize {
        self.rows.capacity() * size_of::<u32>()
    }
}
