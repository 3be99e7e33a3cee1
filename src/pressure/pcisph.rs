//! PCISPH (paper 5.2, Algorithm 2; Solenthaler & Pajarola 2009): corrects pressures until the predicted density is
//! near the rest density.
//!
//! Each iteration computes the pressure force, predicts velocities and positions, computes the density ρ* at the
//! predicted positions with the step's neighbour lists, and adds `δ (ρ* − ρ0)` to p, not below zero. At least three
//! iterations are done. `δ = 1/(β (|Σ_j ∇W_ij|² + Σ_j |∇W_ij|²))`, `β = 2 (m dt/ρ0)²`, for a full lattice.
//!
//! Deviations. Where a particle's own diagonal exceeds the lattice's, as beside walls, δ is divided by the ratio;
//! otherwise its update overshoots (see `docs/decisions/pcisph.md`). The step uses the prediction that met η, without
//! another correction. Warm start 0.8, momentum, `recovery` and a limit on the mean error are
//! added. Algorithm 2 unchanged: `warm_start: 0, momentum: false, recovery: 1, mean_density_error: None,
//! last_correction: true`.

use bevy_ecs::{
    prelude::*,
    schedule::{InternedScheduleLabel, ScheduleLabel},
};

use glam::Vec4;

use super::{
    density_rate::{DensityRates, PredictedVelocities, sum_rates},
    diagonal::{self, InverseDiagonals, lattice_diagonal},
    force::pressure_force,
    implicit::{self, Iterates, Jacobi, nearness, predict_positions, store_pressures},
    iterate::{LastCorrection, PressureIteration, solve_pressure},
    solver::{Iterations, PressureSolver, Requirement, iterations, take_tolerances},
    stabilisation::Stabilisation,
};
use crate::{
    boundary::direct_forcing,
    density::DensitySum,
    flow::HeldRows,
    pairs::{Pairs, PairsWithGradients},
    scene::{Pcisph, PressureMethod, Scene},
    state::{
        Clock, Column, Corrected, Densities, Execution, Material, Positions, PredictedPositions,
        PressureAccelerations, SolverState, Systems, wants_force,
    },
    time_step::RecoveryTime,
};

/// δ as a relaxation relative to a particle's own diagonal \[-]: δ assumes twice that of a full lattice.
const RELAXATION: f32 = 0.5;

/// Iteration from which on corrections have no momentum. Densities at predicted positions are not linear in the
/// pressures: with momentum, the pressures of two colliding particles may oscillate for ever.
const CALM_FROM: u32 = 500;

/// Head start of the momentum \[iterations], as in [`dfsph`](super::dfsph).
const HEAD_START: i32 = 10;

/// `δ dt²` of the scene's lattice.
#[derive(Resource, Debug, Clone, Copy)]
pub struct PressureCorrection {
    /// `δ dt²` \[Pa s²·m³/kg]: only dt changes δ.
    delta_dt_squared: f32,
    /// Whether the force of the last correction acts: Algorithm 2 unchanged.
    last: bool,
}

impl PressureCorrection {
    /// The correction for a lattice of this material.
    pub fn new(parameters: &Pcisph, material: &Material) -> Self {
        let diagonal = lattice_diagonal(material, Stabilisation(parameters.stabilisation));
        let beta =
            2.0 * (f64::from(material.particle_mass) / f64::from(material.rest_density)).powi(2);
        Self {
            delta_dt_squared: (1.0 / (beta * diagonal)) as f32,
            last: parameters.last_correction,
        }
    }

    /// Ratio of a row's diagonal to the one that δ assumes, at least 1 \[-].
    #[inline]
    fn inverse_diagonal(&self, diagonals: &InverseDiagonals, rest_density: f32, row: usize) -> f32 {
        let inverse = diagonals.0[row];
        if inverse > 0.0 {
            (self.delta_dt_squared / (rest_density * rest_density * inverse)).max(1.0)
        } else {
            1.0
        }
    }
}

/// Densities at the predicted positions ρ* \[kg/m³].
#[derive(Resource, Debug, Default)]
pub struct PredictedDensities(Vec<f32>);

impl PressureSolver for Pcisph {
    fn iterations(&self) -> Option<Iterations> {
        Some(iterations!(self, self.mean_density_error, false))
    }

    fn requirements(&self) -> Vec<Requirement> {
        let limit = self.mean_density_error.map(|limit| {
            Requirement::Error("pressure.mean_density_error", limit, "mean density error")
        });
        let stabilisation = Requirement::Stabilisation(self.stabilisation);
        limit.into_iter().chain([stabilisation]).collect()
    }

    fn with_tolerances_of(&self, other: &PressureMethod) -> PressureMethod {
        let mut method = *self;
        if let PressureMethod::Pcisph(of) = other {
            take_tolerances!(method, of);
            method.mean_density_error = of.mean_density_error;
        }
        PressureMethod::Pcisph(method)
    }

