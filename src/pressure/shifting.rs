//! What keeps the particles of δ-SPH evenly spread: shifting, and the remedy of tension (δ⁺-SPH: Sun et al. 2017,
//! *Comput. Methods Appl. Mech. Engrg.* 315, 25; Sun et al. 2018, *Comput. Phys. Commun.* 224, 63).
//!
//! With `C_i = Σ_j V ∇W_ij`, which is zero in even surroundings, a particle moves beside its velocity by `−D (C_i + Σ_j
//! R (W_ij/W(Δx))⁴ V ∇W_ij)`. D is `K Δt U h`, at most a part of h², with the support radius h and the speed U at which
//! neighbours move relative to the particle, `max_j |v_ij| sqrt(W_ij/W(Δx))`: water at rest is not shifted.
//!
//! C points into the fluid at a free surface. Its mean over the neighbours says how near that is and where its normal
//! is: there a particle moves along the surface alone, and a spray particle not at all. Beside walls it does not come
//! nearer to them than a lattice lies. Away from the surface a negative pressure acts by `p_j − p_i` instead of `p_j +
//! p_i`, which would pull particles together.

use bevy_ecs::prelude::*;
use glam::{Vec3, Vec4};

use crate::{
    boundary::sums::{BoundarySums, Walls},
    index::BoundarySamples,
    kernel::Kernel,
    lattice::Lattice,
    pairs::{Pair, PairSum, PairsWithGradients, accumulate, broadcast, difference, dot},
    scene::Scene,
    simd::{Lanes, Simd},
    state::{
        Clock, Densities, Displacements, Execution, Material, Positions, PressureAccelerations,
        Velocities,
    },
};

/// R \[-] (Monaghan 2000).
const AGAINST_PAIRS: f32 = 0.2;

/// D at most, as a part of that with which the shortest waves of a lattice would overshoot \[-].
const MOST: f64 = 0.6;

/// Longest displacement in a step \[spacings].
const LONGEST: f32 = 0.1;

/// Length of the mean of h C from which on a particle is near a free surface \[-]: there it is above 1, in a disordered
/// interior 0.02.
const NEAR_SURFACE: f32 = 0.1;

/// Summed density below which fluid is spray, as a part of the rest density \[-]: at a flat surface there is 0.7 to
/// 0.8.
pub(super) const SPRAY: f32 = 0.5;

/// What the rows sum for it.
#[derive(Resource, Debug, Default)]
pub(crate) struct Shifting {
    /// K \[-].
    strength: f32,
    /// D at most, in one step \[m²].
    most: f32,
    sums: Vec<Surroundings>,
    /// h C of fluid and walls \[-], with 1 as fourth entry; a sentinel ends them.
    gradients: Vec<Vec4>,
    /// Their mean over the neighbours, weighted by the kernel.
    normals: Vec<Vec4>,
}

impl Shifting {
    pub(super) fn new(strength: f32, scene: &Scene) -> Self {
        // A lattice under a pressure p moves by dt² p/ρ times twice what it is shifted by with D = 1, and is stable up
        // to the square of the step below.
        let longest = Lattice::of(scene).pressure_step() * f64::from(scene.spacing);
        Self {
            strength,
            most: (MOST * 0.5 * longest * longest) as f32,
            ..Self::default()
        }
    }

    /// Whether a row is away from the free surface.
    pub(super) fn is_inside(&self, row: usize) -> bool {
        self.normals[row].truncate().length() < NEAR_SURFACE
    }
}

/// Sums over the fluid around a row.
#[derive(Debug, Clone, Copy, Default)]
struct Surroundings {
    /// `Σ_j V ∇W_ij` \[m⁻¹].
    gradient: Vec3,
    /// `Σ_j (W_ij/W(Δx))⁴ V ∇W_ij` \[m⁻¹].
    against_pairs: Vec3,
    /// U \[m/s].
    speed: f32,
}

