//! What the walls add to a particle's sums, once a step: the kernels and their gradients over the boundary around it.
//!
//! Every sum of a method over the boundary, at the positions of the step, is one of these two times something that the
//! particle itself has: its density takes `ρ0 Σ_b V_b W_ib`, its pressure force `ρ0 t_i Σ_b V_b ∇W_ib`, its Dρ/Dt
//! `ρ0 v_i · Σ_b V_b ∇W_ib`. Where walls move a third is taken from that, `ρ0 Σ_b V_b v_b · ∇W_ib`. So no other pass at
//! these positions goes over the boundary.
//!
//! The gradients are multiplied by the push of [`BesideWall`], 1.75 in 2-D at a support of 2: with it a constant
//! pressure exerts no force at a wall. Without it only pressures are at rest that alternate from row to row, since rows
//! k and k ± 2 alone are coupled at that support; still water fell with 0.35 g in its first step, row by row.

use bevy_ecs::prelude::*;
use glam::{Vec3, Vec4};

use crate::{
    index::BoundarySamples,
    kernel::Kernel,
    lattice::BesideWall,
    pairs::{Pair, PairSum, Pairs, accumulate, dot},
    simd::Simd,
    state::Material,
};

/// Least part of a force along a wall that is taken to be there \[-]: in a corner the parts of several walls add up.
const LEAST_ALONG: f32 = 0.5;

/// Per particle `Σ_b V_b ∇W_ib` \[m⁻¹] times the walls' push and, as fourth entry, `Σ_b V_b W_ib` \[-]. In scenes with
/// walls.
#[derive(Resource, Debug)]
pub struct BoundarySums {
    sums: Vec<Vec4>,
    /// `Σ_b V_b v_b · ∇W_ib` \[s⁻¹] times the push; empty where no wall moves.
    fluxes: Vec<f32>,
    beside: BesideWall,
}

/// The same as loops read them: zero for every row where there are no walls.
#[derive(Debug, Clone, Copy, Default)]
pub struct Walls<'a> {
    sums: &'a [Vec4],
    fluxes: &'a [f32],
    slide: f32,
}

impl BoundarySums {
    /// Sums for walls of these properties.
    pub fn new(beside: BesideWall) -> Self {
        let (sums, fluxes) = (Vec::new(), Vec::new());
        Self {
            sums,
            fluxes,
            beside,
        }
    }
}

impl BoundarySums {
    /// Factor of the gradients of the walls' kernels \[-].
    pub(crate) fn push(&self) -> f32 {
        self.beside.push
    }
}

impl<'a> Walls<'a> {
    /// The sums of all rows; none in a scene without walls.
    pub fn of(sums: Option<&'a BoundarySums>) -> Self {
        sums.map_or_else(Self::default, |sums| Self {
            sums: &sums.sums,
            fluxes: &sums.fluxes,
            slide: sums.beside.slide,
        })
    }

    /// `Σ_b V_b ∇W_ib` of a row \[m⁻¹].
    #[inline(always)]
    pub fn gradient(self, row: usize) -> Vec3 {
        self.sums
            .get(row)
            .map_or(Vec3::ZERO, |sums| sums.truncate())
    }

    /// Whether a wall moves.
    pub fn are_moving(self) -> bool {
        !self.fluxes.is_empty()
    }

    /// `Σ_b V_b v_b · ∇W_ib` of a row \[s⁻¹]: what the motion of walls drives out of its place.
    #[inline(always)]
    pub fn flux(self, row: usize) -> f32 {
        self.fluxes.get(row).copied().unwrap_or_default()
    }

    /// `Σ_b V_b (v − v_b) · ∇W_ib` of a row with the velocity v \[s⁻¹].
    #[inline(always)]
    pub fn rate(self, row: usize, velocity: Vec3) -> f32 {
        self.gradient(row).dot(velocity) - self.flux(row)
    }

    /// A force of the fluid on a row, corrected for the part that is missing beside walls.
    ///
    /// A wall's samples push along its normal alone. Of the force along the wall a particle lacks the part of its
    /// kernel that lies in the wall, and would slide along it: still water had a layer at every side wall that fell
    /// with 0.16 g.
    #[inline(always)]
    pub fn made_up(self, row: usize, force: Vec3) -> Vec3 {
        let Some(sums) = self.sums.get(row).filter(|sums| sums.w > 0.0) else {
            return force;
        };
        let normal = sums.truncate().normalize_or_zero();
        let across = force.dot(normal) * normal;
        across + (force - across) / (1.0 - self.slide * sums.w).max(LEAST_ALONG)
    }

