//! What a step reports, and how it fails.

use bevy_ecs::prelude::*;
use glam::Vec3;

use super::{
    clock::{Clock, Failure},
    phase::Phase,
    timer::PhaseTimer,
};
use crate::{
    column::Positions,
    index::DomainTooLarge,
    integrate::Motion,
    neighbours::{BoundaryNeighbours, FluidNeighbours, ListsTooLong},
    pressure::PressureSolve,
    time_step::{AdaptiveTimeStep, Shock, TakenBack},
};

/// What one step did. A step that was taken back is counted in no measure of the next, but is reported: number and time
/// are those where the run stands now, length, errors and iterations those of the step that went wrong, and so are the
/// energies and the speed if it came so far, else those of the step before.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct StepReport {
    /// Number of the step, from 1.
    pub step: u64,
    /// Simulated time at its end [s].
    pub time: f64,
    /// Its length [s].
    pub dt: f32,
    /// Pressure iterations; 0 for methods that do not iterate.
    pub iterations: u32,
    /// Iterations of the divergence solve; 0 for methods without one.
    pub divergence_iterations: u32,
    /// Largest `max(0, (ρ − ρ0)/ρ0)` [-] that remains at the end of the pressure phase.
    pub max_density_error: f32,
    /// Mean over all particles of the same [-].
    pub mean_density_error: f32,
    /// Kinetic energy [J; J/m in 2-D].
    pub kinetic_energy: f64,
    /// Potential energy in the scene's gravity [J; J/m in 2-D].
    pub potential_energy: f64,
    /// Largest speed [m/s].
    pub max_speed: f32,
    /// Fluid particles.
    pub particles: usize,
    /// Neighbours a particle, fluid and boundary together, on average; 0 if they are not stored.
    pub mean_neighbours: f32,
    /// Wall time of every phase [s], in the order of [`Phase::ALL`].
    pub phase_seconds: [f64; Phase::ALL.len()],
    /// Steps taken back, and why, with a time step that is `Adaptive`; then this was no step forwards.
    pub taken_back: Option<TakenBack>,
}

/// Why a step failed. The columns keep the last good state.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[error("step {step} at t = {time:.6} s: {cause}{}", place(.particle))]
pub struct StepError {
    /// Number of the step that failed, from 1.
    pub step: u64,
    /// Simulated time at its start [s].
    pub time: f64,
    /// The particle concerned, if one is.
    pub particle: Option<(Entity, Vec3)>,
    /// What went wrong.
    pub cause: FailureCause,
}

