//! The symmetric pressure force: `a_i = −Σ_j m (p_i/ρ_i² + p_j/ρ_j²) ∇W_ij − Σ_b ρ0 V_b (p_i/ρ_i²) ∇W_ib`.
//!
//! The terms of two fluid particles are bitwise equal and opposite, so momentum is conserved up to rounding. Boundary
//! particles use the fluid particle's own term (Akinci et al. 2012), times the walls' push (see
//! [`sums`](crate::boundary::sums)), and only repel, since pressures are not negative. With the same factor in Dρ/Dt,
//! the force is the gradient of the predicted densities. [`Walls::made_up`] corrects the fluid's force along a wall
//! for the missing part of the kernel.

use bevy_ecs::prelude::*;
use glam::{Vec3, Vec4};

use crate::{
    boundary::sums::{BoundarySums, Walls},
    flow::Hold,
    pairs::{Pair, PairSum, PairsWithGradients, accumulate},
    simd::Simd,
    state::{Material, PressureAccelerations},
};

/// Accelerations of the pressure terms beside the positions (phase `Pressure`).
pub fn pressure_force(
    mut accelerations: ResMut<PressureAccelerations>,
    mut hold: Hold,
    walls: Option<Res<BoundarySums>>,
    pairs: PairsWithGradients,
    material: Res<Material>,
) {
    accelerations.0.resize(pairs.positions().rows(), Vec3::ZERO);
    let pass = PressureForce::new(&material, Walls::of(walls.as_deref()));
    pairs.sum(&pass, &mut accelerations.0);
    hold.reduce(&mut accelerations.0);
    pairs.execution.share(&mut accelerations.0);
}

/// The sum.
#[derive(Clone, Copy)]
pub struct PressureForce<'a> {
    material: &'a Material,
    walls: Walls<'a>,
}

impl<'a> PressureForce<'a> {
    /// The sum for this fluid.
    pub fn new(material: &'a Material, walls: Walls<'a>) -> Self {
        Self { material, walls }
    }
}

/// A particle's pressure term, and the sums.
pub struct ForceSums<S: Simd> {
    term: S::F,
    sum: [S::F; 3],
    row: usize,
    /// `ρ0 t_i Σ_b V_b ∇W_ib` \[m/s²].
    walls: Vec3,
}

impl PairSum for PressureForce<'_> {
    type Sums<S: Simd> = ForceSums<S>;
    type Output = Vec3;

    #[inline(always)]
    fn start<S: Simd>(&self, simd: S, i: usize, own: Vec4) -> ForceSums<S> {
        ForceSums {
            term: simd.splat(own.w),
            row: i,
            sum: [simd.splat(0.0); 3],
            walls: self.material.rest_density * own.w * self.walls.gradient(i),
        }
    }

    #[inline(always)]
    fn fluid<S: Simd>(&self, simd: S, pair: &Pair<S>, _: S::Rows, sums: &mut ForceSums<S>) {
        let terms = simd.add(sums.term, pair.packed_j);
        accumulate(
            simd,
            &mut sums.sum,
            simd.mul(terms, pair.grad_factor),
            pair.x_ij,
        );
    }

    #[inline(always)]
    fn finish<S: Simd>(&self, simd: S, _: usize, sums: ForceSums<S>) -> Vec3 {
        let [x, y, z] = sums.sum;
        let factor = -self.material.particle_mass * self.material.kernel.gradient_scale;
        let fluid = factor * Vec3::new(simd.sum(x), simd.sum(y), simd.sum(z));
        self.walls.made_up(sums.row, fluid) - sums.walls
    }
}
