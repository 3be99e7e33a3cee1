//! IISPH (Ihmsen, Cornelis, Solenthaler, Horvath & Teschner 2014, *Implicit Incompressible SPH*, Algorithm 1): solves
//! for the pressures whose force brings the predicted density to the rest density.
//!
//! One pass over the neighbours sums density and diagonal ([`compute_density`](super::diagonal::compute_density));
//! each iteration takes two. The system is described in [`implicit`]. A limit on the mean error and at least two
//! iterations end the solve.
//!
//! Deviations. ω = 0.4 with momentum, warm start 0.8, and `recovery`. The paper's method is
//! `momentum: false, relaxation: 0.5, warm_start: 0.5, recovery: 1, max_density_error: 1e-3`. The mean counts
//! compressions, and too low densities of particles that have pressure: a signed mean is negative at free surfaces.
//! Walls act by the particle's own term ([`force`](super::force)) and enter the diagonal likewise.

use bevy_ecs::{
    prelude::*,
    schedule::{InternedScheduleLabel, ScheduleLabel},
};

use super::{
    diagonal,
    implicit::{self, store_pressures},
    iterate::{PressureIteration, solve_pressure},
    solver::{Iterations, PressureSolver, Requirement, iterations, take_tolerances},
    stabilisation::Stabilisation,
};
use crate::{
    scene::{Iisph, PressureMethod, Scene},
    state::{Column, Systems},
};

/// Head start of the momentum \[iterations], as in [`dfsph`](super::dfsph), whose density solve is the same.
const HEAD_START: i32 = 10;

impl PressureSolver for Iisph {
    fn iterations(&self) -> Option<Iterations> {
        Some(iterations!(self, None, true))
    }

    fn requirements(&self) -> Vec<Requirement> {
        vec![
            Requirement::Relaxation("pressure.relaxation", self.relaxation, self.momentum),
            Requirement::Stabilisation(self.stabilisation),
        ]
    }

    fn with_tolerances_of(&self, other: &PressureMethod) -> PressureMethod {
        let mut method = *self;
        if let PressureMethod::Iisph(of) = other {
            take_tolerances!(method, of);
        }
        PressureMethod::Iisph(method)
    }

    fn columns(&self) -> &'static [Column] {
        implicit::COLUMNS
    }

    fn install(&self, world: &mut World, _: &Scene) {
        let stabilisation = Stabilisation(self.stabilisation);
        implicit::install(
            world,
            self.relaxation,
            self.momentum,
            HEAD_START,
            stabilisation,
        );
    }

    fn density(&self) -> Systems {
        diagonal::compute_density.into_configs()
    }

    fn solve(&self, _: &Scene) -> Systems {
        (solve_pressure, store_pressures).chain()
    }

    fn schedules(&self, _: &Scene) -> Vec<(InternedScheduleLabel, Systems)> {
        vec![(PressureIteration.intern(), implicit::iteration())]
    }
}
