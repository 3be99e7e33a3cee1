//! overfall
pub mod output;
pub mod particle;
pub mod scene;
pub mod step;

pub use step::{Phase, Simulation, StepError, StepReport};
