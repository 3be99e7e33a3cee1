//! Density (paper eq. 1): `ρ_i = Σ_j m W_ij`, the particle itself included, and `ρ0 Σ_b V_b W_ib` from the boundary
//! (Akinci et al. 2012).

use bevy_ecs::prelude::*;
use glam::Vec4;

use crate::{
    boundary::sums::{BoundarySums, Walls},
    kernel::Kernel,
    pairs::{KernelGradients, Pair, PairSum, Pairs, store},
    simd::Simd,
    state::{Densities, Material},
};

/// Densities at the positions of the step (phase `Density`).
pub fn compute_density(
    mut densities: ResMut<Densities>,
    mut grad_factors: Option<ResMut<KernelGradients>>,
    walls: Option<Res<BoundarySums>>,
    pairs: Pairs,
    material: Res<Material>,
) {
    densities.0.resize(pairs.positions().rows(), 0.0);
    let pass = DensitySum::new(&material, Walls::of(walls.as_deref()));
    pairs.sum_and_keep(&pass, grad_factors.as_deref_mut(), store(&mut densities.0));
}

/// The sum of equation 1, with the walls' part known or, if they are `SUMMED`, at any positions.
#[derive(Clone, Copy)]
pub struct DensitySum<'a, const SUMMED: bool> {
    kernel: Kernel,
    walls: Walls<'a>,
    particle_mass: f32,
    rest_density: f32,
}

impl<'a> DensitySum<'a, false> {
    /// Densities of this fluid at the positions that `walls` is of.
    pub fn new(material: &Material, walls: Walls<'a>) -> Self {
        Self::with(material, walls)
    }
}

impl DensitySum<'_, true> {
    /// Densities of this fluid anywhere.
    pub fn anywhere(material: &Material) -> Self {
        Self::with(material, Walls::default())
    }
}

impl<'a, const SUMMED: bool> DensitySum<'a, SUMMED> {
    fn with(material: &Material, walls: Walls<'a>) -> Self {
        Self {
            kernel: material.kernel,
            walls,
            particle_mass: material.particle_mass,
            rest_density: material.rest_density,
        }
    }
}

/// The sums over both kinds of neighbours.
pub struct DensitySums<S: Simd> {
    fluid: S::F,
    boundary: S::F,
    /// The walls' part where it is known \[-].
    walls: f32,
}

impl<const SUMMED: bool> PairSum for DensitySum<'_, SUMMED> {
    type Sums<S: Simd> = DensitySums<S>;
    type Output = f32;
    const BOUNDARY: bool = SUMMED;

    #[inline(always)]
    fn start<S: Simd>(&self, simd: S, i: usize, _: Vec4) -> DensitySums<S> {
        DensitySums {
            fluid: simd.splat(0.0),
            boundary: simd.splat(0.0),
            walls: self.walls.share(i),
        }
    }

    #[inline(always)]
    fn fluid<S: Simd>(&self, simd: S, pair: &Pair<S>, _: S::Rows, sums: &mut DensitySums<S>) {
        sums.fluid = simd.add(sums.fluid, self.kernel.w(simd, pair.r2));
    }

    #[inline(always)]
    fn boundary<S: Simd>(&self, simd: S, pair: &Pair<S>, _: S::Rows, sums: &mut DensitySums<S>) {
        let shape = self.kernel.w(simd, pair.r2);
        sums.boundary = simd.mul_add(pair.packed_j, shape, sums.boundary);
    }

    #[inline(always)]
    fn finish<S: Simd>(&self, simd: S, _: usize, sums: DensitySums<S>) -> f32 {
        // The shape of the kernel at the particle itself is 1.
        let normalisation = self.kernel.normalisation;
        let fluid = self.particle_mass * normalisation * (1.0 + simd.sum(sums.fluid));
        let walls = sums.walls + normalisation * simd.sum(sums.boundary);
        fluid + self.rest_density * walls
    }
}
