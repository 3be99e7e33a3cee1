//! DFSPH (Bender & Koschier 2015, *Divergence-Free SPH*; 2017): a divergence solve before the forces, and a density
//! solve after them. Both are the Jacobi iteration of [`implicit`].
//!
//! [`solve_divergence`] (their Algorithm 2) solves `Dρ_i/Dt(v + dv(τ)) ≤ 0` for impulses τ = dt p/ρ²; the density
//! solve (their Algorithm 3) is IISPH's. A particle's pressure is the sum of both.
//!
//! Deviations. The divergence solve runs at the start of a step, where the neighbours are found, and starts from zero.
//! Single corrections may be negative as long as their sum is not; iterations are relaxed and have momentum, since the
//! paper's ω = 1 lets the shortest waves grow. The density solve starts from a share of the last pressures of both
//! solves ([`warm_start`](super::warm_start)) and also limits densities that are too low (see
//! [`solve`](super::convergence)), so a dam break gains no energy for any share.

use std::mem;

use bevy_ecs::{
    prelude::*,
    schedule::{InternedScheduleLabel, ScheduleLabel},
};

use super::{
    convergence::Convergence,
    density_rate::{DensityRate, DensityRates, PredictedVelocities, sum_rates},
    diagonal::{DensitiesAndDiagonals, InverseDiagonals},
    force::pressure_force,
    implicit::{self, Iterate, Jacobi, store_pressures},
    iterate::{End, PressureIteration, iterate, solve_pressure},
    neighbour_count::{NeighbourCount, NeighbourCounts, NeighboursWithin},
    solver::{Iterations, PressureSolver, Requirement, iterations, take_tolerances},
    stabilisation::Stabilisation,
};
use crate::{
    boundary::sums::{BoundarySums, Walls},
    neighbours::KeptLists,
    pairs::{KernelGradients, Pairs, PairsWithGradients, store, zip},
    scene::{Dfsph, Dimension, PressureMethod, Scene},
    state::{
        Clock, Column, Corrected, Densities, Execution, Material, Positions, PressureAccelerations,
        Pressures, SolverState, Systems, Velocities, wants_force,
    },
    time_step::MOST_MISSING,
};

impl PressureSolver for Dfsph {
    fn iterations(&self) -> Option<Iterations> {
        Some(iterations!(self, None, true))
    }

    fn requirements(&self) -> Vec<Requirement> {
        vec![
            Requirement::Relaxation("pressure.relaxation", self.relaxation, self.momentum),
            Requirement::Stabilisation(self.stabilisation),
            Requirement::Error(
                "pressure.max_divergence_error",
                self.max_divergence_error,
                "compression that is left in the velocities of a step",
            ),
            Requirement::Iterations(
                "pressure.max_divergence_iterations",
                self.min_divergence_iterations,
                self.max_divergence_iterations,
            ),
        ]
    }

    fn with_tolerances_of(&self, other: &PressureMethod) -> PressureMethod {
        let mut method = *self;
        if let PressureMethod::Dfsph(of) = other {
            take_tolerances!(method, of);
            method.max_divergence_error = of.max_divergence_error;
            method.min_divergence_iterations = of.min_divergence_iterations;
            method.max_divergence_iterations = of.max_divergence_iterations;
        }
        PressureMethod::Dfsph(method)
    }

    fn columns(&self) -> &'static [Column] {
        const {
            let [a, b, c, d] = *implicit::COLUMNS;
            &[
                a,
                b,
                c,
                d,
                Column::derived(
                    "divergence impulse",
                    "Pa s m^6/kg^2",
                    "of the divergence solve",
                    8,
                ),
                Column::derived("neighbour count", "-", "fluid and boundary", 4),
            ]
        }
    }

    fn install(&self, world: &mut World, _: &Scene) {
        let stabilisation = Stabilisation(self.stabilisation);
        implicit::install(
            world,
            self.relaxation,
            self.momentum,
            HEAD_START,
            stabilisation,
        );
        world.init_resource::<NeighbourCounts>();
        world.init_resource::<DivergenceTerms>();
        self.set_tolerances(world);
    }

    fn set_tolerances(&self, world: &mut World) {
        if let Some(iterations) = self.iterations() {
            world.insert_resource(iterations.convergence);
        }
        world.insert_resource(DivergenceConvergence(Convergence {
            max_density_error: self.max_divergence_error,
            mean_density_error: None,
            criterion: self.criterion,
            // The first iteration measures the divergence of the given velocities; no force acts yet.
            min_iterations: self.min_divergence_iterations.saturating_add(1),
            max_iterations: self.max_divergence_iterations.saturating_add(1),
            not_converged: self.not_converged,
        }));
    }

    fn density(&self) -> Systems {
        compute_density.into_configs()
    }

    fn divergence(&self) -> Option<Systems> {
        Some(solve_divergence.into_configs())
    }

    fn solve(&self, _: &Scene) -> Systems {
        (solve_pressure, store_pressures, add_divergence_pressure).chain()
    }

    fn schedules(&self, _: &Scene) -> Vec<(InternedScheduleLabel, Systems)> {
        vec![
            (DivergenceIteration.intern(), divergence_iteration()),
            (PressureIteration.intern(), implicit::iteration()),
        ]
    }
}

