//! Why steps are taken back though they did not fail.

/// What makes a step one to go back from, though none of the failure guard's limits is broken.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum Shock {
    /// The largest density error grew by more than 8 η in a step.
    #[error(
        "the largest density error jumped from {before:.3e} to {error:.3e}, by more than 8 η = {limit:.3e}"
    )]
    ErrorJumped {
        /// Largest error before \[-].
        before: f32,
        /// Largest error of this step \[-].
        error: f32,
        /// The largest jump, 8 η \[-].
        limit: f32,
    },
    /// The largest density error is above the scene's limit.
    #[error(
        "the largest density error {error:.3e} is above `time_step.max_density_error` = {limit:.3e}"
    )]
    ErrorTooLarge {
        /// Largest error \[-].
        error: f32,
        /// The limit \[-].
        limit: f32,
    },
    /// A particle moved more than 0.45 h.
    #[error("a particle moved {displacement:.3e} m in one step, more than 0.45 h = {limit:.3e} m")]
    TooFast {
        /// Length of the movement \[m].
        displacement: f32,
        /// The limit \[m].
        limit: f32,
    },
}
