//! Messages between the ranks of a run: processes, or worlds in one process, that share its particles.
//!
//! A [`Communicator`] carries bytes, and nothing else. What ranks decide together is folded from all their messages in
//! one place ([`Team`]), in the order of the ranks: no implementation can fold a sum in another order.

mod local;
mod team;

pub use local::Local;
pub(crate) use team::{Halo, Team};

/// The ranks that a message did not come from, or what was wrong with it: the run cannot go on.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum Lost {
    /// A rank has ended.
    #[error("rank {rank} has ended")]
    Ended {
        /// Its number.
        rank: usize,
    },
    /// A rank sent something else than was expected: it takes another step, or has another scene.
    #[error("rank {rank} takes another step than this one")]
    OutOfStep {
        /// Its number.
        rank: usize,
    },
    /// The communicator failed.
    #[error("{0}")]
    Other(String),
}

/// What carries messages between ranks.
///
/// All ranks call its methods in the same order, with a scene that is the same on each. A call may wait for others. It
/// comes from one thread at a time, not always the same.
pub trait Communicator: Send + Sync + 'static {
    /// Number of this rank, from 0.
    fn rank(&self) -> usize;

    /// Number of ranks.
    fn ranks(&self) -> usize;

    /// Sends one message to every rank, and returns the one that every rank sent to this one; its own comes back.
    fn exchange(&self, messages: Vec<Vec<u8>>) -> Result<Vec<Vec<u8>>, Lost>;

    /// Sends the same message to every rank, and returns those of all, in their order.
    fn gather(&self, message: Vec<u8>) -> Result<Vec<Vec<u8>>, Lost> {
        self.exchange(vec![message; self.ranks()])
    }
}
