//! overfall

pub mod boundary;
pub mod column;
pub mod density;
pub mod execution;
pub mod force;
pub mod index;
pub mod integrate;
pub mod kernel;
pub mod material;
pub mod neighbours;
pub mod output;
pub mod pairs;
pub mod particle;
pub mod pressure;
pub mod reorder;
pub mod scene;
pub mod simd;
pub mod step;
pub mod time_step;

pub use step::{Phase, Plan, Simulation, Step, StepError, StepOutcome, StepReport, install, plan};
