//! What a pressure method is, and which one a scene asks for: the only place that tells methods apart.

use bevy_ecs::{schedule::InternedScheduleLabel, world::World};

use super::{convergence::Convergence, warm_start::WarmStart};
use crate::{
    lattice::BesideWall,
    sampling,
    scene::{PressureMethod, Scene},
    state::{Column, Limit, Systems},
};

/// Parameters that all methods with iterations share.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Iterations {
    /// When they end.
    pub convergence: Convergence,
    /// Which pressures they start from.
    pub warm_start: WarmStart,
    /// Part of the compression found that a step removes at most [-].
    pub recovery: f32,
    /// Whether corrections have momentum.
    pub momentum: bool,
}

/// What a number of a method's parameters must be.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Requirement {
    /// Above zero, in a unit.
    Positive(&'static str, f32, &'static str),
    /// An error as a part of the rest density, above 0 and below 1, called so.
    Error(&'static str, f32, &'static str),
    /// A least and a most number of iterations.
    Iterations(&'static str, u32, u32),
    /// A relaxation, with or without momentum.
    Relaxation(&'static str, f32, bool),
}

/// A pressure method: what the stages of a step, the plan of a scene and its checks ask of it.
pub(crate) trait PressureSolver {
    /// What its iterations go by; none for a method without.
    fn iterations(&self) -> Option<Iterations> {
        None
    }

    /// What its own parameters must be.
    fn requirements(&self) -> Vec<Requirement>;

    /// Limits on the time step that do not change in a run.
    fn limits(&self, _: &Scene) -> Vec<Limit> {
        Vec::new()
    }

    /// How walls act on the fluid beside them.
    fn beside_wall(&self, scene: &Scene) -> BesideWall {
        sampling::beside_wall(scene)
    }

    /// Columns that it writes afresh in every step.
    fn columns(&self) -> &'static [Column];

    /// Inserts the resources that its systems use.
    fn install(&self, world: &mut World);

    /// Computes densities, and what else of the pairs it needs.
    fn density(&self) -> Systems;

    /// What frees the velocities of compression before forces act, if it does so.
    fn divergence(&self) -> Option<Systems> {
        None
    }

    /// Solves for the pressure.
    fn solve(&self, scene: &Scene) -> Systems;

    /// The schedules of its iterations.
    fn schedules(&self, _: &Scene) -> Vec<(InternedScheduleLabel, Systems)> {
        Vec::new()
    }
}

impl PressureMethod {
    /// The method's row.
    pub(crate) fn solver(&self) -> &dyn PressureSolver {
        match self {
            Self::Sesph(method) => method,
            Self::Pcisph(method) => method,
            Self::Iisph(method) => method,
            Self::Dfsph(method) => method,
        }
    }

    /// What its iterations go by; none for a method without.
    pub(crate) fn iterations(&self) -> Option<Iterations> {
        self.solver().iterations()
    }
}
