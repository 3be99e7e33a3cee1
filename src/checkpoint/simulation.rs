//! Checkpoints of a scene in a world of its own.

use std::fs::File;
use std::path::Path;

use super::{error::CheckpointError, file::Checkpoint};
use crate::{output::write_durably, step::Simulation};

impl Simulation {
    /// Writes the state of the run to a file: to a temporary name first, then to the disk, then renamed. An older file
    /// of the name stays whole until then.
    ///
    /// # Errors
    /// See [`checkpoint::write`](super::write).
    pub fn checkpoint(&mut self, path: &Path) -> Result<(), CheckpointError> {
        let bytes = Checkpoint::of(self.world_mut())?.to_bytes();
        Ok(write_durably(path, &bytes)?)
    }

    /// Goes on with the run of a checkpoint, with as many threads as the machine has cores. The steps are those of the
    /// run that was never interrupted, bit for bit.
    ///
    /// # Errors
    /// When the file cannot be read, is cut off, altered, of another kind or of a newer version, or when a file that the
    /// scene names has changed.
    pub fn resume(path: &Path) -> Result<Self, CheckpointError> {
        Self::resume_with_threads(path, 0)
    }

    /// As [`resume`](Self::resume), with a number of threads; 0 takes all cores.
    pub fn resume_with_threads(path: &Path, threads: usize) -> Result<Self, CheckpointError> {
        let checkpoint = Checkpoint::read(&mut File::open(path)?)?;
        let mut simulation = Self::with_threads(&checkpoint.scene()?, threads)?;
        checkpoint.restore(simulation.world_mut())?;
        Ok(simulation)
    }
}
