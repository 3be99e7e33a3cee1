//! Convergence criteria of the pressure iterations.

use bevy_ecs::prelude::*;

use crate::{
    scene::{Criterion, NotConverged},
    state::SolverState,
};

/// Convergence criterion of a method.
#[derive(Resource, Debug, Clone, Copy, PartialEq)]
pub struct Convergence {
    /// Limit η on the density error `(ρ − ρ0)/ρ0` \[-].
    pub(crate) max_density_error: f32,
    /// Whether η limits the largest or the mean error.
    pub(crate) criterion: Criterion,
    /// Additional limit on the mean error \[-], if the criterion limits the largest one.
    pub(crate) mean_density_error: Option<f32>,
    /// Minimum number of iterations.
    pub(crate) min_iterations: u32,
    /// Maximum number of iterations.
    pub(crate) max_iterations: u32,
    /// What happens if `max_iterations` do not reach η.
    pub(crate) not_converged: NotConverged,
}

impl Convergence {
    /// The error that the criterion limits, and the row with the largest error.
    ///
    /// Pressures that start at zero converge from below. Pressures of the last step, or iterations with momentum, may
    /// be too high; a solver that accepts them as long as nothing is compressed adds energy (0.2 % after 0.05 s of a
    /// dam break). Therefore a particle with pressure must not be below its rest density either.
    pub(super) fn measured_error(&self, solve: &SolverState) -> (f32, usize) {
        let error = solve.residual;
        let measured = match self.criterion {
            Criterion::Largest => error.largest,
            Criterion::Mean => error.mean,
        };
        // Scaled to the same limit: η times the mean error over the mean's own limit.
        let by_mean = self
            .mean_density_error
            .map_or(0.0, |limit| error.mean * self.max_density_error / limit);
        (measured.max(by_mean), error.row)
    }
}
