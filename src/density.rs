//! Density (paper eq. 1): `ρ_i = Σ_j m W_ij`, the particle itself included, and `ρ0 Σ_b V_b W_ib` from the boundary
//! (Akinci et al. 2012).

use bevy_ecs::prelude::*;
use glam::Vec4;

use crate::{
    column::Densities,
    kernel::CubicSpline,
    material::Material,
    pairs::{Pair, PairSlopes, PairSum, Pairs},
    simd::Simd,
};

/// Densities at the positions of the step (phase `Density`).
pub fn compute_density(
    mut densities: ResMut<Densities>,
    mut slopes: Option<ResMut<PairSlopes>>,
    pairs: Pairs,
    material: Res<Material>,
) {
    densities.0.resize(pairs.positions().rows(), 0.0);
    let pass = DensitySum::new(&material);
    pairs.sum_and_keep(&pass, &mut densities.0, slopes.as_deref_mut());
}

/// The sum of equation 1, at any positions.
#[derive(Clone, Copy)]
pub struct DensitySum {
    kernel: CubicSpline,
    /// m σ
    fluid_factor: f32,
    /// ρ0 σ
    boundary_factor: f32,
}

impl DensitySum {
    /// Densities of this fluid.
    pub fn new(material: &Material) -> Self {
        Self {
            kernel: material.kernel,
            fluid_factor: material.particle_mass * material.kernel.normalisation,
            boundary_factor: material.rest_density * material.kernel.normalisation,
        }
    }
}

/// The sums over both kinds of neighbours.
pub struct DensitySums<S: Simd> {
    fluid: S::F,
    boundary: S::F,
}

impl PairSum for DensitySum {
    type Sums<S: Simd> = DensitySums<S>;
    type Output = f32;

    #[inline(always)]
    fn start<S: Simd>(&self, simd: S, _: usize, _: Vec4) -> DensitySums<S> {
        DensitySums {
            fluid: simd.splat(0.0),
            boundary: simd.splat(0.0),
        }
    }

    #[inline(always)]
    fn fluid<S: Simd>(&self, simd: S, pair: &Pair<S>, _: S::Rows, sums: &mut DensitySums<S>) {
        sums.fluid = simd.add(sums.fluid, self.kernel.shape(simd, pair.distance));
    }

    #[inline(always)]
    fn boundary<S: Simd>(&self, simd: S, pair: &Pair<S>, sums: &mut DensitySums<S>) {
        let shape = self.kernel.shape(simd, pair.distance);
        sums.boundary = simd.mul_add(pair.fourth, shape, sums.boundary);
    }

    #[inline(always)]
    fn finish<S: Simd>(&self, simd: S, _: usize, sums: DensitySums<S>) -> f32 {
        // The shape of the kernel at the particle itself is 1.
        let fluid = self.fluid_factor * (1.0 + simd.sum(sums.fluid));
        fluid + self.boundary_factor * simd.sum(sums.boundary)
    }
}
