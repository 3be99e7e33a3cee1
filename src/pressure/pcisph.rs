//! PCISPH (paper 5.2, Algorithm 2; Solenthaler & Pajarola 2009): pressures are corrected until the predicted density is
//! near the rest density.
//!
//! Each iteration is one run of [`PressureIteration`](super::solve::PressureIteration): pressure force at the positions
//! of the step; predict velocity and position with it; density at the predicted positions, over the step's neighbour
//! lists with updated distances; `p += δ (ρ* − ρ0)`, not below zero. It ends when the density error is below η and
//! three iterations are done. `δ = 1/(β (|Σ_j ∇W_ij|² + Σ_j |∇W_ij|²))`, `β = 2 (m dt/ρ0)²`, for a particle of a full
//! lattice.
//!
//! Deviations. δ is made for a particle of a full lattice. One at the surface, most of all beside walls, answers its
//! own pressure more strongly, D of [`response`](super::response) against `2 m²` times the lattice's sums; where so,
//! its pressure swings between zero and too much, and which of the two acts is the parity of the iterations. There δ is
//! divided by that. In still water of 16 layers single particles jumped with 4 to 11 % of sqrt(g H) where only walls
//! were taken into account, in 24 runs that differ by rounding; now the fastest have 3.0 to 3.9 %, in 12. Nothing
//! changes elsewhere, nor do iterations and errors of a dam break.
//!
//! Algorithm 2 corrects pressure and force once more after the prediction that met η, so the state it steps to was
//! never predicted. In still water that was mostly harmless and now and then 20 to 30 % over the rest density. Here the
//! step goes to the prediction that met η: the limit holds, and the neighbours are processed once less. A scene that
//! wants Algorithm 2 to the letter says `last_correction: true` ([`Pcisph`]).
//!
//! Iterations start from 0.8 of the last pressures, their corrections have momentum, a step removes a part of the
//! compression that it finds ([`recovery`](super::recovery)), and the mean error is limited, too. Algorithm 2 to the
//! letter is `warm_start: 0, momentum: false, recovery: 1, mean_density_error: None, last_correction: true`.

use bevy_ecs::{
    prelude::*,
    schedule::{InternedScheduleLabel, ScheduleLabel},
};

use super::{
    convergence::Convergence,
    force::pressure_force,
    implicit::{self, Iterates, Jacobi, take_pressures},
    iterate::{LastCorrection, PressureIteration, solve_pressure},
    response::{self, Responses, lattice_response},
    solver::{Iterations, PressureSolver, Requirement},
    warm_start::WarmStart,
};
use crate::{
    boundary::direct_forcing,
    density::DensitySum,
    pairs::Pairs,
    scene::{Pcisph, Scene},
    state::{
        Accelerations, Clock, Column, Corrected, Densities, Execution, Material, Positions,
        PredictedPositions, PressureAccelerations, PressureSolve, Systems, Velocities, wants_force,
    },
    time_step::RecoveryTime,
};

/// δ as a relaxation of a particle's own answer [-]: it assumes twice that of a full lattice.
const RELAXATION: f32 = 0.5;

/// Iterations from which on corrections have no momentum. Densities at predicted positions are not linear in the
/// pressures: of two particles that meet momentum may go back and forth for ever.
const CALM_FROM: u32 = 500;

/// Iterations that the momentum is ahead by, as in [`dfsph`](super::dfsph).
const HEAD_START: i32 = 10;

/// `δ dt²` of the scene's lattice.
#[derive(Resource, Debug, Clone, Copy)]
pub struct PressureCorrection {
    /// `δ dt²` [Pa s²·m³/kg]: only dt changes δ.
    delta_dt_squared: f32,
    /// Whether the force of the last correction counts: Algorithm 2 to the letter.
    last: bool,
}

impl PressureCorrection {
    /// The correction for a lattice of this material.
    pub fn new(parameters: &Pcisph, material: &Material) -> Self {
        let response = lattice_response(material);
        let beta =
            2.0 * (f64::from(material.particle_mass) / f64::from(material.rest_density)).powi(2);
        Self {
            delta_dt_squared: (1.0 / (beta * response)) as f32,
            last: parameters.last_correction,
        }
    }

