//! When iterations end.

use bevy_ecs::prelude::*;

use crate::{
    scene::{Criterion, NotConverged},
    state::PressureSolve,
};

/// When a method's iterations end.
#[derive(Resource, Debug, Clone, Copy, PartialEq)]
pub struct Convergence {
    /// Limit η on the density error `(ρ − ρ0)/ρ0` [-].
    pub max_density_error: f32,
    /// Whether η limits the largest or the mean error.
    pub criterion: Criterion,
    /// Limit on the mean error beside that on the largest [-], if there is one.
    pub mean_density_error: Option<f32>,
    /// At least so many iterations.
    pub min_iterations: u32,
    /// At most so many.
    pub max_iterations: u32,
    /// What happens when `max_iterations` do not reach η.
    pub not_converged: NotConverged,
}

impl Convergence {
    /// The error that is limited, and the row that has the largest.
    ///
    /// Pressures that start at zero come from below; those of the last step, or with momentum, may be too high, and a
    /// step that takes them as long as nothing is compressed pumps energy: a dam break had 0.2 % more of it after 0.05
    /// s. There a particle with a pressure must not be under its rest density either.
    pub(super) fn judged(&self, solve: &PressureSolve) -> (f32, usize) {
        let error = solve.residual;
        let judged = match self.criterion {
            Criterion::Largest => error.largest,
            Criterion::Mean => error.mean,
        };
        // In the same measure: the mean over its own limit as the other over η.
        let by_mean = self
            .mean_density_error
            .map_or(0.0, |limit| error.mean * self.max_density_error / limit);
        (judged.max(by_mean), error.row)
    }
}
