//! DFSPH (Bender & Koschier 2015, *Divergence-Free SPH*; 2017): the velocities are freed of compression before the
//! forces act on them, and then of the density error that they would lead to.
//!
//! Both solves are the Jacobi iteration of [`implicit`]. The first ([`solve_divergence`], their Algorithm 2) solves
//! `Dρ_i/Dt(v + dv(τ)) ≤ 0` for impulses τ = dt p/ρ² and changes the velocities of the step; the second (their
//! Algorithm 3) is IISPH's. Density, diagonal and Dρ/Dt of the velocities come from one pass over the neighbours, so
//! that velocities without much divergence cost nothing more. The pressure of a particle is that of both.
//!
//! Deviations. The solves follow each other in another place of the loop: neighbours are found at the start of a step,
//! so what is the end of the paper's is the start of ours. A correction may be taken back by a later one, as long as
//! the sum does not pull: with every correction bounded by itself, an overshoot stays. So the iteration is relaxed, and
//! has momentum: the ω = 1 of the paper lets the shortest waves grow (see [`implicit`]). The divergence solve starts
//! from zero: what a step has to remove has little to do with what the last one removed. Particles keep the pressures
//! of both solves together, and the second starts from a share of those before (see
//! [`warm_start`](super::warm_start)). A dam break gains no energy by that, whatever the share, since too little density is
//! judged too (see [`solve`](super::solve)).

use std::mem;

use bevy_ecs::{
    prelude::*,
    schedule::{InternedScheduleLabel, ScheduleLabel},
};
use glam::Vec4;

use super::{
    convergence::Convergence,
    force::pressure_force,
    implicit::{
        self, DensityRate, DensityRates, Iterate, Jacobi, PredictedVelocities, predict_rates,
        take_pressures,
    },
    iterate::{PressureIteration, iterate, solve_pressure},
    response::{AnsweringDensities, Responses},
    solver::{Iterations, PressureSolver, Requirement},
    warm_start::WarmStart,
};
use crate::{
    boundary::sums::{WallSums, Walls},
    pairs::{PairSlopes, PairSum, Pairs, both, putting},
    scene::{Dfsph, Dimension, Scene},
    simd::Simd,
    state::{
        Clock, Column, Corrected, Densities, Execution, Material, Positions, PressureAccelerations,
        PressureSolve, Pressures, Systems, Velocities, wants_force,
    },
};

