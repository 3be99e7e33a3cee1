//! Rows side by side with the other rows of their cell, and a copy of where they are.
//!
//! Around a cell of eight points lie about 216 candidates, so every position would be fetched 27 times by its row. It
//! is fetched once, into the order of the cells, and candidates are whole vectors from then on. It costs 12 bytes an
//! entry.
//!
//! Positions and rows are columns in blocks: all of x, then of y, z and the rows. A dense structure has one block, so
//! that cells side by side are one run. Compact hashing has a block for every used cell, a structure of arrays per
//! cell: a cell is one stretch of memory and not four. Moving points between cells took a third less time for it; the
//! query did not change beyond the noise.
//!
//! To sort the rows themselves in every step instead would make the copy superfluous, but an entity's row costs 400 ns
//! to move (see `reorder.rs`), thirty times the copy.

use std::ops::{Deref, DerefMut};

use bytemuck::{Pod, Zeroable};
use glam::Vec4;
use rayon::prelude::*;

pub use crate::simd::Run;
use crate::{
    simd::{CANDIDATE_ALIGNMENT, prefetch},
    state::{CHUNK, Execution},
};

/// Rows in the order of their cells.
#[derive(Debug, Default, Clone)]
pub struct Entries {
    /// Blocks of four columns, positions as the bits of `f32`, or rows alone if `pitch` is 0; then [`PADDING`].
    pub(super) words: Words,
    /// Length of a column [entries].
    pub(super) pitch: usize,
}

/// Words behind the last, so that whole vectors can be read from any.
pub(super) const PADDING: usize = CANDIDATE_ALIGNMENT;

/// Rows of entries without a point.
pub(super) const NOBODY: u32 = u32::MAX;

/// A cache line.
#[derive(Debug, Clone, Copy, Pod, Zeroable)]
#[repr(C, align(64))]
struct Line([u32; WORDS_A_LINE]);

const WORDS_A_LINE: usize = 16;

/// Hints that a block of [`Words`] is about to be read.
#[inline(always)]
pub(super) fn prefetch_block(block: &[u32]) {
    block.iter().step_by(WORDS_A_LINE).for_each(prefetch);
}

/// Words that begin with a cache line, so that a vector of a block's column, which is one of 16 words where a cell has
/// eight points, is one line and not two.
#[derive(Debug, Default, Clone)]
pub(super) struct Words {
    lines: Vec<Line>,
    len: usize,
}

impl Words {
    /// Makes them so many; new ones are [`NOBODY`].
    pub(super) fn resize(&mut self, len: usize) {
        let lines = len.div_ceil(WORDS_A_LINE);
        if self.lines.capacity() < lines {
            // An eighth ahead, not twice as much.
            self.lines
                .reserve_exact(lines + lines / 8 - self.lines.len());
        }
        self.lines.resize(lines, Line([NOBODY; WORDS_A_LINE]));
        let before = std::mem::replace(&mut self.len, len);
        if before < len {
            // The rest of a line that was the last.
            let end = len.min(before.next_multiple_of(WORDS_A_LINE));
            self[before..end].fill(NOBODY);
        }
    }

    /// Memory held [bytes].
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

    /// Whether positions are held, too.
    #[inline(always)]
    pub(crate) fn with_positions(&self) -> bool {
        self.pitch > 0
    }

    /// The blocks and the length of their columns, for loops over vectors.
    #[inline(always)]
    pub(crate) fn blocks(&self) -> (&[u32], usize) {
        (&self.words, self.pitch)
    }

    /// One block of `len` entries with positions.
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

    /// Memory held [bytes].
    pub(super) fn bytes(&self) -> usize {
        self.words.bytes()
    }
}
