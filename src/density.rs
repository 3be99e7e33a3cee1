//! Density (paper eq. 1): `ρ_i = Σ_j m W_ij`, the particle itself included, and `ρ0 Σ_b V_b W_ib` from the boundary
//! (Akinci et al. 2012).

use bevy_ecs::prelude::*;
use glam::Vec4;

use crate::{
    column::Densities,
    kernel::CubicSpline,
    material::Material,
    pairs::{PairSum, Pairs, broadcast, separation},
    simd::Simd,
};

/// Densities at the positions of the step (phase `Density`).
pub fn compute_density(mut densities: ResMut<Densities>, pairs: Pairs, material: Res<Material>) {
    densities.0.resize(pairs.positions().rows(), 0.0);
    pairs.sum(
        &DensitySum::new(&material, &pairs.positions().0, pairs.boundary_samples()),
        &mut densities.0,
    );
}

/// The sum of equation 1, at any positions.
#[derive(Clone, Copy)]
pub struct DensitySum<'a> {
    kernel: CubicSpline,
    positions: &'a [Vec4],
    boundary: &'a [Vec4],
    /// m σ
    fluid_factor: f32,
    /// ρ0 σ
    boundary_factor: f32,
}

impl<'a> DensitySum<'a> {
    /// Densities of particles at `positions`, which end with a sentinel as `boundary` does.
    pub fn new(material: &Material, positions: &'a [Vec4], boundary: &'a [Vec4]) -> Self {
        Self {
            kernel: material.kernel,
            positions,
            boundary,
            fluid_factor: material.particle_mass * material.kernel.normalisation,
            boundary_factor: material.rest_density * material.kernel.normalisation,
        }
    }
}

/// A particle's position and the sums over both kinds of neighbours.
pub struct DensitySums<S: Simd> {
    own: [S::F; 3],
    fluid: S::F,
    boundary: S::F,
}

impl PairSum for DensitySum<'_> {
    type Sums<S: Simd> = DensitySums<S>;
    type Output = f32;

    #[inline(always)]
    fn start<S: Simd>(&self, simd: S, i: usize) -> DensitySums<S> {
        DensitySums {
            own: broadcast(simd, self.positions[i]),
            fluid: simd.splat(0.0),
            boundary: simd.splat(0.0),
        }
    }

    #[inline(always)]
    fn fluid<S: Simd>(&self, simd: S, j: S::Rows, sums: &mut DensitySums<S>) {
        let (_, distance, _) = separation(simd, sums.own, self.positions, j);
        sums.fluid = simd.add(sums.fluid, self.kernel.shape(simd, distance));
    }

    #[inline(always)]
    fn boundary<S: Simd>(&self, simd: S, b: S::Rows, sums: &mut DensitySums<S>) {
        let (_, distance, volume) = separation(simd, sums.own, self.boundary, b);
        sums.boundary = simd.mul_add(volume, self.kernel.shape(simd, distance), sums.boundary);
    }

    #[inline(always)]
    fn finish<S: Simd>(&self, simd: S, _: usize, sums: DensitySums<S>) -> f32 {
        // The shape of the kernel at the particle itself is 1.
        let fluid = self.fluid_factor * (1.0 + simd.sum(sums.fluid));
        fluid + self.boundary_factor * simd.sum(sums.boundary)
    }
}