    /// How strongly a row answers its own pressure, in answers that δ assumes, at least 1.
    #[inline]
    fn answer(&self, responses: &Responses, rest_density: f32, row: usize) -> f32 {
        let inverse = responses.0[row];
        if inverse > 0.0 {
            (self.delta_dt_squared / (rest_density * rest_density * inverse)).max(1.0)
        } else {
            1.0
        }
    }
}

/// Densities at the predicted positions ρ* [kg/m³].
#[derive(Resource, Debug, Default)]
pub struct PredictedDensities(Vec<f32>);

impl PressureSolver for Pcisph {
    fn iterations(&self) -> Option<Iterations> {
        Some(Iterations {
            convergence: Convergence {
                max_density_error: self.max_density_error,
                criterion: self.criterion,
                mean_density_error: self.mean_density_error,
                min_iterations: self.min_iterations,
                max_iterations: self.max_iterations,
                not_converged: self.not_converged,
            },
            warm_start: WarmStart {
                share: self.warm_start,
                steps: self.warm_start_steps,
            },
            recovery: self.recovery,
            momentum: self.momentum,
        })
    }

    fn requirements(&self) -> Vec<Requirement> {
        let limit = self.mean_density_error;
        let limit = limit.map(|limit| {
            Requirement::Error("pressure.mean_density_error", limit, "mean density error")
        });
        limit.into_iter().collect()
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
                Column::derived(
                    "diagonal",
                    "m^8/kg^2",
                    "inverse response to the own pressure",
                    4,
                ),
                Column::derived("pressure term", "Pa m^6/kg^2", "while it is solved for", 8),
                Column::derived("density rate", "kg/(m^3 s)", "of the initial solve", 4),
            ]
        }
    }

    fn install(&self, world: &mut World) {
        let material = *world.resource::<Material>();
        world.insert_resource(PressureCorrection::new(self, &material));
        world.init_resource::<PredictedDensities>();
        implicit::install(world, RELAXATION, self.momentum, HEAD_START);
    }

    fn density(&self) -> Systems {
        response::compute_density.into_configs()
    }

    fn solve(&self, _: &Scene) -> Systems {
        (solve_pressure, take_pressures).chain()
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
        update_pressure,
    )
        .chain()
}

fn predict_positions(
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

fn update_pressure(
    mut iterates: ResMut<Iterates>,
    mut positions: ResMut<Positions>,
    mut solve: ResMut<PressureSolve>,
    mut jacobi: ResMut<Jacobi>,
    recovery: Option<Res<RecoveryTime>>,
    columns: (Res<Densities>, Res<PredictedDensities>, Res<Responses>),
    correction: Res<PressureCorrection>,
    material: Res<Material>,
    clock: Res<Clock>,
    execution: Res<Execution>,
) {
    let (densities, predicted, responses) = columns;
    let rest_density = material.rest_density;
    let square = rest_density * rest_density;
    // Without the relaxation, which is the iteration's.
    let delta = correction.delta_dt_squared / (RELAXATION * square * clock.dt * clock.dt);
    let first = solve.iterations == 0;
    if first {
        jacobi.start(false);
        iterates.0.resize(predicted.0.len(), Default::default());
    }
    let left = |found: f32| {
        recovery.as_ref().map_or(0.0, |recovery| {
            rest_density * recovery.left_for_later(clock.dt, found / rest_density)
        })
    };
    let (positions, iterates) = (&mut positions.0, &mut iterates.0);
    solve.update(positions, iterates, &execution, |row, term, iterate| {
        let found = densities.0[row] - rest_density;
        let error = predicted.0[row] - rest_density;
        let excess = error - left(found);
        let answer = delta / correction.answer(&responses, rest_density, row);
        let (term, step) = jacobi.correct(iterate, term, (answer, excess), first);
        if correction.last {
            // The last correction exerts a force, too.
            iterate.acted = term;
        }
        Corrected {
            term,
            error: error / rest_density,
            excess: excess / rest_density,
            progress: step * excess,
        }
    });
    if solve.iterations < CALM_FROM {
        jacobi.advance(solve.progress);
    } else {
        jacobi.rest();
    }
}