    /// The part of an acceleration by pressure, walls included, that [`made_up`](Self::made_up) added to it.
    #[inline(always)]
    pub(crate) fn added(self, row: usize, acceleration: Vec3) -> Vec3 {
        let Some(sums) = self.sums.get(row).filter(|sums| sums.w > 0.0) else {
            return Vec3::ZERO;
        };
        let normal = sums.truncate().normalize_or_zero();
        let along = acceleration - acceleration.dot(normal) * normal;
        along * (1.0 - (1.0 - self.slide * sums.w).max(LEAST_ALONG))
    }

    /// `Σ_b V_b W_ib` of a row \[-]: the walls' part of its kernel.
    #[inline(always)]
    pub fn share(self, row: usize) -> f32 {
        self.sums.get(row).map_or(0.0, |sums| sums.w)
    }
}

/// Sums over the boundary at the positions of the step (phase `Density`, first).
pub fn sum_walls(
    mut walls: ResMut<BoundarySums>,
    boundary: Res<BoundarySamples>,
    pairs: Pairs,
    material: Res<Material>,
) {
    let BoundarySums {
        sums,
        fluxes,
        beside,
    } = &mut *walls;
    sums.resize(pairs.positions().rows(), Vec4::ZERO);
    let pass = WallSum {
        kernel: material.kernel,
        push: beside.push,
    };
    pairs.sum_at(&pairs.positions().0, &pass, sums);
    if !boundary.velocities.is_empty() {
        fluxes.resize(pairs.positions().rows(), 0.0);
        let pass = WallFlux {
            velocities: &boundary.velocities,
            factor: beside.push * material.kernel.gradient_scale,
        };
        pairs.sum_at(&pairs.positions().0, &pass, fluxes);
    }
}

#[derive(Clone, Copy)]
struct WallSum {
    kernel: Kernel,
    push: f32,
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
    fn boundary<S: Simd>(&self, simd: S, pair: &Pair<S>, _: S::Rows, sums: &mut Sums<S>) {
        let slope = simd.mul(pair.packed_j, pair.grad_factor);
        accumulate(simd, &mut sums.gradient, slope, pair.x_ij);
        let shape = self.kernel.w(simd, pair.r2);
        sums.shape = simd.mul_add(pair.packed_j, shape, sums.shape);
    }

    #[inline(always)]
    fn finish<S: Simd>(&self, simd: S, _: usize, sums: Sums<S>) -> Vec4 {
        let [x, y, z] = sums.gradient;
        let gradient = Vec3::new(simd.sum(x), simd.sum(y), simd.sum(z));
        let Kernel {
            gradient_scale,
            normalisation,
            ..
        } = self.kernel;
        (self.push * gradient_scale * gradient).extend(normalisation * simd.sum(sums.shape))
    }
}

/// What the motion of walls adds to Dρ/Dt.
#[derive(Clone, Copy)]
struct WallFlux<'a> {
    velocities: &'a [Vec4],
    factor: f32,
}

impl PairSum for WallFlux<'_> {
    type Sums<S: Simd> = S::F;
    type Output = f32;
    const FLUID: bool = false;
    const BOUNDARY: bool = true;

    #[inline(always)]
    fn start<S: Simd>(&self, simd: S, _: usize, _: Vec4) -> S::F {
        simd.splat(0.0)
    }

    #[inline(always)]
    fn boundary<S: Simd>(&self, simd: S, pair: &Pair<S>, j: S::Rows, sum: &mut S::F) {
        let [x, y, z, _] = simd.gather(self.velocities, j);
        let slope = simd.mul(pair.packed_j, pair.grad_factor);
        *sum = simd.mul_add(slope, dot(simd, [x, y, z], pair.x_ij), *sum);
    }

    #[inline(always)]
    fn finish<S: Simd>(&self, simd: S, _: usize, sum: S::F) -> f32 {
        self.factor * simd.sum(sum)
    }
}