/// Sums the surroundings of every row, and where the free surface is.
pub(super) fn look_around(
    mut shifting: ResMut<Shifting>,
    velocities: Res<Velocities>,
    walls: Option<Res<BoundarySums>>,
    pairs: PairsWithGradients,
    material: Res<Material>,
    execution: Res<Execution>,
) {
    let rows = pairs.positions().rows();
    let walls = Walls::of(walls.as_deref());
    let Shifting {
        sums,
        gradients,
        normals,
        ..
    } = &mut *shifting;
    let kernel = material.kernel;
    sums.resize(rows, Surroundings::default());
    let pass = SurroundingsSum {
        kernel,
        velocities: &velocities.0,
        inverse: kernel.value(0.0) / kernel.value(material.spacing),
        factor: material.particle_mass / material.rest_density * kernel.gradient_scale,
    };
    pairs.sum(&pass, sums);
    gradients.resize(rows + 1, Vec4::ZERO);
    gradients[rows] = Vec4::ZERO;
    execution.for_each_chunk(&mut gradients[..rows], |first, gradients| {
        for (row, gradient) in (first..).zip(gradients) {
            // Twice the walls' own sum is what acts on the fluid at an even pressure.
            let all = sums[row].gradient + 0.5 * walls.gradient(row);
            *gradient = (kernel.support_radius * all).extend(1.0);
        }
    });
    normals.resize(rows, Vec4::ZERO);
    let pass = NormalSum { kernel, gradients };
    pairs.sum(&pass, normals);
}

/// Takes the part with p_i out of the accelerations by tension, away from the surface.
pub(super) fn ease_tension(
    mut accelerations: ResMut<PressureAccelerations>,
    shifting: Res<Shifting>,
    positions: Res<Positions>,
    walls: Option<Res<BoundarySums>>,
    material: Res<Material>,
    execution: Res<Execution>,
) {
    let walls = Walls::of(walls.as_deref());
    execution.for_each_chunk(&mut accelerations.0, |first, accelerations| {
        for (row, acceleration) in (first..).zip(accelerations) {
            let term = positions.0[row].w;
            if term < 0.0 && shifting.is_inside(row) {
                let fluid = 2.0 * shifting.sums[row].gradient;
                *acceleration += term * material.rest_density * (fluid + walls.gradient(row));
            }
        }
    });
}

/// Displacements of the step.
pub(super) fn shift(
    mut displacements: ResMut<Displacements>,
    shifting: Res<Shifting>,
    densities: Res<Densities>,
    material: Res<Material>,
    clock: Res<Clock>,
    execution: Res<Execution>,
) {
    let h = material.kernel.support_radius;
    let spray = SPRAY * material.rest_density;
    displacements.0.resize(densities.0.len(), Vec3::ZERO);
    execution.for_each_chunk(&mut displacements.0, |first, displacements| {
        for (row, displacement) in (first..).zip(displacements) {
            if densities.0[row] < spray {
                *displacement = Vec3::ZERO;
                continue;
            }
            let around = &shifting.sums[row];
            let mut uneven =
                shifting.gradients[row].truncate() + h * AGAINST_PAIRS * around.against_pairs;
            let normal = shifting.normals[row].truncate();
            if !shifting.is_inside(row) {
                uneven = uneven.reject_from(normal);
            }
            let factor = (shifting.strength * clock.dt * around.speed).min(shifting.most / h);
            *displacement = (-factor * uneven).clamp_length_max(LONGEST * material.spacing);
        }
    });
}

/// Takes displacements back that would press rows against walls.
pub(super) fn keep_off_walls(
    mut displacements: ResMut<Displacements>,
    boundary: Res<BoundarySamples>,
    pairs: PairsWithGradients,
    material: Res<Material>,
) {
    let rows = displacements.0.len();
    let positions = &pairs.positions().0;
    let columns = (&mut displacements.0[..], &mut vec![(); rows][..]);
    pairs.update_near_boundary(columns, |row, samples, displacement: &mut Vec3, ()| {
        let own = positions[row].truncate();
        for &sample in samples {
            // A stale list may name samples that are gone.
            let Some(&normal) = boundary.normals.get(sample as usize) else {
                continue;
            };
            let place = boundary.packed[sample as usize].truncate();
            let x = material.period.nearest(own - place);
            let height = x.dot(normal) - boundary.layer_depth;
            let away = displacement.dot(normal);
            let is_near = height < 0.5 * material.spacing && x.length() < 1.5 * material.spacing;
            if away < 0.0 && is_near {
                *displacement -= away * normal;
            }
        }
    });
}