/// One iteration of the divergence solve: measures the divergence of the predicted velocities and corrects the
/// impulses.
#[derive(ScheduleLabel, Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct DivergenceIteration;

/// Head start of the momentum \[iterations], from the second iteration on, or from the first if the solve starts from
/// mean pressures. The density error left between steps is a long wave, which iterations without momentum hardly
/// reduce.
///
/// Tuned on: corner dam break of 130 000 particles, 0.5 s in steps of 1 ms at 0.01 %: 11.4 iterations per step with 0,
/// 9.1 with 10. From the first iteration on it would be 8.1, but solves of two iterations then leave more divergence
/// than they remove: still water moves with 0.28 % of sqrt(g H) instead of 0.16 %, with IISPH 3 %.
const HEAD_START: i32 = 10;

/// Convergence criterion of the divergence solve.
#[derive(Resource, Debug, Clone, Copy)]
pub struct DivergenceConvergence(Convergence);

/// Impulses of the divergence solve, as pressure terms times dt \[Pa s·m⁶/kg²].
#[derive(Resource, Debug, Default)]
pub struct DivergenceTerms(Vec<Iterate>);

/// Largest compression within the step \[-] of velocities that the divergence solve corrects. With more of it, rates
/// say nothing of the step's end: rows of a block that falls onto a floor would evade it into each other and into the
/// floor. The density solve stops them, in a shorter step.
const MOST_RATE: f32 = 0.05;

/// Particles with fewer neighbours keep their divergence: at a surface or in spray, Dρ/Dt describes how particles meet
/// and not their compression (2015, section 3.4).
fn least_neighbours(dimension: Dimension) -> u32 {
    match dimension {
        Dimension::Two => 7,
        Dimension::Three => 20,
    }
}

/// The systems of [`DivergenceIteration`], in their order.
fn divergence_iteration() -> Systems {
    (
        (
            pressure_force,
            predict_corrected_velocities,
            predict_corrected_rates,
        )
            .chain()
            .run_if(wants_force),
        update_impulses,
    )
        .chain()
}

/// Densities, inverse diagonals and Dρ/Dt (phase `Density`).
pub fn compute_density(
    mut columns: DensitiesAndDiagonals,
    mut rates: ResMut<DensityRates>,
    mut counts: ResMut<NeighbourCounts>,
    mut grad_factors: Option<ResMut<KernelGradients>>,
    velocities: Res<Velocities>,
    walls: Option<Res<BoundarySums>>,
    pairs: Pairs,
    material: Res<Material>,
    (stabilisation, kept): (Res<Stabilisation>, Option<Res<KeptLists>>),
) {
    let has_skin = kept.is_some();
    let rows = pairs.positions().rows();
    rates.0.resize(rows, 0.0);
    counts.0.resize(rows, 0);
    let walls = Walls::of(walls.as_deref());
    let densities = DensitiesAndDiagonals::sums(&material, walls, *stabilisation);
    let rate = DensityRate::<true>::new(&material, &pairs.positions().0, &velocities.0, walls);
    let motion = zip(store(&mut rates.0), store(&mut counts.0));
    let sinks = zip(columns.sinks(rows), motion);
    let grad_factors = grad_factors.as_deref_mut();
    if has_skin {
        let within = NeighboursWithin::new(&material);
        pairs.sum_and_keep(&(densities, (rate, within)), grad_factors, sinks);
    } else {
        pairs.sum_and_keep(&(densities, (rate, NeighbourCount)), grad_factors, sinks);
    }
}

