//! IISPH (Ihmsen, Cornelis, Solenthaler, Horvath & Teschner 2014, *Implicit Incompressible SPH*, Algorithm 1): the
//! pressures whose force brings the density, predicted from the velocities, to the rest density.
//!
//! Density and the diagonal of the linear system come from one pass over the neighbours
//! ([`compute_density`](super::response::compute_density)); each iteration, one run of
//! [`PressureIteration`](super::solve::PressureIteration), takes two. See [`implicit`] for the system. At least two
//! iterations are done, and the mean error ends them.
//!
//! Deviations. ω is 0.4 and corrections have momentum; iterations start from 0.8 of the last pressures, and a step
//! removes a part of the compression that it finds ([`recovery`](super::recovery)). The paper's method is `momentum:
//! false, relaxation: 0.5, warm_start: 0.5, recovery: 1, max_density_error: 1e-3`. The mean is of compressions only:
//! where particles at the surface have too few neighbours, the signed mean falls below zero and every limit is met. It
//! counts too little density, too, in particles that have a pressure (see [`solve`](super::solve)). Walls act by the
//! particle's own term, once (see [`force`](super::force)), and count in the diagonal as they do in the force.

use bevy_ecs::{prelude::*, schedule::ScheduleConfigs, system::ScheduleSystem};

use super::{
    implicit::{self, predict_rates, predict_velocities, update_pressure},
    solve::wants_force,
};
use crate::scene::Iisph;

/// Iterations that the momentum is ahead by, as in [`dfsph`](super::dfsph): the solve is the same, and so is its limit.
const HEAD_START: i32 = 10;

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
