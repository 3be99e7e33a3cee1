//! overfall
pub mod output;
pub mod particle;
pub mod scene;
pub mod step;

pub use step::{Phase, Plan, Simulation, StepError, StepReport, plan};
