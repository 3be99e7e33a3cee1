//! Inserts points into simple used cells of one chunk of blocks.

use glam::Vec4;

use super::{
    super::entries::{NONE, prefetch_block},
    departed::Departed,
    used_cell::UsedCell,
};
use crate::simd::{Simd, Vectorised, prefetch};

/// A chunk of blocks that receives points.
pub(super) struct Arrivals<'a> {
    pub(super) cells: &'a [UsedCell],
    pub(super) points: &'a [Vec4],
    /// Index of the chunk's first block.
    pub(super) first: usize,
    pub(super) words: &'a mut [u32],
    pub(super) words_per_block: usize,
    pub(super) departed: &'a mut Vec<Departed>,
}

impl Arrivals<'_> {
    /// The block that receives a point, if it belongs to this chunk.
    #[inline(always)]
    fn block(&mut self, departed: &Departed) -> Option<&mut [u32]> {
        let start = (departed.block as usize).checked_sub(self.first)? * self.words_per_block;
        self.words.get_mut(start..start + self.words_per_block)
    }

    /// Inserts a point if its destination is a simple used cell of this chunk with a free entry.
    #[inline(always)]
    fn insert<S: Simd>(&mut self, simd: S, departed: &Departed) -> bool {
        let (cells, points) = (self.cells, self.points);
        let Some(block) = self.block(departed) else {
            return false;
        };
        let used = &cells[departed.handle as usize];
        let point = points[departed.row as usize];
        // The used cell may have got another primary cell in the meantime.
        let has_cell = used.cell == departed.to && used.is_simple();
        let is_in = has_cell && insert_by_row(simd, block, departed.row, point);
        if is_in {
            used.set_len(used.len.get() + 1);
        }
        is_in
    }
}

impl Vectorised for Arrivals<'_> {
    type Output = ();

    /// Inserts the points that fit, and keeps the others in the list.
    #[inline(always)]
    fn run<S: Simd>(mut self, simd: S) {
        let mut departed = std::mem::take(self.departed);
        for point in &departed {
            let (cells, points) = (self.cells, self.points);
            if let Some(block) = self.block(point) {
                prefetch_block(block);
                prefetch(&points[point.row as usize]);
                prefetch(&cells[point.handle as usize]);
            }
        }
        // A loop instead of `retain`: a closure would not be compiled for the instruction set.
        let mut kept = 0;
        for k in 0..departed.len() {
            let point = departed[k];
            if !self.insert(simd, &point) {
                departed[kept] = point;
                kept += 1;
            }
        }
        departed.truncate(kept);
        *self.departed = departed;
    }
}

/// Inserts a point into a block of one spatial cell such that rows stay in ascending order. Does nothing if the block
/// is empty or full.
#[inline(always)]
fn insert_by_row<S: Simd>(simd: S, block: &mut [u32], row: u32, point: Vec4) -> bool {
    let rows = &block[3 * block.len() / 4..];
    if rows[0] == NONE || rows[rows.len() - 1] != NONE {
        return false;
    }
    // Rows ascend; `NONE` is the largest.
    let place: usize = rows.iter().map(|&other| usize::from(other < row)).sum();
    let [x, y, z, _] = point.to_array().map(f32::to_bits);
    simd.insert(block, place, [x, y, z, row]);
    true
}
