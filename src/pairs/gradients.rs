//! Gradient factors of the kernel for all pairs of a step, stored by the density pass for the following passes.
//!
//! A square root and a division in every lane take a third of a force pass. Positions do not change between the density
//! pass and the end of the step. So the density pass, which computes the roots anyway, stores the factors, and the
//! other passes read 4 bytes per pair. In a stand-alone loop over 130 000 particles (31 neighbours, ns per particle on
//! one thread; computed, factors stored, gradients stored): force 68, 45, 54; Dρ/Dt 82, 60, 59. Storing costs a pass
//! that computes the factors anyway nothing measurable, and 20 for gradients; the density pass, which divides only for
//! this, takes 15 more. Gradients would make loading positions unnecessary, but are three times as much data.

use std::ops::Range;

use bevy_ecs::prelude::*;

use crate::{
    kernel::Kernel,
    neighbours::NeighbourLists,
    simd::{LANES, Lanes, Simd},
    state::CHUNK,
};

/// Ages of the inputs of gradient factors.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Generations {
    /// Of the columns.
    pub(super) rows: u64,
    /// Of the fluid's lists.
    pub(super) lists: u64,
}

/// Gradient factors ([`Kernel::grad_factor`], m⁻¹) of all pairs at the positions of the step, row after row in the
/// order of the fluid's lists, each padded to whole vectors. The resource does not exist if neighbours are recomputed.
#[derive(Resource, Debug, Default)]
pub struct KernelGradients {
    /// By chunk of rows.
    chunks: Vec<Vec<Lanes>>,
    /// Generations of the columns and of the lists that they belong to.
    filled_at: Option<Generations>,
}

impl KernelGradients {
    /// Frees the memory of all factors.
    pub(crate) fn free(&mut self) {
        *self = Self::default();
    }

    /// The factors, if they belong to these columns and lists.
    pub(super) fn at(&self, generations: Generations) -> Option<&Self> {
        (self.filled_at == Some(generations)).then_some(self)
    }

    /// The factors of the chunk that begins with row `first`.
    pub(super) fn chunk(&self, first: usize) -> Option<&[Lanes]> {
        self.chunks.get(first / CHUNK).map(Vec::as_slice)
    }

    /// Buffers for the chunks of `rows` rows, to be filled.
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

/// Resizes the buffer of a chunk for the factors of `rows`.
pub(super) fn make_room(chunk: &mut Vec<Lanes>, fluid: &NeighbourLists, rows: Range<usize>) {
    let of_row = |row| fluid.of(row).len().div_ceil(LANES);
    let len = rows.map(of_row).sum::<usize>();
    if chunk.capacity() < len {
        // A reserve, so that a slowly growing buffer is not moved in every step.
        chunk.reserve_exact(len + len / 32 - chunk.len());
    }
    chunk.resize(len, Lanes::default());
}

/// Source of the gradient factors of a loop over pairs, vector by vector.
pub(super) trait GradFactors {
    /// Whether the factors are available without distances.
    const KNOWN: bool = false;

    /// The factors of the next eight pairs.
    fn next<S: Simd>(&mut self, simd: S, kernel: &Kernel, distance_squared: S::F) -> S::F;
}

/// Computes the factors from the distances.
pub(super) struct Computed;

impl GradFactors for Computed {
    #[inline(always)]
    fn next<S: Simd>(&mut self, simd: S, kernel: &Kernel, distance_squared: S::F) -> S::F {
        kernel.grad_factor(simd, distance_squared)
    }
}

/// Reads the factors from memory.
pub(super) struct Known<'a>(pub std::slice::Iter<'a, Lanes>);

impl GradFactors for Known<'_> {
    const KNOWN: bool = true;

    #[inline(always)]
    fn next<S: Simd>(&mut self, simd: S, _: &Kernel, _: S::F) -> S::F {
        let next = self.0.next();
        debug_assert!(next.is_some(), "every pair has a factor");
        next.map_or(simd.splat(0.0), |grad_factors| simd.load(grad_factors))
    }
}

/// Computes the factors from the distances and stores them.
pub(super) struct Kept<'a>(pub std::slice::IterMut<'a, Lanes>);

impl GradFactors for Kept<'_> {
    #[inline(always)]
    fn next<S: Simd>(&mut self, simd: S, kernel: &Kernel, distance_squared: S::F) -> S::F {
        let grad_factor = kernel.grad_factor(simd, distance_squared);
        if let Some(grad_factors) = self.0.next() {
            simd.store(grad_factor, grad_factors);
        }
        grad_factor
    }
}