impl PressureSolver for Dfsph {
    fn iterations(&self) -> Option<Iterations> {
        Some(Iterations {
            convergence: Convergence {
                max_density_error: self.max_density_error,
                criterion: self.criterion,
                mean_density_error: None,
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
        vec![
            Requirement::Relaxation("pressure.relaxation", self.relaxation, self.momentum),
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

    fn install(&self, world: &mut World) {
        implicit::install(world, self.relaxation, self.momentum, HEAD_START);
        world.init_resource::<NeighbourCounts>();
        world.init_resource::<DivergenceTerms>();
        world.insert_resource(DivergenceConvergence(Convergence {
            max_density_error: self.max_divergence_error,
            mean_density_error: None,
            criterion: self.criterion,
            // The first measures the velocities as they are, without a force.
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
        (solve_pressure, take_pressures, add_divergence_pressure).chain()
    }

    fn schedules(&self, _: &Scene) -> Vec<(InternedScheduleLabel, Systems)> {
        vec![
            (DivergenceIteration.intern(), divergence_iteration()),
            (PressureIteration.intern(), implicit::iteration()),
        ]
    }
}

/// One iteration of the divergence solve: it measures the divergence of the predicted velocities and corrects the
/// impulses.
#[derive(ScheduleLabel, Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct DivergenceIteration;

/// Iterations that the momentum is ahead by, after the second, or at once if the solve starts from means. The density
/// error that is left from step to step is a long wave, which first iterations without momentum hardly touch. The
/// corner dam break of 130 000 particles, 0.5 s in steps of 1 ms at 0.01 %, takes 11.4 iterations a step at 0 and 9.1
/// at 10. From the first iteration on it takes 8.1, but what ends at two, as steps do at 1 %, then leaves more
/// divergence than it removed, and still water moves with 0.28 % of sqrt(g H), not 0.16. IISPH, which iterates three or
/// four times, cannot have it: its still water moves with 3 % of sqrt(g H).
const HEAD_START: i32 = 10;

/// When the divergence solve ends.
#[derive(Resource, Debug, Clone, Copy)]
pub struct DivergenceConvergence(Convergence);

/// Impulses of the divergence solve, as pressure terms times dt [Pa s·m⁶/kg²].
#[derive(Resource, Debug, Default)]
pub struct DivergenceTerms(Vec<Iterate>);

/// Numbers of neighbours, fluid and boundary.
#[derive(Resource, Debug, Default)]
pub struct NeighbourCounts(Vec<u32>);

/// Neighbours below which a particle keeps its divergence: at a surface, or in spray, Dρ/Dt says how the particle meets
/// others and not that it is compressed (2015, section 3.4).
fn least_neighbours(dimension: Dimension) -> u32 {
    match dimension {
        Dimension::Two => 7,
        Dimension::Three => 20,
    }
}

/// The systems of [`DivergenceIteration`], in their order.
fn divergence_iteration() -> Systems {
    (
        (pressure_force, predict_corrected_velocities, predict_rates)
            .chain()
            .run_if(wants_force),
        update_impulses,
    )
        .chain()
}

/// Densities, what the particles answer to their pressure, and Dρ/Dt of their velocities (phase `Density`).
pub fn compute_density(
    mut columns: AnsweringDensities,
    mut rates: ResMut<DensityRates>,
    mut counts: ResMut<NeighbourCounts>,
    mut slopes: Option<ResMut<PairSlopes>>,
    velocities: Res<Velocities>,
    walls: Option<Res<WallSums>>,
    pairs: Pairs,
    material: Res<Material>,
) {
    let rows = pairs.positions().rows();
    rates.0.resize(rows, 0.0);
    counts.0.resize(rows, 0);
    let walls = Walls::of(walls.as_deref());
    let sums = (
        AnsweringDensities::sums(&material, walls),
        (
            DensityRate::<true>::new(&material, &pairs.positions().0, &velocities.0, walls),
            NeighbourCount,
        ),
    );
    let motion = both(putting(&mut rates.0), putting(&mut counts.0));
    let takers = both(columns.takers(rows), motion);
    pairs.sum_and_keep(&sums, slopes.as_deref_mut(), takers);
}

/// Frees the velocities of compression (phase `Forces`, before the forces).
pub fn solve_divergence(world: &mut World) {
    let rows = world.resource::<Positions>().rows();
    let mut terms = world.resource_mut::<DivergenceTerms>();
    terms.0.clear();
    terms.0.resize(rows, Iterate::default());
    let overshoots = world.resource::<Jacobi>().overshoots();
    world
        .resource_mut::<PressureSolve>()
        .begin(false, overshoots);
    let convergence = world.resource::<DivergenceConvergence>().0;
    let patience = convergence.max_iterations;
    iterate(world, DivergenceIteration, &convergence, patience);
    let mut solve = world.resource_mut::<PressureSolve>();
    solve.divergence_iterations = solve.iterations - 1;
    if solve.divergence_iterations > 0 {
        let mut velocities = mem::take(&mut world.resource_mut::<Velocities>().0);
        mem::swap(
            &mut velocities,
            &mut world.resource_mut::<PredictedVelocities>().0,
        );
        world.resource_mut::<Velocities>().0 = velocities;
    }
}

fn predict_corrected_velocities(
    mut predicted: ResMut<PredictedVelocities>,
    velocities: Res<Velocities>,
    pressure_accelerations: Res<PressureAccelerations>,
    execution: Res<Execution>,
) {
    // Of an impulse the force is a change of velocity.
    predicted.write(&velocities, &pressure_accelerations, &execution, |_, dv| dv);
}

fn update_impulses(
    mut terms: ResMut<DivergenceTerms>,
    mut positions: ResMut<Positions>,
    mut solve: ResMut<PressureSolve>,
    columns: (Res<NeighbourCounts>, Res<DensityRates>, Res<Responses>),
    mut jacobi: ResMut<Jacobi>,
    material: Res<Material>,
    clock: Res<Clock>,
    execution: Res<Execution>,
) {
    let (counts, rates, responses) = columns;
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
            rates.0[row]
        };
        // Beside the positions are the terms of the last step until the first correction.
        let acted = if first { 0.0 } else { term };
        let (term, step) = jacobi.correct(impulse, acted, (responses.0[row], rate), first);
        Corrected {
            term,
            error: to_error * rate,
            excess: to_error * rate,
            progress: step * rate,
        }
    });
    jacobi.advance(solve.progress);
}

/// Adds to the pressures of the second solve what the impulses of the first come to over the step, `ρ² τ/dt` (phase
/// `Pressure`), and forgets them: in an order that skips the first solve the next step has none.
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

/// Counts neighbours, fluid and boundary.
#[derive(Clone, Copy)]
struct NeighbourCount;

impl PairSum for NeighbourCount {
    type Sums<S: Simd> = ();
    type Output = u32;
    const FLUID: bool = false;
    const COUNTS: bool = true;

    #[inline(always)]
    fn start<S: Simd>(&self, _: S, _: usize, _: Vec4) {}

    #[inline(always)]
    fn finish<S: Simd>(&self, _: S, neighbours: usize, (): ()) -> u32 {
        neighbours as u32
    }
}
