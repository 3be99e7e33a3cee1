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

use bevy_ecs::{
    prelude::*,
    schedule::{InternedScheduleLabel, ScheduleLabel},
};

use super::{
    convergence::Convergence,
    implicit::{self, take_pressures},
    iterate::{PressureIteration, solve_pressure},
    response,
    solver::{Iterations, PressureSolver, Requirement},
    warm_start::WarmStart,
};
use crate::{
    scene::{Iisph, Scene},
    state::{Column, Systems},
};

/// Iterations that the momentum is ahead by, as in [`dfsph`](super::dfsph): the solve is the same, and so is its limit.
const HEAD_START: i32 = 10;

impl PressureSolver for Iisph {
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
        vec![Requirement::Relaxation(
            "pressure.relaxation",
            self.relaxation,
            self.momentum,
        )]
    }

    fn columns(&self) -> &'static [Column] {
        implicit::COLUMNS
    }

    fn install(&self, world: &mut World) {
        implicit::install(world, self.relaxation, self.momentum, HEAD_START);
    }

    fn density(&self) -> Systems {
        response::compute_density.into_configs()
    }

    fn solve(&self, _: &Scene) -> Systems {
        (solve_pressure, take_pressures).chain()
    }

    fn schedules(&self, _: &Scene) -> Vec<(InternedScheduleLabel, Systems)> {
        vec![(PressureIteration.intern(), implicit::iteration())]
    }
}
