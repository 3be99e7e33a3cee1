//! The length of the first step under a pressure that is known only once it is solved for.

use bevy_ecs::prelude::*;

use super::{AdaptiveTimeStep, TimeStepControl};
use crate::{
    integrate::Motion,
    state::{Clock, Execution, Material, Pressures, of_step::OfStep},
};

/// Shortens the step that is being taken to the limit by the largest pressure, unless its length is fixed.
///
/// The control of the time step knows speeds and forces before the first step, but no pressure: water whose floor
/// carries 100 rows would move in steps ten times as long as its lattice is stable in.
pub(crate) fn shorten_first_step(
    mut clock: ResMut<Clock>,
    mut of_step: ResMut<OfStep>,
    cfl: Option<Res<TimeStepControl>>,
    adaptive: Option<Res<AdaptiveTimeStep>>,
    pressures: Res<Pressures>,
    material: Res<Material>,
    execution: Res<Execution>,
) {
    let largest = largest(&pressures, &execution);
    let limit = match (&cfl, &adaptive) {
        (Some(control), _) => control.longest_under(&material, largest),
        (None, Some(scheme)) => scheme.longest_under(&material, largest),
        (None, None) => return,
    };
    clock.dt = clock.dt.min(limit);
    of_step.shorten(clock.dt);
}

/// Lets the guard of the first step know the pressure that the fluid starts with.
pub(crate) fn remember_first_pressure(
    mut motion: ResMut<Motion>,
    pressures: Res<Pressures>,
    execution: Res<Execution>,
) {
    motion.max_pressure = largest(&pressures, &execution);
}

fn largest(pressures: &Pressures, execution: &Execution) -> f32 {
    execution.largest(pressures.0.iter().copied().fold(0.0, f32::max))
}