    fn columns(&self) -> &'static [Column] {
        const {
            &[
                Column::derived(
                    "predicted density",
                    "kg/m^3",
                    "at the predicted positions",
                    4,
                ),
                Column::derived("diagonal", "m^8/kg^2", "inverse diagonal", 4),
                Column::derived("pressure term", "Pa m^6/kg^2", "while it is solved for", 8),
                Column::derived(
                    "density rates",
                    "kg/(m^3 s)",
                    "of the initial solve: now and at the start",
                    8,
                ),
            ]
        }
    }

    fn install(&self, world: &mut World, _: &Scene) {
        let material = *world.resource::<Material>();
        world.insert_resource(PressureCorrection::new(self, &material));
        world.init_resource::<PredictedDensities>();
        let stabilisation = Stabilisation(self.stabilisation);
        implicit::install(world, RELAXATION, self.momentum, HEAD_START, stabilisation);
    }

    fn density(&self) -> Systems {
        diagonal::compute_density.into_configs()
    }

    fn solve(&self, _: &Scene) -> Systems {
        (solve_pressure, store_pressures).chain()
    }

    fn schedules(&self, scene: &Scene) -> Vec<(InternedScheduleLabel, Systems)> {
        let mut schedules = vec![(PressureIteration.intern(), iteration(scene))];
        if self.last_correction {
            schedules.push((LastCorrection.intern(), pressure_force.into_configs()));
        }
        schedules
    }
}

/// The systems of one iteration, in their order.
fn iteration(scene: &Scene) -> Systems {
    let predict = if scene.forces_directly() {
        (predict_positions, direct_forcing::correct_prediction).chain()
    } else {
        predict_positions.into_configs()
    };
    (
        pressure_force.run_if(wants_force),
        predict,
        predict_density,
        ease_held.run_if(resource_exists::<HeldRows>),
        sum_stabilisation.run_if(is_stabilised),
        update_pressure,
    )
        .chain()
}

fn predict_density(
    mut densities: ResMut<PredictedDensities>,
    predicted: Res<PredictedPositions>,
    pairs: Pairs,
    material: Res<Material>,
) {
    densities.0.resize(pairs.positions().rows(), 0.0);
    let pass = DensitySum::anywhere(&material);
    pairs.sum_ahead(&predicted.0, &pass, &mut densities.0);
}

/// As the densities of the step: particles that an emitter moves do not yield.
fn ease_held(
    mut densities: ResMut<PredictedDensities>,
    held: Res<HeldRows>,
    material: Res<Material>,
) {
    held.ease(&mut densities.0, material.rest_density);
}

fn is_stabilised(stabilisation: Res<Stabilisation>) -> bool {
    *stabilisation != Stabilisation::NONE
}

/// The part of Dρ/Dt that stabilisation alone makes: predicted densities have the rest.
fn sum_stabilisation(
    rates: ResMut<DensityRates>,
    mut predicted: ResMut<PredictedVelocities>,
    accelerations: Res<PressureAccelerations>,
    pairs: PairsWithGradients,
    material: Res<Material>,
    stabilisation: Res<Stabilisation>,
    clock: Res<Clock>,
) {
    let factor = -stabilisation.0 * clock.dt;
    let rows = accelerations.0.len();
    predicted.0.resize(rows + 1, Vec4::ZERO);
    predicted.0[rows] = Vec4::ZERO;
    pairs
        .execution
        .for_each_chunk(&mut predicted.0[..rows], |first, predicted| {
            for (u, a_p) in predicted.iter_mut().zip(&accelerations.0[first..]) {
                *u = (factor * *a_p).extend(0.0);
            }
        });
    let stabilised = stabilisation.of(&accelerations, clock.dt);
    sum_rates(rates, &predicted, None, &pairs, &material, stabilised);
}

fn update_pressure(
    mut iterates: ResMut<Iterates>,
    mut positions: ResMut<Positions>,
    mut solve: ResMut<SolverState>,
    mut jacobi: ResMut<Jacobi>,
    recovery: Option<Res<RecoveryTime>>,
    columns: (
        Res<Densities>,
        Res<PredictedDensities>,
        Res<InverseDiagonals>,
        Res<DensityRates>,
    ),
    forces: Res<PressureAccelerations>,
    stabilisation: Res<Stabilisation>,
    correction: Res<PressureCorrection>,
    material: Res<Material>,
    clock: Res<Clock>,
    execution: Res<Execution>,
) {
    let (densities, predicted, diagonals, rates) = columns;
    // Else the rates are those of the initial solve.
    let rates = is_stabilised(stabilisation).then_some(&rates.0);
    let rest_density = material.rest_density;
    let square = rest_density * rest_density;
    // Without the relaxation, which the iteration applies.
    let delta = correction.delta_dt_squared / (RELAXATION * square * clock.dt * clock.dt);
    let first = solve.iterations == 0;
    if first {
        jacobi.start(false);
        iterates.0.resize(predicted.0.len(), Default::default());
    }
    let to_remove = |found: f32| {
        recovery.as_ref().map_or(found, |recovery| {
            rest_density * recovery.removed(clock.dt, found / rest_density)
        })
    };
    let (positions, iterates) = (&mut positions.0, &mut iterates.0);
    solve.update(positions, iterates, &execution, |row, term, iterate| {
        let found = densities.0[row] - rest_density;
        let error =
            predicted.0[row] - rest_density + rates.map_or(0.0, |rates| clock.dt * rates[row]);
        let (change, removed) = (error - found, to_remove(found));
        let excess = change + removed;
        let inverse_diagonal = delta / correction.inverse_diagonal(&diagonals, rest_density, row);
        let (next, step) = jacobi.correct(iterate, term, (inverse_diagonal, excess), first);
        if correction.last {
            // The last correction exerts a force as well.
            iterate.acted = next;
        }
        Corrected {
            term: next,
            error: error / rest_density,
            excess: excess / rest_density,
            progress: if first {
                nearness(term, change + removed.max(0.0), clock.dt * forces.0[row])
            } else {
                step * excess
            },
        }
    });
    if solve.iterations < CALM_FROM {
        jacobi.advance(solve.progress);
    } else {
        jacobi.rest();
    }
}
