//! What IISPH and DFSPH share: one linear system, and a Jacobi iteration on it.
//!
//! With the pressure force of [`force`](super::force), pressure terms `t = p/ρ²` and the velocities v* without
//! pressure, `ρ_i + dt Dρ_i/Dt(v* + dt a(t)) = ρ0` is linear in t, with
//!
//! `Dρ_i/Dt(v) = Σ_j m (v_i − v_j)·∇W_ij + Σ_b ρ0 V_b (v_i − v_b)·∇W_ib`.
//!
//! What particle i answers to its own term is `dt² D_i`, `D_i = |Σ_j m ∇W_ij + Σ_b ρ0 V_b ∇W_ib|² + Σ_j |m ∇W_ij|²`:
//! walls count in the particle's own motion and not in that of its neighbours, as they answer no pressure (see
//! [`response`](super::response)). A relaxed Jacobi iteration
//! is `t_i ← max(0, t_i + ω (ρ*_i − ρ0)/(dt² D_i))`: two passes over the neighbours, force and rate.
//!
//! This is IISPH's iteration (Ihmsen et al. 2014) with p/ρ² for p, `a_ii = −dt² D_i/ρ_i²`, and its sums over d_ij taken
//! as accelerations, `d_ii p_i + Σ_j d_ij p_j = dt² a_i`: no coefficient but D is stored. And it is DFSPH's (Bender &
//! Koschier 2015), whose α_i is `ρ_i/D_i`, with the sum of the corrections κ kept and bounded instead of every one.
//!
//! One thing goes past both papers.
//!
//! Momentum: as the force is the gradient of the densities that pressure acts against (see
//! [`force`](super::force)), the iteration descends a convex function, and Nesterov's acceleration with restarts applies.
//! It is stable for eigenvalues of `D⁻¹ A` up to 4/(3 ω). The largest is 2.15 in 2-D and 2.82 in 3-D on a lattice of
//! the default support, so ω = 0.4, which leaves room up to 3.3; at wider supports it grows, and ω is bounded by it.
//! Measured in a dam break of 15 000 particles, 0.6 s with DFSPH's defaults: 6761 : 4869 iterations, and 3988 with what
//! pays only then: 0.6 in place of ½ of the last step's pressures, and steps that shorten from 20 iterations on. 60
//! layers of still water, four steps of IISPH at 0.01 %: 1109 : 207.

use bevy_ecs::prelude::*;
use glam::{Vec3, Vec4};

use super::{force::pressure_force, response::Responses};
use crate::{
    boundary::sums::{WallSums, Walls},
    lattice::Lattice,
    pairs::{Pair, PairSum, PairsWithSlopes, broadcast, difference, dot},
    simd::Simd,
    state::{
        Accelerations, Clock, Column, Corrected, Densities, Execution, Material, MeanPressures,
        Positions, PressureAccelerations, PressureSolve, Pressures, Systems, Velocities,
        wants_force,
    },
    time_step::RecoveryTime,
};

/// Columns of the iteration.
pub(super) const COLUMNS: &[Column; 4] = &[
    Column::derived("predicted velocity", "m/s", "at the end of the step", 16).in_halo(),
    Column::derived(
        "density rate",
        "kg/(m^3 s)",
        "of the predicted velocities",
        4,
    ),
    Column::derived(
        "diagonal",
        "m^8/kg^2",
        "inverse response to the own pressure",
        4,
    ),
    Column::derived("pressure term", "Pa m^6/kg^2", "while it is solved for", 8),
];

/// The systems of one iteration, in their order.
pub(super) fn iteration() -> Systems {
    (
        pressure_force.run_if(wants_force),
        predict_velocities,
        predict_rates,
        update_pressure,
    )
        .chain()
}

/// Largest ω that a scene may ask for with momentum. On lattices that are not stable with it less is taken.
pub const MAX_RELAXATION_WITH_MOMENTUM: f32 = 0.54;

/// Largest ω with which momentum is ahead from the first iteration on. Few iterations leave short waves larger than
/// they found them if both are large, and means carry those from step to step. The corner dam break of 130 000
/// particles with DFSPH, at 1 % with two to six iterations and at 0.01 %: whole with 0.36 to 0.42, with 0.45 not at
/// 0.01 %, with 0.5 not with three iterations either.
const MAX_RELAXATION_AT_ONCE: f32 = 0.42;

/// Largest relaxation times the largest eigenvalue of the scene's lattice [-]: nine tenths of what is stable, 4/3 and
/// 2.
const WITH_MOMENTUM: f32 = 1.2;
const WITHOUT_MOMENTUM: f32 = 1.8;

/// The iteration's parameters, and its momentum.
#[derive(Resource, Debug, Clone, Copy)]
pub struct Jacobi {
    /// Relaxation ω [-].
    relaxation: f32,
    /// Whether corrections have momentum.
    momentum: bool,
    /// Iterations that the momentum counts as done ahead; below zero, how many it begins later.
    head_start: i32,
    /// Iterations of this solve before it does.
    ahead_from: u32,
    /// Iterations since the momentum was zero.
    since: u32,
    /// Share of the last correction that the next goes on by.
    carried: f32,
}

