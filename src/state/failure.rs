//! What can go wrong in a step: causes with their messages, and the failure of the step at hand.

use bevy_ecs::prelude::*;
use glam::Vec3;

use super::{
    failure_text::{boundaries, others, place},
    particle::Position,
    rows::Rows,
};
pub use super::{
    shock::Shock,
    too_large::{DomainTooLarge, ListsTooLong, MAX_CELLS},
};
use crate::communicator::Lost;

/// What went wrong in this step, if something did. The first failure counts.
#[derive(Resource, Debug, Clone, Default)]
pub struct Failure {
    cause: Option<FailureCause>,
    row: Option<usize>,
    particle: Option<(Entity, Vec3)>,
}

impl Failure {
    /// Records a failure, and the row concerned.
    pub fn record(&mut self, cause: FailureCause, row: Option<usize>) {
        if self.cause.is_none() {
            self.cause = Some(cause);
            self.row = row;
        }
    }

    /// Records a failure of a particle that has no row.
    pub(crate) fn record_of(&mut self, cause: FailureCause, particle: (Entity, Vec3)) {
        if self.cause.is_none() {
            self.cause = Some(cause);
            self.particle = Some(particle);
        }
    }

    /// Whether something went wrong that goes right, perhaps, in a shorter step.
    pub(crate) fn depends_on_the_time_step(&self) -> bool {
        match &self.cause {
            None
            | Some(
                FailureCause::LeftDomain
                | FailureCause::DomainTooLarge(_)
                | FailureCause::ListsTooLong(_)
                | FailureCause::NotInstalled { .. }
                | FailureCause::LacksResource { .. }
                | FailureCause::Constant { .. }
                | FailureCause::Time { .. }
                | FailureCause::TimeStep { .. }
                | FailureCause::LacksComponent { .. }
                | FailureCause::SameNumber { .. }
                | FailureCause::ParticlesChanged { .. }
                | FailureCause::Overwritten { .. }
                | FailureCause::ConstantsWritten { .. }
                | FailureCause::ResourceWritten { .. }
                | FailureCause::Schedule { .. }
                | FailureCause::Seconds { .. }
                | FailureCause::TooLarge { .. }
                | FailureCause::RanksLost(_)
                | FailureCause::NoRoom { .. },
            ) => false,
            Some(FailureCause::OnAnotherRank {
                depends_on_the_time_step,
                ..
            }) => *depends_on_the_time_step,
            Some(
                FailureCause::NotFinite { .. }
                | FailureCause::TooFast { .. }
                | FailureCause::WallTooFast { .. }
                | FailureCause::OverCompressed { .. }
                | FailureCause::EnergyGained { .. }
                | FailureCause::NotConverged { .. }
                | FailureCause::Shock(_),
            ) => true,
        }
    }

    /// What other ranks are told: its row, whether it depends on the time step, and its text.
    pub(super) fn told(&self) -> Option<(Option<usize>, bool, String)> {
        let text = format!("{}{}", self.cause.as_ref()?, place(&self.particle));
        Some((self.row, self.depends_on_the_time_step(), text))
    }

    /// Gives the failure its cause, of which the one that was recorded is a consequence.
    pub(crate) fn explain(&mut self, cause: FailureCause) {
        if self.cause.is_some() {
            self.cause = Some(cause);
        }
    }

    /// The same where the cause is not that of a particle.
    pub(crate) fn explain_without_particle(&mut self, cause: FailureCause) {
        self.explain(cause);
        (self.row, self.particle) = (None, None);
    }

    /// Takes the failure away, and says what it was and of which particle.
    pub(crate) fn forgive(&mut self) -> Option<(FailureCause, Option<(Entity, Vec3)>)> {
        let Self {
            cause, particle, ..
        } = std::mem::take(self);
        cause.map(|cause| (cause, particle))
    }

    /// The failure as an error of this step.
    pub(crate) fn error(&self, step: u64, time: f64) -> Option<StepError> {
        self.cause.clone().map(|cause| StepError {
            step,
            time,
            particle: self.particle,
            cause,
        })
    }
}

