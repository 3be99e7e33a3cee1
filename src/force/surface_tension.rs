//! Surface tension as pairwise cohesion: `a_i = −(κ/m) Σ_j m (x_i − x_j) W(max(|x_ij|, spacing))` (Becker & Teschner
//! 2007, eq. 14; particles nearer than the spacing attract no more than there). κ in m³/s² (m²/s² in 2-D).

use bevy_ecs::prelude::*;
use glam::{Vec3, Vec4};

use crate::{
    kernel::Kernel,
    pairs::{Pair, PairSum, PairsWithGradients, accumulate},
    scene::SurfaceTension,
    simd::Simd,
    state::{Accelerations, Material, Phase, Product, Stage},
};

/// Surface tension.
pub(crate) const STAGE: Stage = Stage {
    needs: &[
        Product::Columns,
        Product::Index,
        Product::Neighbours,
        Product::Forces,
    ],
    has_own_kernel: true,
    wanted: |scene| scene.fluid.surface_tension != SurfaceTension::None,
    install: |world, scene| {
        if let SurfaceTension::BeckerTeschner { kappa } = scene.fluid.surface_tension {
            world.insert_resource(Cohesion(kappa));
        }
    },
    ..Stage::new("surface_tension", Phase::Forces, |_| {
        apply_surface_tension.into_configs()
    })
};

/// Strength κ \[m³/s²; m²/s² in 2-D] of the scene.
#[derive(Resource, Debug, Clone, Copy)]
pub struct Cohesion(pub(crate) f32);

/// Adds surface tension (phase `Forces`).
pub fn apply_surface_tension(
    mut accelerations: ResMut<Accelerations>,
    cohesion: Res<Cohesion>,
    material: Res<Material>,
    pairs: PairsWithGradients,
) {
    let pass = CohesionSum {
        kernel: pairs.kernel(),
        factor: -cohesion.0 * pairs.kernel().normalisation,
        nearest: material.spacing * material.spacing,
    };
    pairs.add(&pass, &mut accelerations.0);
}

#[derive(Clone, Copy)]
struct CohesionSum<'a> {
    kernel: &'a Kernel,
    /// −κ σ
    factor: f32,
    /// Square of the spacing \[m²].
    nearest: f32,
}

impl PairSum for CohesionSum<'_> {
    type Sums<S: Simd> = [S::F; 3];
    type Output = Vec3;

    #[inline(always)]
    fn start<S: Simd>(&self, simd: S, _: usize, _: Vec4) -> Self::Sums<S> {
        [simd.splat(0.0); 3]
    }

    #[inline(always)]
    fn fluid<S: Simd>(&self, simd: S, pair: &Pair<S>, _: S::Rows, sum: &mut Self::Sums<S>) {
        let distance = simd.max(pair.r2, simd.splat(self.nearest));
        let shape = self.kernel.w(simd, distance);
        accumulate(simd, sum, shape, pair.x_ij);
    }

    #[inline(always)]
    fn finish<S: Simd>(&self, simd: S, _: usize, [x, y, z]: Self::Sums<S>) -> Vec3 {
        self.factor * Vec3::new(simd.sum(x), simd.sum(y), simd.sum(z))
    }
}
