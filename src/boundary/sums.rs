//! What the walls add to a particle's sums, once a step: the kernels and their gradients over the boundary around it.
//!
//! Every sum of a method over the boundary, at the positions of the step, is one of these two times something that the
//! particle itself has: its density takes `ρ0 Σ_b V_b W_ib`, its pressure force `ρ0 t_i Σ_b V_b ∇W_ib`, its Dρ/Dt
//! `ρ0 v_i · Σ_b V_b ∇W_ib`, since walls do not move. So no other pass at these positions goes over the boundary.

use bevy_ecs::prelude::*;
use glam::{Vec3, Vec4};

use crate::{
    kernel::CubicSpline,
    material::Material,
    pairs::{Pair, PairSum, Pairs, accumulate},
    simd::Simd,
};

/// Of every particle `Σ_b V_b ∇W_ib` [m⁻¹] and, as fourth entry, `Σ_b V_b W_ib` [-]. In scenes with walls.
#[derive(Resource, Debug, Default)]
pub struct WallSums(Vec<Vec4>);

/// The same as loops read them: zero for every row where there are no walls.
#[derive(Debug, Clone, Copy, Default)]
pub struct Walls<'a>(&'a [Vec4]);

impl<'a> Walls<'a> {
    /// The sums of all rows; none in a scene without walls.
    pub fn of(sums: Option<&'a WallSums>) -> Self {
        Self(sums.map_or(&[], |sums| &sums.0))
    }

    /// `Σ_b V_b ∇W_ib` of a row [m⁻¹].
    #[inline(always)]
    pub fn gradient(self, row: usize) -> Vec3 {
        self.0.get(row).map_or(Vec3::ZERO, |sums| sums.truncate())
    }

    /// `Σ_b V_b W_ib` of a row [-]: the walls' part of its kernel.
    #[inline(always)]
    pub fn share(self, row: usize) -> f32 {
        self.0.get(row).map_or(0.0, |sums| sums.w)
    }
}

/// Sums over the boundary at the positions of the step (phase `Density`, first).
pub fn sum_walls(mut walls: ResMut<WallSums>, pairs: Pairs, material: Res<Material>) {
    walls.0.resize(pairs.positions().rows(), Vec4::ZERO);
    let pass = WallSum {
        kernel: material.kernel,
    };
    pairs.sum_at(&pairs.positions().0, &pass, &mut walls.0);
}

#[derive(Clone, Copy)]
struct WallSum {
    kernel: CubicSpline,
}

struct Sums<S: Simd> {
    gradient: [S::F; 3],
    shape: S::F,
}

impl PairSum for WallSum {
    type Sums<S: Simd> = Sums<S>;
    type Output = Vec4;
    const FLUID: bool = false;
    const BOUNDARY: bool = true;

    #[inline(always)]
    fn start<S: Simd>(&self, simd: S, _: usize, _: Vec4) -> Sums<S> {
        Sums {
            gradient: [simd.splat(0.0); 3],
            shape: simd.splat(0.0),
        }
    }

    #[inline(always)]
    fn boundary<S: Simd>(&self, simd: S, pair: &Pair<S>, sums: &mut Sums<S>) {
        let slope = simd.mul(pair.fourth, pair.slope);
        accumulate(simd, &mut sums.gradient, slope, pair.x);
        let shape = self.kernel.shape(simd, pair.distance);
        sums.shape = simd.mul_add(pair.fourth, shape, sums.shape);
    }

    #[inline(always)]
    fn finish<S: Simd>(&self, simd: S, _: usize, sums: Sums<S>) -> Vec4 {
        let [x, y, z] = sums.gradient;
        let gradient = Vec3::new(simd.sum(x), simd.sum(y), simd.sum(z));
        let CubicSpline {
            slope_factor,
            normalisation,
            ..
        } = self.kernel;
        (slope_factor * gradient).extend(normalisation * simd.sum(sums.shape))
    }
}
