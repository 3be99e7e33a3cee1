//! Those who come to a simple used cell of the same chunk of blocks as they left.

use glam::Vec4;

use super::{
    super::entries::{NOBODY, prefetch_block},
    movers::Mover,
    used_cell::UsedCell,
};
use crate::simd::{Simd, Vectorised, prefetch};

/// A chunk of blocks that points come to.
pub(super) struct Arrivals<'a> {
    pub(super) cells: &'a [UsedCell],
    pub(super) points: &'a [Vec4],
    /// The first of the blocks.
    pub(super) first: usize,
    pub(super) words: &'a mut [u32],
    pub(super) words_a_block: usize,
    pub(super) movers: &'a mut Vec<Mover>,
}

impl Arrivals<'_> {
    /// The block that a point comes to, if it is of the chunk.
    #[inline(always)]
    fn block(&mut self, mover: &Mover) -> Option<&mut [u32]> {
        let start = (mover.block as usize).checked_sub(self.first)? * self.words_a_block;
        self.words.get_mut(start..start + self.words_a_block)
    }

    /// Puts a point in if it comes to a simple used cell of the chunk that has room.
    #[inline(always)]
    fn put_in<S: Simd>(&mut self, simd: S, mover: &Mover) -> bool {
        let (cells, points) = (self.cells, self.points);
        let Some(block) = self.block(mover) else {
            return false;
        };
        let used = &cells[mover.handle as usize];
        let point = points[mover.row as usize];
        // Another cell may be its first by now.
        let has_cell = used.cell == mover.to && used.is_simple();
        let is_in = has_cell && insert_by_row(simd, block, mover.row, point);
        if is_in {
            used.set_len(used.len.get() + 1);
        }
        is_in
    }
}

impl Vectorised for Arrivals<'_> {
    type Output = ();

    /// Puts in who finds a place, and keeps the others.
    #[inline(always)]
    fn run<S: Simd>(mut self, simd: S) {
        let mut movers = std::mem::take(self.movers);
        for mover in &movers {
            let (cells, points) = (self.cells, self.points);
            if let Some(block) = self.block(mover) {
                prefetch_block(block);
                prefetch(&points[mover.row as usize]);
                prefetch(&cells[mover.handle as usize]);
            }
        }
        // A closure, as that of `retain`, would not be compiled for the instruction set.
        let mut kept = 0;
        for k in 0..movers.len() {
            let mover = movers[k];
            if !self.put_in(simd, &mover) {
                movers[kept] = mover;
                kept += 1;
            }
        }
        movers.truncate(kept);
        *self.movers = movers;
    }
}

/// Adds a point to a block of one spatial cell, so that rows ascend, unless the block is empty or full.
#[inline(always)]
fn insert_by_row<S: Simd>(simd: S, block: &mut [u32], row: u32, point: Vec4) -> bool {
    let rows = &block[3 * block.len() / 4..];
    if rows[0] == NOBODY || rows[rows.len() - 1] != NOBODY {
        return false;
    }
    // Rows ascend, and nobody is the largest.
    let place: usize = rows.iter().map(|&other| usize::from(other < row)).sum();
    let [x, y, z, _] = point.to_array().map(f32::to_bits);
    simd.insert(block, place, [x, y, z, row]);
    true
}
