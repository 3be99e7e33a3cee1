//! The linear system of IISPH and DFSPH, and its Jacobi iteration.
//!
//! For pressure terms `t = p/ρ²` and velocities v* without pressure, `ρ_i + dt Dρ_i/Dt(v* + dt a(t)) = ρ0` is linear
//! in t, with `Dρ_i/Dt(v) = Σ_j m (v_i − v_j)·∇W_ij + Σ_b ρ0 V_b (v_i − v_b)·∇W_ib`. Relaxed Jacobi: `t_i ← max(0,
//! t_i + ω (ρ*_i − ρ0)/(dt² D_i))` with D_i of [`diagonal`](super::diagonal).
//!
//! This is IISPH's iteration (Ihmsen et al. 2014) with `a_ii = −dt² D_i/ρ_i²`; its sums over d_ij are accelerations.
//! It is DFSPH's (Bender & Koschier 2015) with `α_i = ρ_i/D_i`, where the sum of the corrections is bounded instead of
//! each. Deviation: Nesterov momentum with restarts, 4869 instead of 6761 iterations in a dam break;
//! `docs/decisions/momentum.md` has the stability limit and more figures.

use bevy_ecs::prelude::*;
use glam::Vec3;

use super::{
    density_rate::{DensityRates, PredictedVelocities, predict_rates},
    diagonal::InverseDiagonals,
    force::pressure_force,
    stabilisation::Stabilisation,
};
use crate::{
    lattice::Lattice,
    state::{
        Accelerations, Clock, Column, Corrected, Densities, Execution, Material, MeanPressures,
        Positions, PredictedPositions, PressureAccelerations, Pressures, Remembers, SolverState,
        Systems, Velocities, wants_force,
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
    Column::derived("diagonal", "m^8/kg^2", "inverse diagonal", 4),
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

/// Largest ω that a scene may request with momentum. On lattices that it would make unstable, less is used.
pub const MAX_RELAXATION_WITH_MOMENTUM: f32 = 0.54;

/// Largest ω with momentum from the first iteration on. If both are large, a few iterations amplify short waves, and
/// mean pressures carry these between steps.
///
/// Tuned on: corner dam break of 130 000 particles, DFSPH, at 1 % with two to six iterations and at 0.01 %: stable
/// with 0.36 to 0.42; unstable with 0.45 at 0.01 %, and with 0.5 also with three iterations.
const MAX_RELAXATION_AT_ONCE: f32 = 0.42;

/// Largest product of relaxation and the largest eigenvalue of the scene's lattice \[-]: nine tenths of the stability
/// limits, which are 4/3 with momentum and 2 without.
const WITH_MOMENTUM: f32 = 1.2;
const WITHOUT_MOMENTUM: f32 = 1.8;

/// Smallest factor on the relaxation \[-].
const LEAST_DAMPING: f32 = 0.125;

/// Growth of that factor from solve to solve \[-]: what has made a solve unstable lasts for some steps.
const DAMPING_GROWTH: f32 = 1.02;

/// Part of the pressure with which the lattice is stable that begins an impact \[-]. The time step is chosen for a
/// quarter of that pressure (`time_step::limits`), and pressures of ordinary steps hardly grow to twice theirs.
const IMPACT: f32 = 0.5;

/// Largest `dt² p/ρ` \[m²] that is no [impact](super::impact).
#[derive(Resource, Debug, Clone, Copy, PartialEq)]
pub(super) struct ImpactLimit(pub(super) f32);

/// The iteration's parameters, and its momentum.
#[derive(Resource, Debug, Clone, Copy)]
pub struct Jacobi {
    /// Relaxation ω \[-].
    relaxation: f32,
    /// Factor on ω \[-], below 1 after a solve whose errors stopped falling.
    damping: f32,
    /// Whether corrections have momentum.
    momentum: bool,
    /// Head start of the momentum \[iterations]; negative values delay it.
    head_start: i32,
    /// Number of iterations of this solve before the head start applies.
    ahead_from: u32,
    /// Number of iterations since the last restart of the momentum.
    since: u32,
    /// Momentum coefficient: share of the last correction that is added to the next.
    carried: f32,
    /// Least term: 0, or that of the largest tension.
    pub(super) least: f32,
}

/// A pressure term during the solve.
#[derive(Debug, Clone, Copy, Default)]
pub struct Iterate {
    /// The term whose force acted last.
    pub(crate) acted: f32,
    /// Its corrected value, before momentum.
    corrected: f32,
}

/// The terms of the density solve.
#[derive(Resource, Debug, Default)]
pub struct Iterates(pub(crate) Vec<Iterate>);

impl Iterates {
    /// The terms whose force acted last, by row.
    pub fn acted(&self) -> impl Iterator<Item = f32> {
        self.0.iter().map(|term| term.acted)
    }
}

impl Remembers for Jacobi {
    type State = f32;

    fn state(&self, _: &[Entity]) -> f32 {
        self.damping
    }

    fn set_state(&mut self, damping: f32, _: &[Entity]) -> Result<(), &'static str> {
        self.damping = damping;
        Ok(())
    }
}

impl Jacobi {
    /// Corrects a term by the remaining error and the inverse diagonal. Returns the next term and the change of the
    /// corrected value.
    ///
    /// With momentum the next term is `t_k + k/(k + 3) (t_k − t_{k−1})` (Nesterov 1983).
    #[inline]
    pub(super) fn correct(
        &self,
        iterate: &mut Iterate,
        acted: f32,
        (diagonal, error): (f32, f32),
        first: bool,
    ) -> (f32, f32) {
        let before = if first { acted } else { iterate.corrected };
        let corrected = if diagonal > 0.0 {
            (acted + self.damping * self.relaxation * diagonal * error).max(self.least)
        } else {
            // Pressure has no effect on this particle.
            0.0
        };
        *iterate = Iterate { acted, corrected };
        let step = corrected - before;
        ((corrected + self.carried * step).max(self.least), step)
    }

    /// Whether terms that start below their solution may exceed it.
    pub(super) fn overshoots(&self) -> bool {
        self.momentum
    }

    /// Called before the first iteration of a solve. The head start applies at once if the solve starts from means and
    /// the relaxation is small enough; otherwise from the third iteration on.
    pub(super) fn start(&mut self, from_means: bool) {
        let at_once = from_means && self.relaxation <= MAX_RELAXATION_AT_ONCE;
        self.ahead_from = if at_once { 0 } else { 2 };
        self.damping = (DAMPING_GROWTH * self.damping).min(1.0);
        self.count(0);
    }

    /// Called if the errors have stopped falling: halves the relaxation, down to [`LEAST_DAMPING`]. Returns whether it
    /// could.
    ///
    /// ω is stable on lattices. Where particles have come close to each other, eigenvalues are larger.
    pub(super) fn damp(&mut self) -> bool {
        if self.damping <= LEAST_DAMPING {
            return false;
        }
        self.damping *= 0.5;
        self.rest();
        true
    }

    /// Called after an iteration with the sum of change times error: momentum restarts if it opposes the errors
    /// (O'Donoghue & Candès 2015).
    pub(super) fn advance(&mut self, progress: f64) {
        self.count(if progress < 0.0 { 0 } else { self.since + 1 });
    }

    /// Restarts the momentum.
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

/// Inserts the resources of the iteration. A negative head start delays the momentum.
pub fn install(
    world: &mut World,
    relaxation: f32,
    momentum: bool,
    head_start: i32,
    stabilisation: Stabilisation,
) {
    let material = world.resource::<Material>();
    let kernel = &material.kernel;
    let support = kernel.support_radius / material.spacing;
    let lattice = Lattice::new(kernel.function, material.dimension, support);
    let longest_way = lattice.pressure_step() as f32 * material.spacing;
    let eigenvalue = lattice.largest_eigenvalue(stabilisation.0.into()) as f32;
    let stable = if momentum {
        WITH_MOMENTUM
    } else {
        WITHOUT_MOMENTUM
    };
    world.insert_resource(Jacobi {
        relaxation: relaxation.min(stable / eigenvalue),
        damping: 1.0,
        momentum,
        head_start,
        ahead_from: 0,
        since: 0,
        carried: 0.0,
        least: 0.0,
    });
    world.insert_resource(ImpactLimit(IMPACT * longest_way.powi(2)));
    world.insert_resource(stabilisation);
    world.init_resource::<Iterates>();
    world.init_resource::<InverseDiagonals>();
    world.init_resource::<PredictedVelocities>();
    world.init_resource::<DensityRates>();
}

/// `v + dt a` with all accelerations; of those of pressure, the share that stabilisation leaves.
pub fn predict_velocities(
    mut predicted: ResMut<PredictedVelocities>,
    velocities: Res<Velocities>,
    accelerations: Res<Accelerations>,
    pressure_accelerations: Res<PressureAccelerations>,
    stabilisation: Res<Stabilisation>,
    clock: Res<Clock>,
    execution: Res<Execution>,
) {
    let (dt, share) = (clock.dt, 1.0 - stabilisation.0);
    let accelerations = &accelerations.0;
    predicted.write(
        &velocities,
        &pressure_accelerations,
        &execution,
        |row, a_p| dt * (accelerations[row] + share * a_p),
    );
}

/// `x + dt (v + dt a)` with all accelerations.
pub(super) fn predict_positions(
    mut predicted: ResMut<PredictedPositions>,
    positions: Res<Positions>,
    velocities: Res<Velocities>,
    accelerations: Res<Accelerations>,
    pressure_accelerations: Res<PressureAccelerations>,
    clock: Res<Clock>,
    execution: Res<Execution>,
) {
    let dt = clock.dt;
    let rows = positions.rows();
    execution.for_each_chunk(&mut predicted.0[..rows], |first, predicted| {
        let state = positions.0[first..].iter().zip(&velocities.0[first..]);
        let forces = accelerations.0[first..]
            .iter()
            .zip(&pressure_accelerations.0[first..]);
        for ((predicted, (x, v)), (a, a_p)) in predicted.iter_mut().zip(state).zip(forces) {
            let velocity = v.truncate() + dt * (*a + *a_p);
            *predicted = (x.truncate() + dt * velocity).extend(0.0);
        }
    });
}

/// How much nearer the solution than none the initial term t of a row is, if it has to balance `compression` \[kg/m³]
/// and its force changes velocities by `change` \[m/s]; the sum over all rows counts.
///
/// The solution is the minimum of `φ(t) = tᵀAt/2 − tᵀb`, with the system's matrix A and the compression b that is there
/// without pressure. Divergence and pressure force are adjoint: `tᵀAt = Σ |dt a|²`. What is left is `b − At`, and this
/// is `φ(0) − φ(t)`; without compression at the start, it is the kinetic energy that the pressures take away.
#[inline]
pub(super) fn nearness(term: f32, compression: f32, change: Vec3) -> f32 {
    term * compression + 0.5 * change.length_squared()
}

/// Corrects the pressure terms by the predicted densities.
pub fn update_pressure(
    mut iterates: ResMut<Iterates>,
    mut positions: ResMut<Positions>,
    mut solve: ResMut<SolverState>,
    mut jacobi: ResMut<Jacobi>,
    recovery: Option<Res<RecoveryTime>>,
    means: Option<Res<MeanPressures>>,
    columns: (Res<Densities>, Res<DensityRates>, Res<InverseDiagonals>),
    forces: Res<PressureAccelerations>,
    material: Res<Material>,
    clock: Res<Clock>,
    execution: Res<Execution>,
) {
    let (densities, rates, diagonals) = columns;
    let (dt, rest_density) = (clock.dt, material.rest_density);
    let to_term = 1.0 / (dt * dt);
    let first = solve.iterations == 0;
    if first {
        jacobi.start(means.is_some());
        iterates.0.resize(densities.0.len(), Iterate::default());
    }
    let to_remove = |found: f32| {
        recovery.as_ref().map_or(found, |recovery| {
            rest_density * recovery.removed(dt, found / rest_density)
        })
    };
    let (positions, iterates) = (&mut positions.0, &mut iterates.0);
    solve.update(positions, iterates, &execution, |row, term, iterate| {
        let found = densities.0[row] - rest_density;
        let change = dt * rates.0[row];
        let error = found + change;
        let removed = to_remove(found);
        let excess = change + removed;
        let inverse_diagonal = (diagonals.0[row], to_term * excess);
        let (next, step) = jacobi.correct(iterate, term, inverse_diagonal, first);
        Corrected {
            term: next,
            error: error / rest_density,
            excess: excess / rest_density,
            progress: if first {
                nearness(term, change + removed.max(0.0), dt * forces.0[row])
            } else {
                step * excess
            },
        }
    });
    jacobi.advance(solve.progress);
}

/// Stores the pressures of the terms that acted, `ρ² t` (phase `Pressure`): the last correction exerts no force.
pub fn store_pressures(
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
    execution.share(&mut pressures.0);
}