/// Whether nothing went wrong so far: stages run only then.
pub(crate) fn healthy(failure: Res<Failure>) -> bool {
    failure.cause.is_none()
}

/// Finds the particle of a failure while the tables still hold it.
pub(crate) fn locate_failure(
    mut failure: ResMut<Failure>,
    rows: Res<Rows>,
    places: Query<&Position>,
) {
    let row = failure.row.take();
    if let Some(entity) = row.and_then(|row| rows.entity_of(row)) {
        let at = places.get(entity).map_or(Vec3::NAN, |x| x.0);
        failure.particle = Some((entity, at));
    }
}

/// Why a step failed. The columns keep the last good state.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
#[error("step {step} at t = {time:.6} s: {cause}{}", place(.particle))]
pub struct StepError {
    /// Number of the step that failed, from 1.
    pub step: u64,
    /// Simulated time at its start \[s].
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
    /// A resource of the scene is gone.
    #[error(
        "the world lacks the resource `{resource}` of the scene, which a host removed; insert it again, or `uninstall` \
         the scene and install it anew"
    )]
    LacksResource {
        /// Name of the resource.
        resource: String,
    },
    /// A constant of the fluid that a host wrote is none.
    #[error("`Material::{constant}` is {value}, which a host wrote; it must be {wanted}")]
    Constant {
        /// Name of the constant.
        constant: &'static str,
        /// Its value.
        value: String,
        /// What would be right.
        wanted: &'static str,
    },
    /// The simulated time is none, or it stands still.
    #[error(
        "the simulated time is {time:e} s, to which a step of {dt:e} s adds nothing; `Clock::time` must be finite, \
             and small enough for the step"
    )]
    Time {
        /// The time \[s].
        time: f64,
        /// The time step \[s].
        dt: f32,
    },
    /// The time step that a host chose is none.
    #[error("the time step is {dt:e} s; `Clock::next_dt` must be finite and above 0")]
    TimeStep {
        /// The time step \[s].
        dt: f32,
    },
    /// Particles lack a component that every fluid particle has.
    #[error(
        "a fluid particle lacks the component `{component}`{}; insert it again, or remove `Fluid` from what is no \
         particle",
        others(*.particles)
    )]
    LacksComponent {
        /// Name of the component.
        component: &'static str,
        /// All particles that lack it.
        particles: usize,
    },
    /// Two particles have one number: a host has copied it.
    #[error(
        "a fluid particle has the number {number} of another one, which a host copied; insert \
         `ParticleId::default()`, which gives it a new one"
    )]
    SameNumber {
        /// The number, [`ParticleId`](super::particle::ParticleId).
        number: u32,
    },
    /// Particles came, went or moved to another table while the step was computed.
    #[error(
        "a system spawned, despawned or tagged fluid particles in the middle of the step, which had {before} and \
         would write to {now}; order it before `Phase::RebuildIndex` or after `Phase::Integrate`, or do it between \
         steps"
    )]
    ParticlesChanged {
        /// Particles at the start of the step.
        before: usize,
        /// Particles at its end.
        now: usize,
    },
    /// A system wrote a component of the fluid while the step was computed: the step's result would overwrite it.
    #[error(
        "a system wrote `{component}` in the middle of the step, which would overwrite it; order it before \
         `Phase::RebuildIndex` or after `Phase::Integrate`, or add to `Accelerations` between `Phase::Forces` and \
         `Phase::Pressure`"
    )]
    Overwritten {
        /// Name of the component.
        component: &'static str,
    },
    /// A system wrote constants while the step was computed: a part of it had others.
    #[error(
        "a system wrote `{resource}` in the middle of the step, of which a part had other values; write it between \
         steps"
    )]
    ConstantsWritten {
        /// Name of the resource.
        resource: &'static str,
    },
    /// A host wrote a resource of the engine, or exchanged it with that of another world.
    #[error(
        "a host wrote the engine's resource `{resource}`, or exchanged it with another world's; only `Material`, \
         `Clock` and `Accelerations` may be written: put it back, or `uninstall` the scene and install it anew"
    )]
    ResourceWritten {
        /// Name of the resource.
        resource: String,
    },
    /// The schedule of the step cannot be built any more: a host's system conflicts with others.
    #[error(
        "the step cannot be scheduled with the systems that a host added; order them against phases \
         (`.after(Phase::Forces).before(Phase::Pressure)`): {conflict}"
    )]
    Schedule {
        /// Systems and data that are in conflict, as bevy names them.
        conflict: String,
    },
    /// The time that a host wants to advance by is none.
    #[error("cannot advance by {seconds} s; the time must be finite and not negative")]
    Seconds {
        /// The time \[s].
        seconds: f64,
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
        "a particle would move {displacement:.3e} m in one step, more than h/2 = {limit:.3e} m; a smaller time step \
         is needed"
    )]
    TooFast {
        /// Length of the movement \[m].
        displacement: f32,
        /// The limit, h/2 \[m].
        limit: f32,
    },
    /// A wall would move more than half the support radius.
    #[error(
        "a wall would move {displacement:.3e} m in one step, more than h/2 = {limit:.3e} m; a smaller time step is \
         needed"
    )]
    WallTooFast {
        /// Length of the movement \[m].
        displacement: f32,
        /// The limit, h/2 \[m].
        limit: f32,
    },
    /// A particle is compressed beyond the scene's limit.
    #[error(
        "compression {compression:.3} is above the limit {limit:.3}; a smaller time step is needed, or (with an \
         equation of state) a stiffer fluid, or (with iterations) a smaller `pressure.max_density_error`"
    )]
    OverCompressed {
        /// `(ρ − ρ0)/ρ0` \[-].
        compression: f32,
        /// The scene's limit \[-].
        limit: f32,
    },
    /// Pressure did more work than the energies that it can draw on.
    #[error(
        "pressure did {work:.3e} J of work in the last steps, `limits.energy` allows {limit:.3e} J; a smaller time \
         step, more iterations (`pressure.max_density_error`) or a smaller `pressure.recovery` is needed"
    )]
    EnergyGained {
        /// Work \[J; J/m in 2-D].
        work: f64,
        /// The limit \[J; J/m in 2-D].
        limit: f64,
    },
    /// Walls have moved into fluid that they close in.
    #[error(
        "no room is left: the walls of {} have compressed the {particles} particles between them by {:.2} % on \
         average, and no free surface is left; let the motion end before, leave the \
         fluid a way out, or take less fluid",
        boundaries(.walls),
        100.0 * .compression
    )]
    NoRoom {
        /// Numbers of the scene's boundaries that move into it.
        walls: Vec<u32>,
        /// Fluid particles without room.
        particles: usize,
        /// Their mean compression `(ρ − ρ0)/ρ0` \[-].
        compression: f32,
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
        "pressure did not converge: density error {error:.3e} after {iterations} iterations, the limit is \
         {limit:.3e}; take shorter steps (`time_step`), allow more iterations (`pressure.max_iterations`) or a larger \
         error (`pressure.max_density_error`), or go on with the error that remains (`pressure.not_converged=Accept`)"
    )]
    NotConverged {
        /// Iterations done.
        iterations: u32,
        /// Density error reached \[-].
        error: f32,
        /// The limit \[-].
        limit: f32,
    },
    /// The step met a shock, and the time step could not be made smaller (`time_step: Adaptive` only).
    #[error(
        "shock: {0}, and no shorter step helped; `time_step.min` may be too large, or `time_step.density_error` too \
         small"
    )]
    Shock(Shock),
    /// A rank that owns other particles failed.
    #[error("{cause} (on rank {rank})")]
    OnAnotherRank {
        /// Its number.
        rank: usize,
        /// What went wrong there, and with which particle.
        cause: String,
        /// Whether a shorter step may go right.
        depends_on_the_time_step: bool,
    },
    /// Ranks do not answer any more.
    #[error("the run cannot go on without all ranks: {0}")]
    RanksLost(Lost),
}
