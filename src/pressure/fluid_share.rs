//! Pressures beside walls, from what the pressure force does.
//!
//! A particle at a wall has a part `1 − γ` of its density from the wall, `γ_i = 1 − Σ_b V_b W_ib`, and a stretch of the
//! fluid does not thin that part out. So of the term t that acts in the force only γ works as pressure does in a fluid,
//! `t = p/(γ ρ²)`: that is Ferrand et al. 2013 (*Unified semi-analytical wall boundary conditions*, after Kulasegaram et al.
//! 2004), whose density `Σ_j m W_ij / γ_i` is at rest where ours is.
//!
//! Methods find t and know nothing of γ; when they are done [`weigh_pressures`] turns `ρ² t` into p. Without it still
//! water had 1.43 times its pressure beside a wall in the plane (1.08 with it), and in a tank of 8 × 8 particles the pressure
//! rose 17 to 20 % too fast (1 to 4 %).

use bevy_ecs::prelude::*;
use glam::Vec4;

use crate::{
    column::Pressures,
    execution::Execution,
    material::Material,
    pairs::{Pair, PairSum, Pairs},
    simd::Simd,
};

/// γ of every particle [-], at least [`LEAST`]. In scenes with walls.
#[derive(Resource, Debug, Default)]
pub struct FluidShares(pub Vec<f32>);

/// Least share: a particle in a right-angled corner of three walls has 0.3, one that a wall has swallowed none.
const LEAST: f32 = 0.1;

/// Calculates γ (phase `Pressure`, once a step).
pub fn find_fluid_shares(mut shares: ResMut<FluidShares>, pairs: Pairs, material: Res<Material>) {
    shares.0.resize(pairs.positions().rows(), 1.0);
    let share = FluidShare {
        material: &material,
    };
    pairs.sum_at(&pairs.positions().0, &share, &mut shares.0);
}

/// Makes pressures of what the method left, `p = γ ρ² t` (phase `Pressure`).
pub fn weigh_pressures(
    mut pressures: ResMut<Pressures>,
    shares: Res<FluidShares>,
    execution: Res<Execution>,
) {
    execution.for_each_chunk(&mut pressures.0, |first, pressures| {
        for (pressure, share) in pressures.iter_mut().zip(&shares.0[first..]) {
            *pressure *= share;
        }
    });
}

#[derive(Clone, Copy)]
struct FluidShare<'a> {
    material: &'a Material,
}

impl PairSum for FluidShare<'_> {
    type Sums<S: Simd> = S::F;
    type Output = f32;
    const FLUID: bool = false;

    #[inline(always)]
    fn start<S: Simd>(&self, simd: S, _: usize, _: Vec4) -> S::F {
        simd.splat(0.0)
    }

    #[inline(always)]
    fn boundary<S: Simd>(&self, simd: S, pair: &Pair<S>, sum: &mut S::F) {
        let shape = self.material.kernel.shape(simd, pair.distance);
        *sum = simd.mul_add(pair.fourth, shape, *sum);
    }

    #[inline(always)]
    fn finish<S: Simd>(&self, simd: S, _: usize, sum: S::F) -> f32 {
        (1.0 - self.material.kernel.normalisation * simd.sum(sum)).max(LEAST)
    }
}
