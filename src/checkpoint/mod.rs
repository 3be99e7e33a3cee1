//! Checkpoints: the state of a run in a file, from which the run resumes bit for bit.
//!
//! [`Simulation::checkpoint`](crate::Simulation::checkpoint) and [`Simulation::resume`](crate::Simulation::resume) do
//! this for a simulation; a host with a world of its own calls [`write()`] and [`restore`].
//!
//! A checkpoint holds the scene; the number, the row and the persistent columns of every particle; the clock, the
//! control of the time step, and all other state that a step leaves for the next. A column or resource that persists is
//! declared so beside its code, which includes it in checkpoints. Walls, spatial indices and neighbour lists are
//! rebuilt: they follow from the scene and the positions alone, including the order of lists. A checksum of the walls
//! detects a difference.

mod error;
mod file;
mod restore;
mod save;
mod simulation;

pub use error::CheckpointError;
pub use error::FORMAT_VERSION;
pub use file::Checkpoint;
pub use restore::restore;
pub use save::{steps_between, steps_until_possible, write};
