//! Rows sorted by cell, with a copy of their positions.
//!
//! A cell with eight points has about 216 candidates around it, so a query would gather each position 27 times through
//! its row. Instead, positions are copied once into cell order (12 bytes per entry), and candidates are loaded as
//! whole vectors.
//!
//! Positions and rows are stored as columns in blocks: all x, then y, z and rows. A dense structure has one block, so
//! that adjacent cells form one run. Compact hashing has one block per used cell; contiguous cells made moving points
//! between cells a third faster and left the query unchanged.
//!
//! Sorting the rows themselves in every step would avoid the copy, but moving an entity's row costs 400 ns
//! (`reorder.rs`), thirty times the copy.

use std::ops::{Deref, DerefMut};

use bytemuck::{Pod, Zeroable};
use glam::Vec4;
use rayon::prelude::*;

pub use crate::simd::Run;
use crate::{
    simd::{CANDIDATE_ALIGNMENT, prefetch},
    state::{CHUNK, Execution},
};

/// Rows in cell order.
#[derive(Debug, Default, Clone)]
pub struct Entries {
    /// Blocks of four columns: positions as bit patterns of `f32`, and rows. Rows alone if `pitch` is 0. Followed by
    /// [`PADDING`].
    pub(super) words: Words,
    /// Length of a column \[entries].
    pub(super) pitch: usize,
}

/// Words behind the last entry, so that a whole vector can be read from any entry.
pub(super) const PADDING: usize = CANDIDATE_ALIGNMENT;

/// Marks what does not exist: an entry without a point, a block without an owner, a hash value without a used cell.
pub(super) const NONE: u32 = u32::MAX;

/// A cache line.
#[derive(Debug, Clone, Copy, Pod, Zeroable)]
#[repr(C, align(64))]
struct Line([u32; WORDS_PER_LINE]);

const WORDS_PER_LINE: usize = 16;

/// Prefetches a block of [`Words`].
#[inline(always)]
pub(super) fn prefetch_block(block: &[u32]) {
    block.iter().step_by(WORDS_PER_LINE).for_each(prefetch);
}

/// Words aligned to cache lines, so that a vector of a block's column touches one line instead of two.
#[derive(Debug, Default, Clone)]
pub(super) struct Words {
    lines: Vec<Line>,
    len: usize,
}

impl Words {
    /// Sets the number of words; new ones are [`NONE`].
    pub(super) fn resize(&mut self, len: usize) {
        let lines = len.div_ceil(WORDS_PER_LINE);
        if self.lines.capacity() < lines {
            // Reserves an eighth more, instead of doubling.
            self.lines
                .reserve_exact(lines + lines / 8 - self.lines.len());
        }
        self.lines.resize(lines, Line([NONE; WORDS_PER_LINE]));
        let before = std::mem::replace(&mut self.len, len);
        if before < len {
            // The rest of the former last line.
            let end = len.min(before.next_multiple_of(WORDS_PER_LINE));
            self[before..end].fill(NONE);
        }
    }

    /// Memory held \[bytes].
    fn bytes(&self) -> usize {
        self.lines.capacity() * size_of::<Line>()
    }
}

impl Deref for Words {
    type Target = [u32];

    #[inline(always)]
    fn deref(&self) -> &[u32] {
        &bytemuck::cast_slice(&self.lines)[..self.len]
    }
}

impl DerefMut for Words {
    #[inline(always)]
    fn deref_mut(&mut self) -> &mut [u32] {
        &mut bytemuck::cast_slice_mut(&mut self.lines)[..self.len]
    }
}

impl Entries {
    /// The rows of a run.
    #[inline(always)]
    pub(crate) fn rows(&self, run: Run) -> &[u32] {
        let start = run.start as usize + 3 * self.pitch;
        &self.words[start..start + run.len as usize]
    }

    /// Whether positions are stored.
    #[inline(always)]
    pub(crate) fn with_positions(&self) -> bool {
        self.pitch > 0
    }

    /// The blocks and the length of their columns, for vectorised loops.
    #[inline(always)]
    pub(crate) fn blocks(&self) -> (&[u32], usize) {
        (&self.words, self.pitch)
    }

    /// Sets the length of a single block with positions.
    pub(super) fn resize(&mut self, len: usize) {
        self.pitch = len;
        self.words.resize(4 * len + PADDING);
    }

    /// The rows of a single block.
    pub(super) fn all_rows(&self) -> &[u32] {
        &self.words[3 * self.pitch..4 * self.pitch]
    }

    /// The rows of a single block, to be written.
    pub(super) fn all_rows_mut(&mut self) -> &mut [u32] {
        &mut self.words[3 * self.pitch..4 * self.pitch]
    }

    /// Copies the positions of all rows of a single block.
    pub(super) fn copy_positions(&mut self, points: &[Vec4], execution: &Execution) {
        let (x, rest) = self.words.split_at_mut(self.pitch);
        let (y, rest) = rest.split_at_mut(self.pitch);
        let (z, rest) = rest.split_at_mut(self.pitch);
        let rows = &rest[..self.pitch];
        execution.install(|| {
            x.par_chunks_mut(CHUNK)
                .zip(y.par_chunks_mut(CHUNK))
                .zip(z.par_chunks_mut(CHUNK))
                .zip(rows.par_chunks(CHUNK))
                .for_each(|(((x, y), z), rows)| {
                    for (((x, y), z), &row) in x.iter_mut().zip(y).zip(z).zip(rows) {
                        if let Some(point) = points.get(row as usize) {
                            let bits = point.to_array().map(f32::to_bits);
                            [*x, *y, *z, _] = bits;
                        }
                    }
                });
        });
    }

    /// Memory held \[bytes].
    pub(super) fn bytes(&self) -> usize {
        self.words.bytes()
    }
}
