//! Rows side by side with the other rows of their cell, and a copy of where they are.
//!
//! Around a cell of eight points lie about 216 candidates, so every position would be fetched 27 times by its row. It is
//! fetched once, into the order of the cells, and candidates are whole vectors from then on. It costs 12 bytes
//! an entry.

use glam::Vec4;

use crate::{
    execution::{CHUNK, Execution},
    simd::CANDIDATE_ALIGNMENT,
};

use rayon::prelude::*;

/// A stretch of entries.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Run {
    /// The first.
    pub start: u32,
    /// How many.
    pub len: u32,
}

/// Rows in the order of their cells.
#[derive(Debug, Default, Clone)]
pub struct Entries {
    /// Rows, [`PADDING`] more than there are entries.
    pub(super) rows: Vec<u32>,
    /// Their positions [m], of the same length; empty in a structure that keeps no copy.
    pub(super) positions: [Vec<f32>; 3],
}

/// Entries behind the last, so that whole vectors can be read from any.
pub(super) const PADDING: usize = CANDIDATE_ALIGNMENT;

/// Rows of entries without a point.
pub(super) const NOBODY: u32 = u32::MAX;

impl Entries {
    /// The rows, and the columns of their positions if the structure keeps them.
    #[inline(always)]
    pub(crate) fn columns(&self) -> (&[u32], Option<[&[f32]; 3]>) {
        let [x, y, z] = &self.positions;
        let copied = x.len() == self.rows.len();
        (&self.rows, copied.then_some([x, y, z]))
    }

    /// Makes room for `len` entries with positions.
    pub(super) fn resize(&mut self, len: usize) {
        self.rows.resize(len + PADDING, NOBODY);
        for column in &mut self.positions {
            column.resize(len + PADDING, f32::INFINITY);
        }
    }

    /// Copies the positions of all rows.
    pub(super) fn copy_positions(&mut self, points: &[Vec4], execution: &Execution) {
        let [x, y, z] = &mut self.positions;
        execution.install(|| {
            x.par_chunks_mut(CHUNK)
                .zip(y.par_chunks_mut(CHUNK))
                .zip(z.par_chunks_mut(CHUNK))
                .zip(self.rows.par_chunks(CHUNK))
                .for_each(|(((x, y), z), rows)| {
                    for (((x, y), z), &row) in x.iter_mut().zip(y).zip(z).zip(rows) {
                        if let Some(point) = points.get(row as usize) {
                            (*x, *y, *z) = (point.x, point.y, point.z);
                        }
                    }
                });
        });
    }

    /// Memory held [bytes].
    pub(super) fn bytes(&self) -> usize {
        let positions: usize = self.positions.iter().map(Vec::capacity).sum();
        (self.rows.capacity() + positions) * size_of::<u32>()
    }
}