/// A pressure term while it is solved for.
#[derive(Debug, Clone, Copy, Default)]
pub struct Iterate {
    /// The one whose force acted last.
    pub acted: f32,
    /// What its correction came to, before momentum.
    corrected: f32,
}

/// The terms of the density solve.
#[derive(Resource, Debug, Default)]
pub struct Iterates(pub Vec<Iterate>);

impl Jacobi {
    /// Corrects the term that acted, by the error that it left and the response that removes one. Gives the next term,
    /// and how far the correction went.
    ///
    /// With momentum the next is `t_k + k/(k + 3) (t_k − t_{k−1})` (Nesterov 1983).
    #[inline]
    pub(super) fn correct(
        &self,
        iterate: &mut Iterate,
        acted: f32,
        (response, error): (f32, f32),
        first: bool,
    ) -> (f32, f32) {
        let before = if first { acted } else { iterate.corrected };
        let corrected = if response > 0.0 {
            (acted + self.relaxation * response * error).max(0.0)
        } else {
            // Nothing answers.
            0.0
        };
        *iterate = Iterate { acted, corrected };
        let step = corrected - before;
        ((corrected + self.carried * step).max(0.0), step)
    }

    /// Whether terms that start below their solution may go above it.
    pub(super) fn overshoots(&self) -> bool {
        self.momentum
    }

    /// Before the first iteration of a solve. The momentum of one that starts from means is ahead at once, unless the
    /// relaxation is too bold for that; the momentum of others from the third iteration on.
    pub(super) fn start(&mut self, from_means: bool) {
        let at_once = from_means && self.relaxation <= MAX_RELAXATION_AT_ONCE;
        self.ahead_from = if at_once { 0 } else { 2 };
        self.count(0);
    }

    /// After an iteration that went so far along the errors in all: momentum that goes against them ends (O'Donoghue &
    /// Candès 2015).
    pub(super) fn advance(&mut self, progress: f64) {
        self.count(if progress < 0.0 { 0 } else { self.since + 1 });
    }

    /// The next correction has no momentum.
    pub(super) fn rest(&mut self) {
        (self.since, self.carried) = (0, 0.0);
    }

    fn count(&mut self, since: u32) {
        self.since = since;
        if self.momentum {
            let ahead = if since < self.ahead_from {
                self.head_start.min(0)
            } else {
                self.head_start
            };
            let k = since.saturating_add_signed(ahead) as f32;
            self.carried = k / (k + 3.0);
        }
    }
}

/// Velocities at the end of the step [m/s]. A sentinel of zero ends them.
#[derive(Resource, Debug, Default)]
pub struct PredictedVelocities(pub Vec<Vec4>);

/// Dρ/Dt of the predicted velocities [kg/(m³ s)].
#[derive(Resource, Debug, Default)]
pub struct DensityRates(pub Vec<f32>);

/// Inserts what the iteration needs. A head start is how many iterations the momentum counts as done ahead; below zero,
/// how many it begins later than it could, with the second.
pub fn install(world: &mut World, relaxation: f32, momentum: bool, head_start: i32) {
    let material = world.resource::<Material>();
    let eigenvalue = Lattice::of_material(material).largest_eigenvalue() as f32;
    let stable = if momentum {
        WITH_MOMENTUM
    } else {
        WITHOUT_MOMENTUM
    };
    world.insert_resource(Jacobi {
        relaxation: relaxation.min(stable / eigenvalue),
        momentum,
        head_start,
        ahead_from: 0,
        since: 0,
        carried: 0.0,
    });
    world.init_resource::<Iterates>();
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
    walls: Option<Res<WallSums>>,
    pairs: PairsWithSlopes,
    material: Res<Material>,
) {
    rates.0.resize(pairs.positions().rows(), 0.0);
    let walls = Walls::of(walls.as_deref());
    let pass = DensityRate::<false>::new(&material, &pairs.positions().0, &predicted.0, walls);
    pairs.sum(&pass, &mut rates.0);
}

