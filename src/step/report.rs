//! What a step reports, on success and on failure.

use bevy_ecs::prelude::*;

use super::timer::PhaseTimer;
use crate::{
    flow::Turnover,
    integrate::Motion,
    neighbours::{BoundaryNeighbours, FluidNeighbours, NeighbourLists},
    pressure::SolverState,
    state::{Clock, Execution, Failure, Phase},
    state::{Positions, StepError, TakenBack},
    time_step::AdaptiveTimeStep,
};

/// Report of one step. A step that was rolled back does not enter the sums of the next, but has a report of its own:
/// `step` and `time` are those of the restored state; length, errors and iterations are those of the failed attempt. So
/// are energies and speed if the attempt got that far; otherwise they are those of the step before.
#[derive(Debug, Clone, Default, PartialEq)]
#[non_exhaustive]
pub struct StepReport {
    /// Number of the step, counted from 1.
    pub step: u64,
    /// Simulated time at its end \[s].
    pub time: f64,
    /// Its length \[s].
    pub dt: f32,
    /// Pressure iterations; 0 for methods that do not iterate.
    pub iterations: u32,
    /// Iterations of the divergence solve; 0 for methods without one.
    pub divergence_iterations: u32,
    /// Largest `max(0, (ρ − ρ0)/ρ0)` \[-] that remains at the end of the pressure phase.
    pub max_density_error: f32,
    /// Mean of `max(0, (ρ − ρ0)/ρ0)` over all particles \[-].
    pub mean_density_error: f32,
    /// Kinetic energy \[J; J/m in 2-D].
    pub kinetic_energy: f64,
    /// Potential energy in the scene's gravity and central forces \[J; J/m in 2-D].
    pub potential_energy: f64,
    /// Largest speed \[m/s].
    pub max_speed: f32,
    /// Fluid particles in the step.
    pub particles: usize,
    /// Particles from emitters since the start, those behind their faces included.
    pub emitted: u64,
    /// Particles that did not enter, because other fluid was in their places behind the face of an emitter, since the
    /// start.
    pub without_place: u64,
    /// Particles removed by outflow and out of the domain since the start.
    pub removed: u64,
    /// Mean number of neighbours per particle, fluid and boundary together; 0 if they are not stored.
    pub mean_neighbours: f32,
    /// Wall time of every phase \[s], in the order of [`Phase::ALL`].
    pub phase_seconds: [f64; Phase::ALL.len()],
    /// Set if this step was rolled back (time step `Adaptive`): the number of steps and the reason.
    pub taken_back: Option<TakenBack>,
}

/// How the last step ended. A host that runs the schedule itself reads it afterwards.
#[derive(Resource, Debug, Clone, PartialEq)]
pub struct StepOutcome(pub Result<StepReport, StepError>);

impl Default for StepOutcome {
    fn default() -> Self {
        Self(Ok(StepReport::default()))
    }
}

/// Writes the outcome of the step (phase `Observe`).
pub(super) fn finish(
    mut outcome: ResMut<StepOutcome>,
    failure: Res<Failure>,
    (clock, adaptive, turnover): (
        Res<Clock>,
        Option<Res<AdaptiveTimeStep>>,
        Option<Res<Turnover>>,
    ),
    timer: Res<PhaseTimer>,
    solve: Res<SolverState>,
    motion: Res<Motion>,
    (positions, execution): (Res<Positions>, Res<Execution>),
    lists: (
        Option<Res<FluidNeighbours>>,
        Option<Res<BoundaryNeighbours>>,
    ),
) {
    if let Some(error) = failure.error(clock.step + 1, clock.time) {
        outcome.0 = Err(error);
        return;
    }
    let particles = execution.all(positions.rows());
    let turnover = turnover.map_or_else(Turnover::default, |turnover| *turnover);
    let (fluid, boundary) = lists;
    let of = |lists: &NeighbourLists| match execution.team() {
        None => lists.pairs(),
        // Rows of other ranks are counted there.
        Some(team) => team.owned().map(|row| lists.of(row).len()).sum(),
    };
    let pairs =
        fluid.map_or(0, |found| of(&found.lists)) + boundary.map_or(0, |lists| of(&lists.0));
    let pairs = execution.total(pairs as u64);
    outcome.0 = Ok(StepReport {
        step: clock.step,
        time: clock.time,
        dt: clock.dt,
        iterations: solve.iterations,
        divergence_iterations: solve.divergence_iterations,
        max_density_error: solve.error.largest,
        mean_density_error: solve.error.mean,
        kinetic_energy: motion.kinetic_energy,
        potential_energy: motion.potential_energy,
        max_speed: motion.max_speed,
        particles,
        emitted: turnover.emitted,
        without_place: turnover.without_place,
        removed: turnover.removed,
        mean_neighbours: pairs as f32 / particles.max(1) as f32,
        phase_seconds: timer.seconds,
        taken_back: adaptive.and_then(|adaptive| adaptive.taken_back.clone()),
    });
}
