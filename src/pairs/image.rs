//! Differences of positions by the nearest image, in scenes with periodic axes.
//!
//! Only rows near a face have neighbours beyond it. All others, and all rows of scenes without periodic axes, leave the
//! differences as they are.

use glam::{Vec3, Vec4};

use crate::{scene::Period, simd::Simd};

/// Half a step moves no particle further than half the support radius, so that a pair of a list is nearer than two. A
/// row further than this from every face has no neighbour beyond one, nor has one that was predicted from there \[h].
const REACH: f32 = 2.0;

/// Added and subtracted, it rounds to a whole number: 1.5 times 2²³.
const ROUNDING: f32 = 12_582_912.0;

/// Whether a row at `own` may have neighbours beyond a face. Its pairs then have positions in any case.
#[inline(always)]
pub fn reaches_across(period: &Period, support_radius: f32, own: Vec4) -> bool {
    period.is_any() && period.is_near_face(own.truncate(), REACH * support_radius)
}

/// The space around a row.
pub(super) trait Space<S: Simd> {
    /// Whether a neighbour may be nearer as an image.
    const REPEATS: bool;

    /// The shortest of the differences between a point and the images of another.
    fn nearest(&self, simd: S, difference: [S::F; 3]) -> [S::F; 3];
}

/// Space in which no neighbour is an image.
pub(super) struct Open;

impl<S: Simd> Space<S> for Open {
    const REPEATS: bool = false;

    #[inline(always)]
    fn nearest(&self, _: S, difference: [S::F; 3]) -> [S::F; 3] {
        difference
    }
}

/// Periods in lanes.
#[derive(Clone, Copy)]
pub(super) struct Image<S: Simd> {
    /// Periods per length \[m⁻¹].
    inverse: [S::F; 3],
    /// Minus the length of a period \[m].
    minus_length: [S::F; 3],
    rounding: S::F,
    one: S::F,
    minus_one: S::F,
}

impl<S: Simd> Image<S> {
    /// Of a row at `own`; none where no neighbour is an image.
    #[inline(always)]
    pub(super) fn of(simd: S, period: &Period, support_radius: f32, own: Vec4) -> Option<Self> {
        if !reaches_across(period, support_radius, own) {
            return None;
        }
        let lanes = |of: Vec3| of.to_array().map(|x| simd.splat(x));
        Some(Self {
            inverse: lanes(period.inverse),
            minus_length: lanes(-period.length),
            rounding: simd.splat(ROUNDING),
            one: simd.splat(1.0),
            minus_one: simd.splat(-1.0),
        })
    }
}

impl<S: Simd> Space<S> for Image<S> {
    const REPEATS: bool = true;

    /// Both points are in the box that repeats, or less than half a period beyond it; to the sentinel it is as far as
    /// before.
    #[inline(always)]
    fn nearest(&self, simd: S, mut difference: [S::F; 3]) -> [S::F; 3] {
        for (axis, x) in difference.iter_mut().enumerate() {
            let periods = simd.mul(*x, self.inverse[axis]);
            let periods = simd.sub(simd.add(periods, self.rounding), self.rounding);
            let periods = simd.max(simd.min(periods, self.one), self.minus_one);
            *x = simd.mul_add(periods, self.minus_length[axis], *x);
        }
        difference
    }
}
