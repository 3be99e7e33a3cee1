//! IISPH (Ihmsen, Cornelis, Solenthaler, Horvath & Teschner 2014, *Implicit Incompressible SPH*, Algorithm 1): the
//! pressures whose force brings the density, predicted from the velocities, to the rest density.
//!
//! Density and the diagonal of the linear system come from one pass over the neighbours
//! ([`compute_density`](super::response::compute_density)); each iteration, one run of
//! [`PressureIteration`](super::solve::PressureIteration), takes two. See [`implicit`] for the system. The
//! pressures start at half of the last step's, as in the paper; at least two iterations are done, and the mean error ends
//! them.
//!
//! Deviations. ω is 0.4 and corrections have momentum from the fourth on (`momentum: false, relaxation: 0.5` is the paper's);
//! a step much shorter than those before it removes compression at their pace (all: [`implicit`]). The mean is of compressions
//! only: where particles at the surface have too few neighbours, the signed mean falls below zero and every limit is met. It
//! counts too little density, too, in particles that have a pressure (see [`solve`](super::solve)). Walls act by the
//! particle's own term, once (see [`force`](super::force)), and count in the diagonal as they do in the force.

use bevy_ecs::{prelude::*, schedule::ScheduleConfigs, system::ScheduleSystem};

use super::{
    implicit::{self, predict_rates, predict_velocities, update_pressure},
    solve::wants_force,
};
use crate::scene::Iisph;

/// Iterations that the momentum begins later than it could. Steps end after two to six of them, as the error comes out, and
/// with momentum at once each of these numbers answers waves in another way: still water of 16 layers, 12 runs that differ by
/// rounding alone, stood in 80 % of the half seconds and in the others went up and down with 1 to 2 % of sqrt(g H), as
/// compression grows in steps of two iterations and is thrown back by one of ten. Half seconds of 72 in which it did so, and
/// iterations a step: at once, 14 and 3.94; one later, 2 and 4.30; two, none and 4.60; three, none and 4.80.
const HEAD_START: i32 = -2;

/// The systems of [`PressureIteration`](super::solve::PressureIteration), in their order.
pub fn iteration() -> ScheduleConfigs<ScheduleSystem> {
    (
        super::pressure_force.run_if(wants_force),
        predict_velocities,
        predict_rates,
        update_pressure,
    )
        .chain()
}

/// Inserts what the method needs.
pub fn install(world: &mut World, parameters: Iisph) {
    implicit::install(
        world,
        parameters.relaxation,
        parameters.momentum,
        HEAD_START,
    );
}
