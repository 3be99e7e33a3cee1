//! The volume that a boundary particle stands for: `V_b = 1/Σ_k W_bk` over the boundary, itself included (Akinci et al.
//! 2012, eq. 4). It is smaller where the sampling is denser, so edges and overlapping shapes push no harder.

use glam::Vec4;

use crate::{
    execution::Execution,
    index::SpatialIndex,
    kernel::CubicSpline,
    neighbours::Search,
    pairs::{self, PairSum, Source, broadcast, separation},
    scene::Scene,
    simd::Simd,
};

/// Volumes [m³; m² in 2-D] of the particles of `index`, at `packed` without its sentinel.
pub fn volumes(
    scene: &Scene,
    index: &dyn SpatialIndex,
    packed: &[Vec4],
    execution: &Execution,
) -> Vec<f32> {
    let pass = BoundaryVolumeSum {
        kernel: CubicSpline::new(scene.dimension, scene.support_radius()),
        packed,
    };
    let points = &packed[..packed.len() - 1];
    let search = Search {
        of: index,
        points,
        among: index,
        among_points: points,
        same: true,
    };
    let mut volumes = vec![0.0; points.len()];
    pairs::sum(
        &pass,
        Source::OnTheSpot(search, None),
        &mut volumes,
        execution,
    );
    volumes
}

#[derive(Clone, Copy)]
struct BoundaryVolumeSum<'a> {
    kernel: CubicSpline,
    packed: &'a [Vec4],
}

impl PairSum for BoundaryVolumeSum<'_> {
    type Sums<S: Simd> = ([S::F; 3], S::F);
    type Output = f32;

    #[inline(always)]
    fn start<S: Simd>(&self, simd: S, i: usize) -> Self::Sums<S> {
        (broadcast(simd, self.packed[i]), simd.splat(0.0))
    }

    #[inline(always)]
    fn fluid<S: Simd>(&self, simd: S, j: S::Rows, (own, sum): &mut Self::Sums<S>) {
        let (_, distance, _) = separation(simd, *own, self.packed, j);
        *sum = simd.add(*sum, self.kernel.shape(simd, distance));
    }

    #[inline(always)]
    fn boundary<S: Simd>(&self, _: S, _: S::Rows, _: &mut Self::Sums<S>) {}

    #[inline(always)]
    fn finish<S: Simd>(&self, simd: S, _: usize, (_, sum): Self::Sums<S>) -> f32 {
        // The shape of the kernel at the particle itself is 1.
        1.0 / (self.kernel.normalisation * (1.0 + simd.sum(sum)))
    }
}
