//! Plain data that every system of a step may use: components, columns, constants, clock, failure, threads.
//!
//! Nothing here knows of the systems that use it.

mod body_forces;
pub mod clock;
mod column;
mod columns;
mod execution;
pub mod failure;
mod failure_text;
mod material;
pub(crate) mod of_step;
pub mod particle;
mod phase;
mod ranks;
mod remembered;
mod residual;
mod room;
mod rows;
mod rows_of_columns;
mod saved;
pub(crate) mod seal;
mod shock;
mod stage;
mod state_column;
mod taken_back;
mod task_threads;
mod too_large;
pub mod transfer;
pub mod wrap;

pub use body_forces::BodyForces;
pub use clock::Clock;
pub(crate) use column::in_order;
pub use column::{Column, Lasting};
pub(crate) use columns::TOO_LARGE;
pub use columns::{
    Accelerations, COLUMNS, Densities, Displacements, MeanPressures, Positions, PredictedPositions,
    PressureAccelerations, Pressures, SENTINEL, Velocities,
};
pub use execution::{CHUNK, ChunkResults, Execution};
pub use failure::{
    DomainTooLarge, Failure, FailureCause, ListsTooLong, MAX_CELLS, Shock, StepError,
};
pub use material::Material;
pub use phase::Phase;
pub(crate) use ranks::{ChunkResult, agree};
pub(crate) use remembered::{Remembered, Remembers, from_bytes, to_bytes};
pub(crate) use residual::{Corrected, wants_force};
pub use residual::{DensityError, SolverState};
pub use rows::Rows;
pub use stage::{Limit, Product, Stage, Systems};
pub(crate) use stage::{PART_OF_PERIOD, chain};
pub(crate) use state_column::{GatheredColumn, StateColumn};
pub use taken_back::TakenBack;
pub(crate) use task_threads::start_task_threads;
