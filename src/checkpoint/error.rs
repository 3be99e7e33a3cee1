//! Errors of writing checkpoints and of resuming from them.

use std::io;

use crate::{
    output::OutputError,
    ranks::Unsupported,
    scene::SceneError,
    step::{InstallError, NotBetweenSteps},
};

/// Version of the format, increased when a part changes its meaning.
pub const FORMAT_VERSION: u32 = 3;

/// Why a checkpoint could not be written or a run not be resumed.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum CheckpointError {
    /// The operating system reported an error.
    #[error(transparent)]
    Io(#[from] io::Error),
    /// The file could not be written.
    #[error(transparent)]
    File(#[from] OutputError),
    /// The file is not a checkpoint.
    #[error("this is no checkpoint of overfall")]
    Foreign,
    /// The file ends too early.
    #[error("the checkpoint is cut off: it has {found} bytes of {expected}")]
    Truncated {
        /// Expected size \[bytes].
        expected: u64,
        /// Actual size \[bytes].
        found: u64,
    },
    /// The bytes differ from those that were written.
    #[error("the checkpoint is damaged: its checksum is {found:08x}, not {expected:08x}")]
    Altered {
        /// The checksum in the file.
        expected: u32,
        /// The checksum of the bytes.
        found: u32,
    },
    /// A newer program wrote the file.
    #[error(
        "the checkpoint has format {found}, this program reads {FORMAT_VERSION}; resume with the program that wrote it"
    )]
    Version {
        /// Format of the file.
        found: u32,
    },
    /// The file is complete, but this program cannot use one of its parts.
    #[error("the checkpoint's {part} cannot be used: {reason}")]
    Malformed {
        /// Name of the part.
        part: String,
        /// Reason.
        reason: String,
    },
    /// The checkpoint belongs to another run.
    #[error("the checkpoint is of another run: {0}")]
    OtherRun(String),
    /// Some stages of the scene's order have not run in the last step.
    #[error(
        "no checkpoint between two runs of stages that do not run in every step: the next is possible in {steps} steps"
    )]
    BetweenRuns {
        /// Steps until all of them are due.
        steps: u64,
    },
    /// In no step are all stages due whose products others read in later steps.
    #[error(
        "with this order no checkpoint is possible: stages read what earlier steps left, and in no step are all of \
         them due that make it; give their groups offsets that meet"
    )]
    NeverPossible,
    /// The scene in the checkpoint is invalid.
    #[error("the checkpoint's scene: {0}")]
    Scene(#[from] SceneError),
    /// The scene in the checkpoint could not be installed.
    #[error("the checkpoint's scene: {0}")]
    Install(#[from] InstallError),
    /// A step is being taken, or a part of the scene is gone.
    #[error(transparent)]
    NotBetweenSteps(#[from] NotBetweenSteps),
    /// The other ranks do not answer any more.
    #[error("no checkpoint without all ranks, some of which have ended")]
    RanksLost,
    /// The scene has what a checkpoint of several ranks cannot hold.
    #[error(transparent)]
    Unsupported(#[from] Unsupported),
    /// The world has no scene.
    #[error("no scene is installed in this world; call `install` first")]
    NotInstalled,
}

impl CheckpointError {
    pub(super) fn malformed(part: impl Into<String>, reason: impl Into<String>) -> Self {
        Self::Malformed {
            part: part.into(),
            reason: reason.into(),
        }
    }
}
