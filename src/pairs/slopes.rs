//! Slopes of the kernel at the pairs of a step, kept from the density pass for the passes that follow.
//!
//! A square root and a division in every lane are a third of a force pass. Positions stay as they are from the density
//! pass to the end of the step, so that pass, which has the roots anyway, writes the slopes down, and the others read 4
//! bytes per pair. In a stand-alone loop over 130 000 particles (31 neighbours, ns per particle on one thread;
//! computed, slopes kept, gradients kept): force 68, 45, 54; Dρ/Dt 82, 60, 59. A pass that calculates them anyway
//! writes slopes for nothing that could be measured and gradients for 20; the density pass, which has the roots but
//! divides for this alone, takes 15 more. Gradients would spare the positions, too, but are three times as much to
//! read.

use std::ops::Range;

use bevy_ecs::prelude::*;

use crate::{
    kernel::Kernel,
    neighbours::NeighbourLists,
    simd::{LANES, Lanes, Simd},
    state::CHUNK,
};

/// Ages of what slopes are computed from.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Generations {
    /// Of the columns.
    pub(super) rows: u64,
    /// Of the fluid's lists.
    pub(super) lists: u64,
}

/// Slopes of the kernel ([`Kernel::slope`], m⁻¹) of all pairs at the positions of the step, row after row in the order
/// of the lists of the fluid, filled up to whole vectors. Absent where neighbours are recomputed.
#[derive(Resource, Debug, Default)]
pub struct PairSlopes {
    /// By chunk of rows.
    chunks: Vec<Vec<Lanes>>,
    /// Generations of the columns and of the lists that they belong to.
    filled_at: Option<Generations>,
}

impl PairSlopes {
    /// The slopes, if they belong to these columns and lists.
    pub(super) fn at(&self, generations: Generations) -> Option<&Self> {
        (self.filled_at == Some(generations)).then_some(self)
    }

    /// Those of the chunk that begins with row `first`.
    pub(super) fn chunk(&self, first: usize) -> Option<&[Lanes]> {
        self.chunks.get(first / CHUNK).map(Vec::as_slice)
    }

    /// A place for the chunks of so many rows, to be filled.
    pub(super) fn chunks_to_fill(
        &mut self,
        rows: usize,
        generations: Generations,
    ) -> &mut [Vec<Lanes>] {
        self.chunks.resize_with(rows.div_ceil(CHUNK), Vec::new);
        self.filled_at = Some(generations);
        &mut self.chunks
    }
}

/// Makes room for the slopes of `rows`.
pub(super) fn make_room(chunk: &mut Vec<Lanes>, fluid: &NeighbourLists, rows: Range<usize>) {
    let of_row = |row| fluid.of(row).len().div_ceil(LANES);
    let len = rows.map(of_row).sum::<usize>();
    if chunk.capacity() < len {
        // A little more, so that what grows step by step is not moved in every one.
        chunk.reserve_exact(len + len / 8 - chunk.len());
    }
    chunk.resize(len, Lanes::default());
}

/// Where a loop over pairs takes their slopes from, vector by vector.
pub(super) trait Slopes {
    /// Whether they are there without distances.
    const KNOWN: bool = false;

    /// Of the next eight pairs.
    fn next<S: Simd>(&mut self, simd: S, kernel: &Kernel, distance_squared: S::F) -> S::F;
}

/// From the distances.
pub(super) struct Computed;

impl Slopes for Computed {
    #[inline(always)]
    fn next<S: Simd>(&mut self, simd: S, kernel: &Kernel, distance_squared: S::F) -> S::F {
        kernel.slope(simd, distance_squared)
    }
}

/// From memory.
pub(super) struct Known<'a>(pub std::slice::Iter<'a, Lanes>);

impl Slopes for Known<'_> {
    const KNOWN: bool = true;

    #[inline(always)]
    fn next<S: Simd>(&mut self, simd: S, _: &Kernel, _: S::F) -> S::F {
        let next = self.0.next();
        debug_assert!(next.is_some(), "there are slopes for every pair");
        next.map_or(simd.splat(0.0), |slopes| simd.load(slopes))
    }
}

/// From the distances, into memory.
pub(super) struct Kept<'a>(pub std::slice::IterMut<'a, Lanes>);

impl Slopes for Kept<'_> {
    #[inline(always)]
    fn next<S: Simd>(&mut self, simd: S, kernel: &Kernel, distance_squared: S::F) -> S::F {
        let slope = kernel.slope(simd, distance_squared);
        if let Some(slopes) = self.0.next() {
            simd.store(slope, slopes);
        }
        slope
    }
}
