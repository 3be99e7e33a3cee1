//! What IISPH and DFSPH share: one linear system, and a Jacobi iteration on it.
//!
//! With the pressure force of [`force`](super::force), pressure terms `t = p/ρ²` and the velocities v* without pressure,
//! `ρ_i + dt Dρ_i/Dt(v* + dt a(t)) = ρ0` is linear in t, with
//!
//! `Dρ_i/Dt(v) = Σ_j m (v_i − v_j)·∇W_ij + Σ_b ρ0 V_b v_i·∇W_ib`.
//!
//! What particle i answers to its own term is `dt² D_i`, `D_i = |Σ_j m ∇W_ij + Σ_b ρ0 V_b ∇W_ib|² + Σ_j |m ∇W_ij|²`: walls
//! count in the particle's own motion and not in that of its neighbours, as they do not move. A relaxed Jacobi iteration
//! is `t_i ← max(0, t_i + ω (ρ*_i − ρ0)/(dt² D_i))`: two passes over the neighbours, force and rate.
//!
//! This is IISPH's iteration (Ihmsen et al. 2014) with p/ρ² for p, `a_ii = −dt² D_i/ρ_i²`, and its sums over d_ij taken as
//! accelerations, `d_ii p_i + Σ_j d_ij p_j = dt² a_i`: no coefficient but D is stored. And it is DFSPH's (Bender & Koschier
//! 2015), whose α_i is `ρ_i/D_i`, with the sum of the corrections κ kept and bounded instead of every one.

use bevy_ecs::prelude::*;
use glam::{Vec3, Vec4};

use super::{Corrected, PressureSolve, lattice_response};
use crate::{
    column::{Accelerations, Densities, Positions, PressureAccelerations, Pressures, Velocities},
    execution::Execution,
    material::Material,
    pairs::{Pair, PairSum, PairsWithSlopes, accumulate, broadcast, difference, dot},
    simd::Simd,
    step::Clock,
};

/// Parameters of the iteration.
#[derive(Resource, Debug, Clone, Copy)]
pub struct Jacobi {
    /// Relaxation ω [-].
    pub relaxation: f32,
}

/// `1/D` of every particle [m⁸/kg²; m⁶/kg² in 2-D]; 0 where nothing answers.
#[derive(Resource, Debug, Default)]
pub struct Responses(pub Vec<f32>);

/// Velocities at the end of the step [m/s]. A sentinel of zero ends them.
#[derive(Resource, Debug, Default)]
pub struct PredictedVelocities(pub Vec<Vec4>);

/// Dρ/Dt of the predicted velocities [kg/(m³ s)].
#[derive(Resource, Debug, Default)]
pub struct DensityRates(pub Vec<f32>);

/// Inserts what the iteration needs.
pub fn install(world: &mut World, relaxation: f32) {
    world.insert_resource(Jacobi { relaxation });
    world.init_resource::<Responses>();
    world.init_resource::<PredictedVelocities>();
    world.init_resource::<DensityRates>();
}

/// `v + dt a` with all accelerations.
pub fn predict_velocities(
    mut predicted: ResMut<PredictedVelocities>,
    velocities: Res<Velocities>,
    accelerations: Res<Accelerations>,
    pressure_accelerations: Res<PressureAccelerations>,
    clock: Res<Clock>,
    execution: Res<Execution>,
) {
    let dt = clock.dt;
    let accelerations = &accelerations.0;
    predicted.write(
        &velocities,
        &pressure_accelerations,
        &execution,
        |row, a_p| dt * (accelerations[row] + a_p),
    );
}

impl PredictedVelocities {
    /// Velocities with what `change` makes of a row and its pressure acceleration.
    pub(super) fn write(
        &mut self,
        velocities: &Velocities,
        pressure_accelerations: &PressureAccelerations,
        execution: &Execution,
        change: impl Fn(usize, Vec3) -> Vec3 + Sync,
    ) {
        let rows = pressure_accelerations.0.len();
        self.0.resize(rows + 1, Vec4::ZERO);
        self.0[rows] = Vec4::ZERO;
        execution.for_each_chunk(&mut self.0[..rows], |first, predicted| {
            let columns = velocities.0[first..]
                .iter()
                .zip(&pressure_accelerations.0[first..]);
            for (row, (predicted, (v, a_p))) in (first..).zip(predicted.iter_mut().zip(columns)) {
                *predicted = (v.truncate() + change(row, *a_p)).extend(0.0);
            }
        });
    }
}

/// Dρ/Dt of the predicted velocities.
pub fn predict_rates(
    mut rates: ResMut<DensityRates>,
    predicted: Res<PredictedVelocities>,
    pairs: PairsWithSlopes,
    material: Res<Material>,
) {
    rates.0.resize(pairs.positions().rows(), 0.0);
    let pass = DensityRate::new(&material, &predicted.0);
    pairs.sum(&pass, &mut rates.0);
}

/// The term after a correction, not below zero; none where nothing answers it.
#[inline]
pub(super) fn corrected(term: f32, correction: f32, response: f32) -> f32 {
    if response > 0.0 {
        (term + response * correction).max(0.0)
    } else {
        0.0
    }
}