/// Corrects the pressure terms by the predicted densities.
pub fn update_pressure(
    mut iterates: ResMut<Iterates>,
    mut positions: ResMut<Positions>,
    mut solve: ResMut<PressureSolve>,
    mut jacobi: ResMut<Jacobi>,
    recovery: Option<Res<RecoveryTime>>,
    means: Option<Res<MeanPressures>>,
    columns: (Res<Densities>, Res<DensityRates>, Res<Responses>),
    material: Res<Material>,
    clock: Res<Clock>,
    execution: Res<Execution>,
) {
    let (densities, rates, responses) = columns;
    let (dt, rest_density) = (clock.dt, material.rest_density);
    let to_term = 1.0 / (dt * dt);
    let first = solve.iterations == 0;
    if first {
        jacobi.start(means.is_some());
        iterates.0.resize(densities.0.len(), Iterate::default());
    }
    let left = |found: f32| {
        recovery.as_ref().map_or(0.0, |recovery| {
            rest_density * recovery.left_for_later(dt, found / rest_density)
        })
    };
    let (positions, iterates) = (&mut positions.0, &mut iterates.0);
    solve.update(positions, iterates, &execution, |row, term, iterate| {
        let found = densities.0[row] - rest_density;
        let error = found + dt * rates.0[row];
        let excess = error - left(found);
        let answer = (responses.0[row], to_term * excess);
        let (term, step) = jacobi.correct(iterate, term, answer, first);
        Corrected {
            term,
            error: error / rest_density,
            excess: excess / rest_density,
            progress: step * excess,
        }
    });
    jacobi.advance(solve.progress);
}

/// Takes the pressures of the terms that acted, `ρ² t` (phase `Pressure`): the last correction exerts no force.
pub fn take_pressures(
    mut pressures: ResMut<Pressures>,
    iterates: Res<Iterates>,
    densities: Res<Densities>,
    execution: Res<Execution>,
) {
    execution.for_each_chunk(&mut pressures.0, |first, pressures| {
        let columns = iterates.0[first..].iter().zip(&densities.0[first..]);
        for (pressure, (iterate, rho)) in pressures.iter_mut().zip(columns) {
            *pressure = rho * rho * iterate.acted;
        }
    });
}

/// Sums Dρ/Dt, in a pass `SHARED` with sums that take positions, or in its own.
///
/// In its own it sums `(v_i − v_j)·(x_i − x_j)` by components and those only at the end, so that no vector is
/// transposed: 19.9 ns a row for 22.4 with two threads, 16.2 for 18.9 where velocities are in a near cache. In a shared
/// pass positions are there in lanes, and to load them once more takes 2.6 ns.
#[derive(Clone, Copy)]
pub struct DensityRate<'a, const SHARED: bool> {
    positions: &'a [Vec4],
    velocities: &'a [Vec4],
    walls: Walls<'a>,
    rest_density: f32,
    /// m and the kernel's factor.
    factor: f32,
}

impl<'a, const SHARED: bool> DensityRate<'a, SHARED> {
    /// The sum over `velocities` at `positions`, which both end with a sentinel.
    pub fn new(
        material: &Material,
        positions: &'a [Vec4],
        velocities: &'a [Vec4],
        walls: Walls<'a>,
    ) -> Self {
        debug_assert_eq!(positions.len(), velocities.len(), "one entry a row");
        Self {
            positions,
            velocities,
            walls,
            rest_density: material.rest_density,
            factor: material.particle_mass * material.kernel.slope_factor,
        }
    }
}

/// A particle's position and velocity, and the sum.
pub struct DensityRateSums<S: Simd> {
    /// Its velocity for a shared pass: a neighbour in every lane.
    velocity: [S::F; 3],
    /// Its position and velocity for a pass of its own: a neighbour in each half.
    own: [S::F; 2],
    /// A number in every lane, or a vector in each half.
    sum: S::F,
    /// `Σ_b ρ0 V_b (v_i − v_b)·∇W_ib` [kg/(m³ s)].
    walls: f32,
}

impl<const SHARED: bool> PairSum for DensityRate<'_, SHARED> {
    type Sums<S: Simd> = DensityRateSums<S>;
    type Output = f32;
    const SLOPES_ALONE: bool = !SHARED;

    #[inline(always)]
    fn start<S: Simd>(&self, simd: S, i: usize, own: Vec4) -> DensityRateSums<S> {
        let velocity = self.velocities[i];
        DensityRateSums {
            velocity: broadcast(simd, velocity),
            own: [own, velocity].map(|vector| simd.splat_vector(vector)),
            sum: simd.splat(0.0),
            walls: self.rest_density * self.walls.rate(i, velocity.truncate()),
        }
    }

    #[inline(always)]
    fn fluid<S: Simd>(&self, simd: S, pair: &Pair<S>, j: S::Rows, sums: &mut DensityRateSums<S>) {
        sums.sum = if SHARED {
            let (v, _) = difference(simd, sums.velocity, self.velocities, j);
            simd.mul_add(pair.slope, dot(simd, v, pair.x), sums.sum)
        } else {
            let tables = [self.positions, self.velocities];
            simd.add_products(tables, sums.own, j, pair.slope, sums.sum)
        };
    }

    #[inline(always)]
    fn finish<S: Simd>(&self, simd: S, _: usize, sums: DensityRateSums<S>) -> f32 {
        let sum = if SHARED {
            simd.sum(sums.sum)
        } else {
            simd.sum_vectors(sums.sum)
        };
        self.factor * sum + sums.walls
    }
}
