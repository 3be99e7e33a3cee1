//! Plain data that every system of a step may use: components, columns, constants, clock, failure, threads.
//!
//! Nothing here knows of the systems that use it.

pub mod clock;
mod columns;
mod execution;
pub mod failure;
mod material;
pub mod particle;
mod phase;
pub mod transfer;

pub use clock::Clock;
pub(crate) use columns::TOO_LARGE;
pub use columns::{
    Accelerations, Densities, Positions, PredictedPositions, PressureAccelerations, Pressures,
    Rows, SENTINEL, Velocities,
};
pub(crate) use execution::start_task_threads;
pub use execution::{CHUNK, ChunkResults, Execution};
pub use failure::{
    DomainTooLarge, Failure, FailureCause, ListsTooLong, MAX_CELLS, Shock, StepError, TakenBack,
};
pub use material::Material;
pub use phase::Phase;
pub(crate) use transfer::in_order;