/// Makes the velocities free of compression (phase `Forces`, before the forces).
pub fn solve_divergence(world: &mut World) {
    let rows = world.resource::<Positions>().rows();
    let mut terms = world.resource_mut::<DivergenceTerms>();
    terms.0.clear();
    terms.0.resize(rows, Iterate::default());
    let overshoots = world.resource::<Jacobi>().overshoots();
    world.resource_mut::<SolverState>().begin(false, overshoots);
    let convergence = world.resource::<DivergenceConvergence>().0;
    let measuring = Convergence {
        max_iterations: 1,
        ..convergence
    };
    let patience = convergence.max_iterations;
    let end = iterate(world, DivergenceIteration, &measuring, patience, true);
    let largest = world.resource::<SolverState>().error.largest;
    if end != End::Converged && largest <= MOST_RATE {
        iterate(world, DivergenceIteration, &convergence, patience, true);
    }
    let mut solve = world.resource_mut::<SolverState>();
    solve.divergence_iterations = solve.iterations - 1;
    if solve.divergence_iterations > 0 {
        let Stabilisation(share) = *world.resource::<Stabilisation>();
        let mut velocities = mem::take(&mut world.resource_mut::<Velocities>().0);
        mem::swap(
            &mut velocities,
            &mut world.resource_mut::<PredictedVelocities>().0,
        );
        if share > 0.0 {
            // Those of the sums lack this share of the change.
            let changes = &world.resource::<PressureAccelerations>().0;
            let rows = changes.len();
            let execution = world.resource::<Execution>();
            execution.for_each_chunk(&mut velocities[..rows], |first, velocities| {
                for (v, dv) in velocities.iter_mut().zip(&changes[first..]) {
                    *v += (share * *dv).extend(0.0);
                }
            });
        }
        world.resource_mut::<Velocities>().0 = velocities;
    }
}

fn predict_corrected_velocities(
    mut predicted: ResMut<PredictedVelocities>,
    velocities: Res<Velocities>,
    pressure_accelerations: Res<PressureAccelerations>,
    stabilisation: Res<Stabilisation>,
    execution: Res<Execution>,
) {
    // The force of an impulse is a change of velocity.
    let share = 1.0 - stabilisation.0;
    predicted.write(&velocities, &pressure_accelerations, &execution, |_, dv| {
        share * dv
    });
}

fn predict_corrected_rates(
    rates: ResMut<DensityRates>,
    predicted: Res<PredictedVelocities>,
    changes: Res<PressureAccelerations>,
    walls: Option<Res<BoundarySums>>,
    pairs: PairsWithGradients,
    material: Res<Material>,
    stabilisation: Res<Stabilisation>,
) {
    let stabilised = stabilisation.of(&changes, 1.0);
    sum_rates(rates, &predicted, walls, &pairs, &material, stabilised);
}

fn update_impulses(
    mut terms: ResMut<DivergenceTerms>,
    mut positions: ResMut<Positions>,
    mut solve: ResMut<SolverState>,
    columns: (
        Res<NeighbourCounts>,
        Res<DensityRates>,
        Res<InverseDiagonals>,
        Res<Densities>,
    ),
    mut jacobi: ResMut<Jacobi>,
    material: Res<Material>,
    clock: Res<Clock>,
    execution: Res<Execution>,
) {
    let (counts, rates, diagonals, densities) = columns;
    let full = (1.0 - MOST_MISSING) * material.rest_density;
    let least = least_neighbours(material.dimension);
    let to_error = clock.dt / material.rest_density;
    let first = solve.iterations == 0;
    if first {
        jacobi.start(false);
    }
    let (positions, terms) = (&mut positions.0, &mut terms.0);
    solve.update(positions, terms, &execution, |row, term, impulse| {
        let rate = if counts.0[row] < least {
            0.0
        } else {
            // What is missing may be filled within the step, as in the density solve.
            rates.0[row] - (full - densities.0[row]).max(0.0) / clock.dt
        };
        // Before the first correction, the positions still carry the terms of the last step.
        let acted = if first { 0.0 } else { term };
        let (term, step) = jacobi.correct(impulse, acted, (diagonals.0[row], rate), first);
        Corrected {
            term,
            error: to_error * rate,
            excess: to_error * rate,
            progress: step * rate,
        }
    });
    jacobi.advance(solve.progress);
}

/// Adds the pressures that the impulses correspond to, `ρ² τ/dt`, to those of the density solve (phase `Pressure`),
/// and resets the impulses: an order may skip the divergence solve in the next step.
pub fn add_divergence_pressure(
    mut pressures: ResMut<Pressures>,
    mut terms: ResMut<DivergenceTerms>,
    densities: Res<Densities>,
    clock: Res<Clock>,
    execution: Res<Execution>,
) {
    let impulses = &terms.0;
    execution.for_each_chunk(&mut pressures.0, |first, pressures| {
        let impulses = impulses.get(first..).unwrap_or_default();
        let columns = impulses.iter().zip(&densities.0[first..]);
        for (pressure, (impulse, rho)) in pressures.iter_mut().zip(columns) {
            *pressure += rho * rho * impulse.acted / clock.dt;
        }
    });
    terms.0.clear();
}
