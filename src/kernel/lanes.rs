//! The kernel at eight distances at a time.
//!
//! The function is selected once per eight pairs, outside their arithmetic. The branch is predicted, because the
//! selection is the same throughout a run.
//!
//! No closures and no `map` of arrays: the compiler does not always inline these, and a function of its own has not the
//! instruction set of its caller, so that every operation is a call through memory. The quintic spline was six times as
//! slow.

use super::{Kernel, TINY};
use crate::{scene::KernelFunction, simd::Simd};

/// r, shared by both functions, so that a pass which needs both computes one root.
#[inline(always)]
fn radius<S: Simd>(simd: S, distance_squared: S::F) -> S::F {
    // With the arguments in this order NaN is kept, and becomes zero in W.
    simd.sqrt(simd.max(simd.splat(TINY), distance_squared))
}

impl Kernel {
    /// `W/σ` at eight squared distances \[m²].
    #[inline(always)]
    pub fn w<S: Simd>(&self, simd: S, distance_squared: S::F) -> S::F {
        let r = radius(simd, distance_squared);
        match self.function {
            KernelFunction::CubicSpline => {
                let (a, b) = (self.hat(simd, 1.0, r), self.hat(simd, 2.0, r));
                let a_cubed = simd.mul(simd.mul(a, a), a);
                let b_squared = simd.mul(b, b);
                simd.sub(simd.add(a_cubed, a_cubed), simd.mul(b_squared, b))
            }
            KernelFunction::WendlandC2 => {
                let a = self.hat(simd, 1.0, r);
                simd.mul(fourth(simd, a), one_and(simd, 4.0, a))
            }
            KernelFunction::WendlandC4 => {
                let a = self.hat(simd, 1.0, r);
                let square = simd.mul(a, a);
                let q = simd.sub(simd.splat(1.0), a);
                let rest = simd.mul_add(q, simd.splat(35.0 / 3.0), simd.splat(6.0));
                let rest = simd.mul_add(rest, q, simd.splat(1.0));
                simd.mul(simd.mul(fourth(simd, a), square), rest)
            }
            KernelFunction::QuinticSpline => {
                let a = fifth(simd, self.hat(simd, 1.0, r));
                let b = fifth(simd, self.hat(simd, 1.5, r));
                let c = fifth(simd, self.hat(simd, 3.0, r));
                let sum = simd.mul(c, simd.splat(5.0 / 22.0));
                let sum = simd.mul_add(b, simd.splat(-64.0 / 22.0), sum);
                simd.mul_add(a, simd.splat(81.0 / 22.0), sum)
            }
        }
    }

    /// The gradient factor f \[m⁻¹] at eight squared distances \[m²], with ∇W = f x_ij times
    /// [`gradient_scale`](Self::gradient_scale): `(b² − a²)/r` for the cubic spline.
    #[inline(always)]
    pub fn grad_factor<S: Simd>(&self, simd: S, distance_squared: S::F) -> S::F {
        let r = radius(simd, distance_squared);
        match self.function {
            KernelFunction::CubicSpline => {
                let (a, b) = (self.hat(simd, 1.0, r), self.hat(simd, 2.0, r));
                simd.div(difference_of_squares(simd, b, a), r)
            }
            KernelFunction::WendlandC2 => {
                let a = self.hat(simd, 1.0, r);
                let square = simd.mul(a, a);
                simd.mul(square, simd.mul(a, simd.splat(-self.inverse_radius)))
            }
            KernelFunction::WendlandC4 => {
                let a = self.hat(simd, 1.0, r);
                let factor = simd.mul(one_and(simd, 5.0, a), simd.splat(-self.inverse_radius));
                simd.mul(fourth(simd, a), simd.mul(a, factor))
            }
            KernelFunction::QuinticSpline => {
                let (a, b) = (self.hat(simd, 1.0, r), self.hat(simd, 1.5, r));
                let c = self.hat(simd, 3.0, r);
                let sum = simd.mul(difference_of_fourths(simd, b, c), simd.splat(5.0));
                let sum = simd.mul_add(difference_of_fourths(simd, b, a), simd.splat(27.0), sum);
                simd.div(sum, r)
            }
        }
    }

    /// `(1 − k q)₊`.
    #[inline(always)]
    fn hat<S: Simd>(&self, simd: S, knot: f32, r: S::F) -> S::F {
        let line = simd.mul_add(r, simd.splat(-knot * self.inverse_radius), simd.splat(1.0));
        simd.max(line, simd.splat(0.0))
    }
}

/// `1 + k q` within the support, from a = (1 − q)₊. Beyond it, where an absent neighbour is, q itself may be too large
/// for a factor that meets a zero.
#[inline(always)]
fn one_and<S: Simd>(simd: S, k: f32, a: S::F) -> S::F {
    simd.mul_add(a, simd.splat(-k), simd.splat(1.0 + k))
}

/// x⁴.
#[inline(always)]
fn fourth<S: Simd>(simd: S, x: S::F) -> S::F {
    let square = simd.mul(x, x);
    simd.mul(square, square)
}

/// x⁵.
#[inline(always)]
fn fifth<S: Simd>(simd: S, x: S::F) -> S::F {
    simd.mul(fourth(simd, x), x)
}

/// `x⁴ − y⁴`, from differences that are exact where the powers would cancel.
#[inline(always)]
fn difference_of_fourths<S: Simd>(simd: S, x: S::F, y: S::F) -> S::F {
    let sum = simd.mul_add(x, x, simd.mul(y, y));
    simd.mul(difference_of_squares(simd, x, y), sum)
}

/// `x² − y²`.
#[inline(always)]
fn difference_of_squares<S: Simd>(simd: S, x: S::F, y: S::F) -> S::F {
    simd.mul(simd.sub(x, y), simd.add(x, y))
}
