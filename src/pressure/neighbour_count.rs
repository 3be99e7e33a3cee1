//! Counts of neighbours, fluid and boundary, by row.

use bevy_ecs::prelude::*;
use glam::Vec4;

use crate::{
    pairs::{Pair, PairSum},
    simd::Simd,
    state::Material,
};

/// Number of neighbours, fluid and boundary.
#[derive(Resource, Debug, Default)]
pub struct NeighbourCounts(pub(super) Vec<u32>);

/// Counts those that are within the support radius, where lists have others, too.
#[derive(Clone, Copy)]
pub(super) struct NeighboursWithin {
    /// Square of the support radius \[m²].
    square: f32,
}

/// Makes a step from 0 to 1 of a difference of squares of distances.
const STEEP: f32 = 1e30;

impl NeighboursWithin {
    /// Counts neighbours within the support radius of this material.
    pub(super) fn new(material: &Material) -> Self {
        let h = material.kernel.support_radius;
        Self { square: h * h }
    }

    #[inline(always)]
    fn add<S: Simd>(self, simd: S, pair: &Pair<S>, sum: &mut S::F) {
        let inside = simd.sub(simd.splat(self.square), pair.r2);
        let inside = simd.max(simd.mul(inside, simd.splat(STEEP)), simd.splat(0.0));
        *sum = simd.add(*sum, simd.min(inside, simd.splat(1.0)));
    }
}

impl PairSum for NeighboursWithin {
    type Sums<S: Simd> = S::F;
    type Output = u32;
    const BOUNDARY: bool = true;

    #[inline(always)]
    fn start<S: Simd>(&self, simd: S, _: usize, _: Vec4) -> S::F {
        simd.splat(0.0)
    }

    #[inline(always)]
    fn fluid<S: Simd>(&self, simd: S, pair: &Pair<S>, _: S::Rows, sum: &mut S::F) {
        self.add(simd, pair, sum);
    }

    #[inline(always)]
    fn boundary<S: Simd>(&self, simd: S, pair: &Pair<S>, _: S::Rows, sum: &mut S::F) {
        self.add(simd, pair, sum);
    }

    #[inline(always)]
    fn finish<S: Simd>(&self, simd: S, _: usize, sum: S::F) -> u32 {
        simd.sum(sum) as u32
    }
}

/// Counts neighbours, fluid and boundary.
#[derive(Clone, Copy)]
pub(super) struct NeighbourCount;

impl PairSum for NeighbourCount {
    type Sums<S: Simd> = ();
    type Output = u32;
    const FLUID: bool = false;
    const COUNTS: bool = true;

    #[inline(always)]
    fn start<S: Simd>(&self, _: S, _: usize, _: Vec4) {}

    #[inline(always)]
    fn finish<S: Simd>(&self, _: S, neighbours: usize, (): ()) -> u32 {
        neighbours as u32
    }
}
