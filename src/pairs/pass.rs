//! What a pass over the neighbours says: what one particle adds up, eight neighbours at a time.

use glam::Vec4;

use crate::simd::Simd;

/// What a particle sums over its neighbours. Mark every method `#[inline(always)]`.
pub trait PairSum: Copy + Sync {
    /// Values of the particle itself and its partial sums, in lanes.
    type Sums<S: Simd>;
    /// Result for a row.
    type Output: Send;
    /// Whether it sums over fluid neighbours.
    const FLUID: bool = true;
    /// Whether it sums over boundary neighbours. At the positions of the step their sums are known
    /// ([`BoundarySums`](crate::boundary::sums::BoundarySums)).
    const BOUNDARY: bool = false;
    /// Whether it passes over rows without boundary neighbours; their results are left as they are. Gradient factors
    /// that are stored row after row cannot be used then.
    const BESIDE_BOUNDARY: bool = false;
    /// Whether it needs the number of neighbours.
    const COUNTS: bool = false;
    /// Whether the pass needs only the gradient factors of a pair. If these are stored, positions are not loaded, and
    /// the other fields of a [`Pair`] are zero, but for rows that [reach across](super::reaches_across) a face.
    const GRADIENTS_ONLY: bool = false;

    /// Called before the first neighbour of row `i`, whose packed position is `own`.
    fn start<S: Simd>(&self, simd: S, i: usize, own: Vec4) -> Self::Sums<S>;
    /// Adds eight fluid neighbours, rows `j`. Lanes without a neighbour have the row of the sentinel, which adds
    /// nothing.
    #[inline(always)]
    fn fluid<S: Simd>(&self, _: S, _pair: &Pair<S>, _j: S::Rows, _: &mut Self::Sums<S>) {}
    /// Adds eight boundary neighbours, rows `j` of the samples; the fourth entries are their volumes \[m³; m² in 2-D].
    #[inline(always)]
    fn boundary<S: Simd>(&self, _: S, _pair: &Pair<S>, _j: S::Rows, _: &mut Self::Sums<S>) {}
    /// Called after the last neighbour. `neighbours` is their number, fluid and boundary, if the pass counts them.
    fn finish<S: Simd>(&self, simd: S, neighbours: usize, sums: Self::Sums<S>) -> Self::Output;
}

/// Two sums in one pass.
impl<A: PairSum, B: PairSum> PairSum for (A, B) {
    type Sums<S: Simd> = (A::Sums<S>, B::Sums<S>);
    type Output = (A::Output, B::Output);
    const FLUID: bool = A::FLUID || B::FLUID;
    const BOUNDARY: bool = A::BOUNDARY || B::BOUNDARY;
    const COUNTS: bool = A::COUNTS || B::COUNTS;
    const GRADIENTS_ONLY: bool = A::GRADIENTS_ONLY && B::GRADIENTS_ONLY;

    #[inline(always)]
    fn start<S: Simd>(&self, simd: S, i: usize, own: Vec4) -> Self::Sums<S> {
        (self.0.start(simd, i, own), self.1.start(simd, i, own))
    }

    #[inline(always)]
    fn fluid<S: Simd>(&self, simd: S, pair: &Pair<S>, j: S::Rows, sums: &mut Self::Sums<S>) {
        // A pass that wants none of them must not get what the other wants.
        if A::FLUID {
            self.0.fluid(simd, pair, j, &mut sums.0);
        }
        if B::FLUID {
            self.1.fluid(simd, pair, j, &mut sums.1);
        }
    }

    #[inline(always)]
    fn boundary<S: Simd>(&self, simd: S, pair: &Pair<S>, j: S::Rows, sums: &mut Self::Sums<S>) {
        if A::BOUNDARY {
            self.0.boundary(simd, pair, j, &mut sums.0);
        }
        if B::BOUNDARY {
            self.1.boundary(simd, pair, j, &mut sums.1);
        }
    }

    #[inline(always)]
    fn finish<S: Simd>(&self, simd: S, neighbours: usize, sums: Self::Sums<S>) -> Self::Output {
        (
            self.0.finish(simd, neighbours, sums.0),
            self.1.finish(simd, neighbours, sums.1),
        )
    }
}

/// A particle and eight neighbours.
#[derive(Clone, Copy)]
pub struct Pair<S: Simd> {
    /// `x_i − x_j` \[m].
    pub x_ij: [S::F; 3],
    /// Square of the distance \[m²].
    pub r2: S::F,
    /// The neighbours' packed fourth entries.
    pub packed_j: S::F,
    /// Factor of `x_ij` in the kernel gradient ([`Kernel::grad_factor`](crate::kernel::Kernel::grad_factor)) \[m⁻¹].
    pub grad_factor: S::F,
}

/// A vector in all lanes.
#[inline(always)]
pub fn broadcast<S: Simd>(simd: S, point: Vec4) -> [S::F; 3] {
    [
        simd.splat(point.x),
        simd.splat(point.y),
        simd.splat(point.z),
    ]
}

/// `own` minus the vectors of eight rows, and the rows' fourth entries.
#[inline(always)]
pub fn difference<S: Simd>(
    simd: S,
    own: [S::F; 3],
    vectors: &[Vec4],
    rows: S::Rows,
) -> ([S::F; 3], S::F) {
    let [x, y, z, fourth] = simd.gather(vectors, rows);
    let difference = [
        simd.sub(own[0], x),
        simd.sub(own[1], y),
        simd.sub(own[2], z),
    ];
    (difference, fourth)
}

/// Scalar product.
#[inline(always)]
pub fn dot<S: Simd>(simd: S, a: [S::F; 3], b: [S::F; 3]) -> S::F {
    simd.mul_add(a[2], b[2], simd.mul_add(a[1], b[1], simd.mul(a[0], b[0])))
}

/// `sum += factor · vector`.
#[inline(always)]
pub fn accumulate<S: Simd>(simd: S, sum: &mut [S::F; 3], factor: S::F, vector: [S::F; 3]) {
    for (sum, component) in sum.iter_mut().zip(vector) {
        *sum = simd.mul_add(factor, component, *sum);
    }
}