#[derive(Clone, Copy)]
struct SurroundingsSum<'a> {
    kernel: Kernel,
    velocities: &'a [Vec4],
    /// W(0)/W(Δx).
    inverse: f32,
    /// V and the kernel's factor.
    factor: f32,
}

struct SurroundingsSums<S: Simd> {
    velocity: [S::F; 3],
    gradient: [S::F; 3],
    against_pairs: [S::F; 3],
    speed_squared: S::F,
}

impl PairSum for SurroundingsSum<'_> {
    type Sums<S: Simd> = SurroundingsSums<S>;
    type Output = Surroundings;

    #[inline(always)]
    fn start<S: Simd>(&self, simd: S, i: usize, _: Vec4) -> SurroundingsSums<S> {
        let zero = simd.splat(0.0);
        SurroundingsSums {
            velocity: broadcast(simd, self.velocities[i]),
            gradient: [zero; 3],
            against_pairs: [zero; 3],
            speed_squared: zero,
        }
    }

    #[inline(always)]
    fn fluid<S: Simd>(&self, simd: S, pair: &Pair<S>, j: S::Rows, sums: &mut SurroundingsSums<S>) {
        accumulate(simd, &mut sums.gradient, pair.grad_factor, pair.x_ij);
        // Zero for absent rows, whose velocity is no velocity.
        let near = simd.mul(self.kernel.w(simd, pair.r2), simd.splat(self.inverse));
        let square = simd.mul(near, near);
        let factor = simd.mul(simd.mul(square, square), pair.grad_factor);
        accumulate(simd, &mut sums.against_pairs, factor, pair.x_ij);
        let (v, _) = difference(simd, sums.velocity, self.velocities, j);
        let speed_squared = simd.mul(near, dot(simd, v, v));
        sums.speed_squared = simd.max(sums.speed_squared, speed_squared);
    }

    #[inline(always)]
    fn finish<S: Simd>(&self, simd: S, _: usize, sums: SurroundingsSums<S>) -> Surroundings {
        let vector =
            |[x, y, z]: [S::F; 3]| self.factor * Vec3::new(simd.sum(x), simd.sum(y), simd.sum(z));
        let mut lanes = Lanes::default();
        simd.store(sums.speed_squared, &mut lanes);
        Surroundings {
            gradient: vector(sums.gradient),
            against_pairs: vector(sums.against_pairs),
            speed: lanes.0.into_iter().fold(0.0, f32::max).sqrt(),
        }
    }
}

#[derive(Clone, Copy)]
struct NormalSum<'a> {
    kernel: Kernel,
    gradients: &'a [Vec4],
}

impl PairSum for NormalSum<'_> {
    type Sums<S: Simd> = ([S::F; 4], Vec4);
    type Output = Vec4;

    #[inline(always)]
    fn start<S: Simd>(&self, simd: S, i: usize, _: Vec4) -> Self::Sums<S> {
        ([simd.splat(0.0); 4], self.gradients[i])
    }

    #[inline(always)]
    fn fluid<S: Simd>(&self, simd: S, pair: &Pair<S>, j: S::Rows, sums: &mut Self::Sums<S>) {
        let weight = self.kernel.w(simd, pair.r2);
        let gradient = simd.gather(self.gradients, j);
        for (sum, component) in sums.0.iter_mut().zip(gradient) {
            *sum = simd.mul_add(weight, component, *sum);
        }
    }

    #[inline(always)]
    fn finish<S: Simd>(&self, simd: S, _: usize, (sums, own): Self::Sums<S>) -> Vec4 {
        let [x, y, z, weights] = sums;
        let (x, y) = (simd.sum(x), simd.sum(y));
        let (z, weights) = (simd.sum(z), simd.sum(weights));
        // Its own weight is 1.
        (own + Vec4::new(x, y, z, 0.0)) / (1.0 + weights)
    }
}
