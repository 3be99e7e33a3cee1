//! Where a run stands, and whether it still may go on.

use bevy_ecs::prelude::*;
use glam::Vec3;

use super::report::{FailureCause, StepError};
use crate::{column::Rows, particle::Position};

/// Simulated time and steps.
#[derive(Resource, Debug, Clone, Copy, Default, PartialEq)]
pub struct Clock {
    /// Steps taken.
    pub step: u64,
    /// Simulated time [s].
    pub time: f64,
    /// Length of the step that is being taken, or was taken last [s].
    pub dt: f32,
    /// Length of the next step [s].
    pub next_dt: f32,
}

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
                | FailureCause::TimeStep { .. }
                | FailureCause::LacksComponent { .. }
                | FailureCause::ParticlesChanged { .. }
                | FailureCause::TooLarge { .. },
            ) => false,
            Some(
                FailureCause::NotFinite { .. }
                | FailureCause::TooFast { .. }
                | FailureCause::OverCompressed { .. }
                | FailureCause::NotConverged { .. }
                | FailureCause::Shock(_),
            ) => true,
        }
    }

    /// Takes the failure away, and says what it was and of which particle.
    pub(crate) fn forgive(&mut self) -> Option<(FailureCause, Option<(Entity, Vec3)>)> {
        let Self {
            cause, particle, ..
        } = std::mem::take(self);
        cause.map(|cause| (cause, particle))
    }

    /// The failure as an error of this step.
    pub(super) fn error(&self, clock: &Clock) -> Option<StepError> {
        self.cause.clone().map(|cause| StepError {
            step: clock.step + 1,
            time: clock.time,
            particle: self.particle,
            cause,
        })
    }
}

/// Whether nothing went wrong so far: stages run only then.
pub(super) fn healthy(failure: Res<Failure>) -> bool {
    failure.cause.is_none()
}

/// Starts a step.
pub(super) fn begin(mut clock: ResMut<Clock>, mut failure: ResMut<Failure>) {
    clock.dt = clock.next_dt;
    *failure = Failure::default();
    let dt = clock.dt;
    if !(dt > 0.0 && dt.is_finite()) {
        failure.record(FailureCause::TimeStep { dt }, None);
    }
}

/// Finds the particle of a failure while the tables still hold it.
pub(super) fn name_the_particle(
    mut failure: ResMut<Failure>,
    rows: Res<Rows>,
    places: Query<&Position>,
) {
    let row = failure.row.take();
    if let Some(&entity) = row.and_then(|row| rows.entities.get(row)) {
        let at = places.get(entity).map_or(Vec3::NAN, |x| x.0);
        failure.particle = Some((entity, at));
    }
}

/// Counts the step (phase `Integrate`, when nothing went wrong).
pub(super) fn advance_clock(mut clock: ResMut<Clock>) {
    clock.step += 1;
    clock.time += f64::from(clock.dt);
}
