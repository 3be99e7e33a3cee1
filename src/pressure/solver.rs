//! The interface of a pressure method, and the method of a scene. No other place distinguishes methods.

use bevy_ecs::{schedule::InternedScheduleLabel, world::World};

use super::{convergence::Convergence, warm_start::WarmStart};
use crate::{
    lattice::BesideWall,
    sampling,
    scene::{PressureMethod, Scene},
    state::{Column, Limit, Systems},
};

/// Parameters common to all iterative methods.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Iterations {
    /// Convergence criterion.
    pub convergence: Convergence,
    /// Initial pressures of the iterations.
    pub warm_start: WarmStart,
    /// Maximum part of the compression found that a step removes \[-].
    pub recovery: f32,
    /// Whether it solves for velocities, in which densities are linear. Such methods fill missing density slowly.
    pub is_linear: bool,
    /// Whether corrections have momentum.
    pub momentum: bool,
}

/// The [`Iterations`] of a method's parameters, whose fields have the same names in every method; with a limit on the
/// mean error beside that on the largest, or `None`.
macro_rules! iterations {
    ($parameters:expr, $mean_density_error:expr, $is_linear:expr) => {
        $crate::pressure::solver::Iterations {
            convergence: $crate::pressure::convergence::Convergence {
                max_density_error: $parameters.max_density_error,
                criterion: $parameters.criterion,
                mean_density_error: $mean_density_error,
                min_iterations: $parameters.min_iterations,
                max_iterations: $parameters.max_iterations,
                not_converged: $parameters.not_converged,
            },
            warm_start: $crate::pressure::warm_start::WarmStart {
                share: $parameters.warm_start,
                steps: $parameters.warm_start_steps,
            },
            recovery: $parameters.recovery,
            is_linear: $is_linear,
            momentum: $parameters.momentum,
        }
    };
}
pub(super) use iterations;

/// Takes the tolerances that the parameters of all iterative methods have.
macro_rules! take_tolerances {
    ($parameters:expr, $from:expr) => {
        $parameters.max_density_error = $from.max_density_error;
        $parameters.criterion = $from.criterion;
        $parameters.min_iterations = $from.min_iterations;
        $parameters.max_iterations = $from.max_iterations;
        $parameters.not_converged = $from.not_converged;
    };
}
pub(super) use take_tolerances;

/// Requirement on a parameter of a method.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Requirement {
    /// Name, value and unit of a number above zero.
    Positive(&'static str, f32, &'static str),
    /// Name and value of an error relative to the rest density, between 0 and 1.
    Error(&'static str, f32, &'static str),
    /// Name, minimum and maximum of a number of iterations.
    Iterations(&'static str, u32, u32),
    /// Name and value of a relaxation, and whether there is momentum.
    Relaxation(&'static str, f32, bool),
    /// Name, value and maximum of a factor from 0 on.
    Factor(&'static str, f32, f32),
    /// The share of a [`Stabilisation`](super::stabilisation::Stabilisation).
    Stabilisation(f32),
}

/// A pressure method: what the stages of a step, the plan of a scene and its checks need from it.
pub(crate) trait PressureSolver {
    /// Parameters of its iterations; none for a method without iterations.
    fn iterations(&self) -> Option<Iterations> {
        None
    }

    /// Smallest support radius in spacings with which it is stable \[-]. Below 1.2, a particle has too few neighbours
    /// to know its density.
    fn least_support(&self) -> f32 {
        1.2
    }

    /// Requirements on its parameters.
    fn requirements(&self) -> Vec<Requirement>;

    /// Time step limits that are constant in a run.
    fn limits(&self, _: &Scene) -> Vec<Limit> {
        Vec::new()
    }

    /// Speed of sound at rest \[m/s]; none for a method without an equation of state.
    fn sound_speed(&self, _: &Scene) -> Option<f32> {
        None
    }

    /// Energy that pressure makes of an error of the summed density `(ρ − ρ0)/ρ0` at the start \[J/kg]; none for a
    /// method without an equation of state.
    fn energy_of_error(&self, _: &Scene, _error: f32) -> f64 {
        0.0
    }

    /// How walls act on the fluid beside them.
    fn beside_wall(&self, scene: &Scene) -> BesideWall {
        sampling::beside_wall(scene)
    }

    /// Columns that it recomputes in every step.
    fn columns(&self) -> &'static [Column];

    /// Inserts the resources that its systems use.
    fn install(&self, world: &mut World, scene: &Scene);

    /// The method with the tolerances of another; as it is, if they are not of one kind.
    fn with_tolerances_of(&self, other: &PressureMethod) -> PressureMethod;

    /// Gives its iterations the tolerances that it has now.
    fn set_tolerances(&self, world: &mut World) {
        if let Some(iterations) = self.iterations() {
            world.insert_resource(iterations.convergence);
        }
    }

    /// Computes densities, and the other sums over pairs that the method needs.
    fn density(&self) -> Systems;

    /// Makes the velocities free of compression before forces act, for methods that do so.
    fn divergence(&self) -> Option<Systems> {
        None
    }

    /// Whether the pressure of the first step is solved for (see [`initial`](super::initial)).
    fn solves_initial_pressure(&self) -> bool {
        (self.iterations()).is_some_and(|iterations| iterations.warm_start.share > 0.0)
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
            Self::DeltaSph(method) => method,
            Self::Pcisph(method) => method,
            Self::Iisph(method) => method,
            Self::Dfsph(method) => method,
        }
    }

    /// Parameters of its iterations; none for a method without iterations.
    pub(crate) fn iterations(&self) -> Option<Iterations> {
        self.solver().iterations()
    }
}
