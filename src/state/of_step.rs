//! Constants of the step at hand: what a host writes to them in the middle of it would hold for a part of it alone.

use bevy_ecs::prelude::*;

use super::{
    clock::Clock,
    failure::{Failure, FailureCause, healthy},
    material::Material,
};

/// Constants and clock as the step took them. None before the first step and in one that is refused for them.
#[derive(Resource, Debug, Default)]
pub(crate) struct OfStep(Option<(Material, Clock)>);

impl OfStep {
    /// Takes over a length of the step that the engine has changed \[s].
    pub(crate) fn shorten(&mut self, dt: f32) {
        if let Some((_, clock)) = &mut self.0 {
            clock.dt = dt;
        }
    }

    /// The resource that was written since the step took it, if there is one; also after the step has moved on in
    /// time.
    pub(crate) fn written(&self, material: &Material, clock: &Clock) -> Option<FailureCause> {
        let (of_step, begun) = self.0.as_ref()?;
        // What is no number differs from itself.
        let resource = match (material == of_step, clock.dt == begun.dt) {
            (false, _) => "Material",
            (_, false) => "Clock",
            _ => return None,
        };
        Some(FailureCause::ConstantsWritten { resource })
    }

    /// Whether the time was written before the step moved on.
    fn is_later(&self, clock: &Clock) -> bool {
        // The next step's length and its end are for the next step.
        self.0
            .is_some_and(|(_, begun)| (clock.step, clock.time) != (begun.step, begun.time))
    }
}

/// Notes them (before the first stage). What is refused already has its own cause.
pub(crate) fn note(
    material: Res<Material>,
    clock: Res<Clock>,
    failure: Res<Failure>,
    mut of_step: ResMut<OfStep>,
) {
    of_step.0 = healthy(failure).then_some((*material, *clock));
}

/// Refuses a step in which a host wrote them (phase `Integrate`).
pub(crate) fn check_unwritten(
    material: Res<Material>,
    clock: Res<Clock>,
    of_step: Res<OfStep>,
    mut failure: ResMut<Failure>,
) {
    let later = || {
        let resource = "Clock";
        let is_later = of_step.is_later(&clock);
        is_later.then_some(FailureCause::ConstantsWritten { resource })
    };
    if let Some(cause) = of_step.written(&material, &clock).or_else(later) {
        failure.record(cause, None);
    }
}

/// Moves on with the clock (phase `Integrate`, when the step is counted): an order may repeat the step.
pub(crate) fn move_on(clock: Res<Clock>, mut of_step: ResMut<OfStep>) {
    if let Some((_, begun)) = &mut of_step.0 {
        (begun.step, begun.time) = (clock.step, clock.time);
    }
}

/// Names them as the cause of what failed since (phase `Observe`).
pub(crate) fn explain(
    material: Res<Material>,
    clock: Res<Clock>,
    of_step: Res<OfStep>,
    mut failure: ResMut<Failure>,
) {
    if let Some(cause) = of_step.written(&material, &clock) {
        failure.explain_without_particle(cause);
    }
}