/// Corrects the pressures by the predicted densities.
pub fn update_pressure(
    mut pressures: ResMut<Pressures>,
    mut positions: ResMut<Positions>,
    mut solve: ResMut<PressureSolve>,
    columns: (Res<Densities>, Res<DensityRates>, Res<Responses>),
    jacobi: Res<Jacobi>,
    material: Res<Material>,
    clock: Res<Clock>,
    execution: Res<Execution>,
) {
    let (densities, rates, responses) = columns;
    let (dt, rest_density) = (clock.dt, material.rest_density);
    let factor = jacobi.relaxation / (dt * dt);
    let (positions, pressures) = (&mut positions.0, &mut pressures.0);
    solve.update(positions, pressures, &execution, |row, term, _| {
        let rho = densities.0[row];
        let error = rho + dt * rates.0[row] - rest_density;
        // The term that has acted: the last correction exerts no force.
        let acted = term * rho * rho;
        let term = corrected(term, factor * error, responses.0[row]);
        Corrected {
            term,
            kept: acted,
            error: error / rest_density,
        }
    });
}

/// Sums `1/D`.
#[derive(Clone, Copy)]
pub struct Response {
    /// ρ0/m: with a volume, the boundary particle's mass in particle masses.
    boundary_mass: f32,
    /// m² and the square of the kernel's factor.
    factor: f32,
    /// D below which nothing answers.
    least: f32,
}

/// Part of a full lattice's D below which a particle is taken to answer no pressure. The motion that removes an error
/// grows as 1/sqrt(D); two particles on the edge of each other's support have 4e-4.
const LEAST_RESPONSE: f64 = 1e-3;

impl Response {
    /// The sum for this fluid.
    pub fn new(material: &Material) -> Self {
        let mass = f64::from(material.particle_mass);
        Self {
            boundary_mass: material.rest_density / material.particle_mass,
            factor: (material.particle_mass * material.kernel.slope_factor).powi(2),
            least: (LEAST_RESPONSE * mass * mass * lattice_response(material)) as f32,
        }
    }
}

/// The sum of gradients and that of their squares.
pub struct ResponseSums<S: Simd> {
    sum: [S::F; 3],
    squares: S::F,
}

impl PairSum for Response {
    type Sums<S: Simd> = ResponseSums<S>;
    type Output = f32;

    #[inline(always)]
    fn start<S: Simd>(&self, simd: S, _: usize, _: Vec4) -> ResponseSums<S> {
        ResponseSums {
            sum: [simd.splat(0.0); 3],
            squares: simd.splat(0.0),
        }
    }

    #[inline(always)]
    fn fluid<S: Simd>(&self, simd: S, pair: &Pair<S>, _: S::Rows, sums: &mut ResponseSums<S>) {
        accumulate(simd, &mut sums.sum, pair.slope, pair.x);
        let square = simd.mul(pair.slope, pair.slope);
        sums.squares = simd.mul_add(square, pair.distance, sums.squares);
    }

    #[inline(always)]
    fn boundary<S: Simd>(&self, simd: S, pair: &Pair<S>, sums: &mut ResponseSums<S>) {
        let mass = simd.mul(pair.fourth, simd.splat(self.boundary_mass));
        accumulate(simd, &mut sums.sum, simd.mul(mass, pair.slope), pair.x);
    }

    #[inline(always)]
    fn finish<S: Simd>(&self, simd: S, _: usize, sums: ResponseSums<S>) -> f32 {
        let [x, y, z] = sums.sum;
        let sum = Vec3::new(simd.sum(x), simd.sum(y), simd.sum(z));
        let response = self.factor * (sum.length_squared() + simd.sum(sums.squares));
        if response > self.least {
            1.0 / response
        } else {
            0.0
        }
    }
}

/// Sums Dρ/Dt.
#[derive(Clone, Copy)]
pub struct DensityRate<'a> {
    velocities: &'a [Vec4],
    /// ρ0/m: with a volume, the boundary particle's mass in particle masses.
    boundary_mass: f32,
    /// m and the kernel's factor.
    factor: f32,
}

impl<'a> DensityRate<'a> {
    /// The sum over `velocities`, which end with a sentinel of zero.
    pub fn new(material: &Material, velocities: &'a [Vec4]) -> Self {
        Self {
            velocities,
            boundary_mass: material.rest_density / material.particle_mass,
            factor: material.particle_mass * material.kernel.slope_factor,
        }
    }
}

/// A particle's velocity, and the sum.
pub struct DensityRateSums<S: Simd> {
    velocity: [S::F; 3],
    sum: S::F,
}

impl PairSum for DensityRate<'_> {
    type Sums<S: Simd> = DensityRateSums<S>;
    type Output = f32;

    #[inline(always)]
    fn start<S: Simd>(&self, simd: S, i: usize, _: Vec4) -> DensityRateSums<S> {
        DensityRateSums {
            velocity: broadcast(simd, self.velocities[i]),
            sum: simd.splat(0.0),
        }
    }

    #[inline(always)]
    fn fluid<S: Simd>(&self, simd: S, pair: &Pair<S>, j: S::Rows, sums: &mut DensityRateSums<S>) {
        let (v, _) = difference(simd, sums.velocity, self.velocities, j);
        sums.sum = simd.mul_add(pair.slope, dot(simd, v, pair.x), sums.sum);
    }

    #[inline(always)]
    fn boundary<S: Simd>(&self, simd: S, pair: &Pair<S>, sums: &mut DensityRateSums<S>) {
        let mass = simd.mul(pair.fourth, simd.splat(self.boundary_mass));
        let approach = dot(simd, sums.velocity, pair.x);
        sums.sum = simd.mul_add(simd.mul(mass, pair.slope), approach, sums.sum);
    }

    #[inline(always)]
    fn finish<S: Simd>(&self, simd: S, _: usize, sums: DensityRateSums<S>) -> f32 {
        self.factor * simd.sum(sums.sum)
    }
}