/// What went wrong in a step.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum FailureCause {
    /// The world holds no scene that steps can be taken of.
    #[error("{reason}")]
    NotInstalled {
        /// What is missing, and what brings it back.
        reason: &'static str,
    },
    /// The time step that a host chose is none.
    #[error("the time step is {dt:e} s; `Clock::next_dt` must be finite and above 0")]
    TimeStep {
        /// The time step [s].
        dt: f32,
    },
    /// Particles lack a component that every fluid particle has.
    #[error(
        "a fluid particle lacks the component `{component}`{}; insert it again, or remove `Fluid` from what is no particle",
        others(*.particles)
    )]
    LacksComponent {
        /// Name of the component.
        component: &'static str,
        /// Particles in the same table, which all lack it.
        particles: usize,
    },
    /// Particles came, went or moved to another table while the step was computed.
    #[error(
        "a system spawned, despawned or tagged fluid particles in the middle of the step, which had {before} and would write \
         to {now}; order it before `Phase::RebuildIndex` or after `Phase::Integrate`, or do it between steps"
    )]
    ParticlesChanged {
        /// Particles at the start of the step.
        before: usize,
        /// Particles at its end.
        now: usize,
    },
    /// A value that the step starts from is so large that its square is not finite.
    #[error("{quantity} is beyond 1e17 at the start of the step; a host wrote it")]
    TooLarge {
        /// Which quantity.
        quantity: &'static str,
    },
    /// A position, velocity or density is not a number or infinite.
    #[error("{quantity} is not finite; a host wrote it, or a smaller time step is needed")]
    NotFinite {
        /// Which quantity.
        quantity: &'static str,
    },
    /// A particle would move more than half the support radius.
    #[error(
        "a particle would move {displacement:.3e} m in one step, more than h/2 = {limit:.3e} m; a smaller time step is needed"
    )]
    TooFast {
        /// Length of the movement [m].
        displacement: f32,
        /// The limit, h/2 [m].
        limit: f32,
    },
    /// A particle is compressed beyond the scene's limit.
    #[error(
        "compression {compression:.3} is above the limit {limit:.3}; a smaller time step or a stiffer fluid is needed"
    )]
    OverCompressed {
        /// `(ρ − ρ0)/ρ0` [-].
        compression: f32,
        /// The scene's limit [-].
        limit: f32,
    },
    /// Pressure did more work than the energies that it can draw on.
    #[error(
        "pressure did {work:.3e} J of work in one step, `limits.energy` allows {limit:.3e} J; a smaller time step, more \
         iterations (`pressure.max_density_error`) or a smaller `pressure.recovery` is needed"
    )]
    EnergyGained {
        /// Work [J; J/m in 2-D].
        work: f64,
        /// The limit [J; J/m in 2-D].
        limit: f64,
    },
    /// A particle left the scene's domain.
    #[error("a particle left the domain; widen `domain`, or put a boundary in its way")]
    LeftDomain,
    /// The spatial index covers a box around all particles, which would take too much memory.
    #[error(transparent)]
    DomainTooLarge(DomainTooLarge),
    /// Neighbour lists are longer than they can be.
    #[error(transparent)]
    ListsTooLong(ListsTooLong),
    /// The pressure iterations did not reach the limit on the density error.
    #[error(
        "pressure did not converge: density error {error:.3e} after {iterations} iterations, the limit is {limit:.3e}; take \
         shorter steps (`time_step`), allow more iterations (`pressure.max_iterations`) or a larger error \
         (`pressure.max_density_error`), or go on with the error that remains (`pressure.not_converged=Accept`)"
    )]
    NotConverged {
        /// Iterations done.
        iterations: u32,
        /// Density error reached [-].
        error: f32,
        /// The limit [-].
        limit: f32,
    },
    /// The step met a shock, and the time step could not be made smaller (`time_step: Adaptive` only).
    #[error(
        "shock: {0}, and no shorter step helped; `time_step.min` may be too large, or `time_step.density_error` too small"
    )]
    Shock(Shock),
}

/// As many particles of one table lack the same.
fn others(particles: usize) -> String {
    match particles {
        0 | 1 => String::new(),
        more => format!(", and so do {} others", more - 1),
    }
}

fn place(particle: &Option<(Entity, Vec3)>) -> String {
    particle.map_or_else(String::new, |(entity, at)| {
        format!(
            " (particle {entity} at ({:.4}, {:.4}, {:.4}) m)",
            at.x, at.y, at.z
        )
    })
}

/// How the last step ended: what a host looks at after running the schedule.
#[derive(Resource, Debug, Clone, PartialEq)]
pub struct StepOutcome(pub Result<StepReport, StepError>);

impl Default for StepOutcome {
    fn default() -> Self {
        Self(Ok(StepReport::default()))
    }
}

/// Writes the outcome (phase `Observe`).
pub(super) fn finish(
    mut outcome: ResMut<StepOutcome>,
    failure: Res<Failure>,
    (clock, adaptive): (Res<Clock>, Option<Res<AdaptiveTimeStep>>),
    timer: Res<PhaseTimer>,
    solve: Res<PressureSolve>,
    motion: Res<Motion>,
    positions: Res<Positions>,
    lists: (
        Option<Res<FluidNeighbours>>,
        Option<Res<BoundaryNeighbours>>,
    ),
) {
    if let Some(error) = failure.error(&clock) {
        outcome.0 = Err(error);
        return;
    }
    let particles = positions.rows();
    let (fluid, boundary) = lists;
    let pairs =
        fluid.map_or(0, |lists| lists.0.pairs()) + boundary.map_or(0, |lists| lists.0.pairs());
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
        mean_neighbours: pairs as f32 / particles.max(1) as f32,
        phase_seconds: timer.seconds,
        taken_back: adaptive.and_then(|adaptive| adaptive.taken_back.clone()),
    });
}
