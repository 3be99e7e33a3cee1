//! Checkpoints of a [`Simulation`].

use std::path::Path;

use super::{error::CheckpointError, file::Checkpoint};
use crate::{input, output::write_durably, step::Simulation};

impl Simulation {
    /// Writes the state of the run to a file: under a temporary name first, then flushed to the disk, then renamed. An
    /// older file with the same name stays complete until then.
    ///
    /// ```
    /// use overfall::{Simulation, scene::Scene};
    ///
    /// let scene = r#"(
    ///     name: "drop",
    ///     spacing: 0.1,
    ///     bodies: [(shape: Sphere(center: (0, 1, 0), radius: 0.3))],
    /// )"#;
    /// let scene = Scene::parse(scene, "drop.ron", &[]).expect("a scene");
    /// let mut simulation = Simulation::new(&scene).expect("threads");
    /// simulation.step().expect("a step");
    /// let file = std::env::temp_dir().join(format!("drop_{}.checkpoint", std::process::id()));
    /// simulation.checkpoint(&file).expect("a checkpoint");
    /// let mut resumed = Simulation::resume(&file).expect("the same run");
    /// let [a, b] = [&mut simulation, &mut resumed].map(|run| run.step().expect("a step"));
    /// assert_eq!((a.step, a.kinetic_energy), (b.step, b.kinetic_energy));
    /// # std::fs::remove_file(file).expect("a file of our own");
    /// ```
    ///
    /// # Errors
    /// See [`checkpoint::write`](super::write).
    pub fn checkpoint(&mut self, path: &Path) -> Result<(), CheckpointError> {
        let bytes = Checkpoint::of(self.world_mut())?.to_bytes();
        Ok(write_durably(path, &bytes)?)
    }

    /// Resumes the run of a checkpoint, with a thread per core. The steps are those of an uninterrupted run, bit for
    /// bit.
    ///
    /// # Errors
    /// When the file cannot be read, is cut off, altered, of another kind or of a newer version, or when a file that
    /// the scene names has changed.
    pub fn resume(path: &Path) -> Result<Self, CheckpointError> {
        Self::resume_with_threads(path, 0)
    }

    /// As [`resume`](Self::resume), with a number of threads; 0 takes all cores.
    pub fn resume_with_threads(path: &Path, threads: usize) -> Result<Self, CheckpointError> {
        let checkpoint = Checkpoint::read(&mut input::open(path)?)?;
        let mut simulation = Self::with_threads(&checkpoint.scene()?, threads)?;
        checkpoint.restore(simulation.world_mut())?;
        Ok(simulation)
    }
}
