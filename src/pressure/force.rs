//! The symmetric pressure force: `a_i = −Σ_j m (p_i/ρ_i² + p_j/ρ_j²) ∇W_ij − Σ_b ρ0 V_b (p_i/ρ_i²) ∇W_ib`.
//!
//! Between two fluid particles the terms are equal and opposite to the bit, so linear momentum is kept to rounding. The
//! boundary pushes only, since pressures are not negative, and takes the particle's own term once (Akinci et al. 2012):
//! the force is then `−Σ_k p_k/ρ_k² · ∂ρ_k/∂x_i`, the gradient of the densities that pressure acts against, and does no
//! work in a cycle. Beside a wall the term is more than `p/ρ²` (see [`fluid_share`](super::fluid_share)). A mirror image
//! of the term, tried first, added a quarter to the energy of still water in 0.6 s.

use bevy_ecs::prelude::*;
use glam::{Vec3, Vec4};

use crate::{
    column::PressureAccelerations,
    material::Material,
    pairs::{Pair, PairSum, PairsWithSlopes, accumulate},
    simd::Simd,
};

/// Accelerations of the pressure terms beside the positions (phase `Pressure`).
pub fn pressure_force(
    mut accelerations: ResMut<PressureAccelerations>,
    pairs: PairsWithSlopes,
    material: Res<Material>,
) {
    accelerations.0.resize(pairs.positions().rows(), Vec3::ZERO);
    let pass = PressureForce {
        material: &material,
        boundary_mass: material.rest_density / material.particle_mass,
    };
    pairs.sum(&pass, &mut accelerations.0);
}

#[derive(Clone, Copy)]
struct PressureForce<'a> {
    material: &'a Material,
    /// ρ0/m: with a volume, the boundary particle's mass in particle masses.
    boundary_mass: f32,
}

struct ForceSums<S: Simd> {
    term: S::F,
    sum: [S::F; 3],
}

impl PairSum for PressureForce<'_> {
    type Sums<S: Simd> = ForceSums<S>;
    type Output = Vec3;

    #[inline(always)]
    fn start<S: Simd>(&self, simd: S, _: usize, own: Vec4) -> ForceSums<S> {
        ForceSums {
            term: simd.splat(own.w),
            sum: [simd.splat(0.0); 3],
        }
    }

    #[inline(always)]
    fn fluid<S: Simd>(&self, simd: S, pair: &Pair<S>, _: S::Rows, sums: &mut ForceSums<S>) {
        let terms = simd.add(sums.term, pair.fourth);
        accumulate(simd, &mut sums.sum, simd.mul(terms, pair.slope), pair.x);
    }

    #[inline(always)]
    fn boundary<S: Simd>(&self, simd: S, pair: &Pair<S>, sums: &mut ForceSums<S>) {
        let mass = simd.mul(pair.fourth, simd.splat(self.boundary_mass));
        let term = simd.mul(mass, sums.term);
        accumulate(simd, &mut sums.sum, simd.mul(term, pair.slope), pair.x);
    }

    #[inline(always)]
    fn finish<S: Simd>(&self, simd: S, _: usize, sums: ForceSums<S>) -> Vec3 {
        let [x, y, z] = sums.sum;
        let factor = -self.material.particle_mass * self.material.kernel.slope_factor;
        factor * Vec3::new(simd.sum(x), simd.sum(y), simd.sum(z))
    }
}
