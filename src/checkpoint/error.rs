//! Why there is no checkpoint, or none to go on from.

use std::io;

use crate::{output::OutputError, scene::SceneError, step::InstallError};

/// Version of the format, raised when a part changes its meaning.
pub const FORMAT_VERSION: u32 = 1;

/// Why a checkpoint could not be written or a run not be resumed.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum CheckpointError {
    /// The system refused.
    #[error(transparent)]
    Io(#[from] io::Error),
    /// The system refused to write the file.
    #[error(transparent)]
    File(#[from] OutputError),
    /// The file is something else.
    #[error("this is no checkpoint of overfall")]
    Foreign,
    /// The file ends too early.
    #[error("the checkpoint is cut off: it has {found} bytes of {expected}")]
    Truncated {
        /// Bytes that it should have.
        expected: u64,
        /// Bytes that there are.
        found: u64,
    },
    /// The bytes are not those that were written.
    #[error("the checkpoint is damaged: its checksum is {found:08x}, not {expected:08x}")]
    Altered {
        /// The checksum in the file.
        expected: u32,
        /// That of the bytes.
        found: u32,
    },
    /// A newer program wrote the file.
    #[error(
        "the checkpoint has format {found}, this program reads {FORMAT_VERSION}; resume with the program that wrote it"
    )]
    Version {
        /// Its format.
        found: u32,
    },
    /// The file is whole, but a part of it is not what this program writes.
    #[error("the checkpoint's {part} cannot be used: {reason}")]
    Malformed {
        /// Which part.
        part: String,
        /// Why.
        reason: String,
    },
    /// The checkpoint is of another run.
    #[error("the checkpoint is of another run: {0}")]
    OtherRun(String),
    /// Stages of the scene's order have not run in every step.
    #[error(
        "no checkpoint between two runs of stages that do not run in every step: the next is possible in {steps} steps"
    )]
    BetweenRuns {
        /// Steps until all of them are due.
        steps: u64,
    },
    /// The scene in the checkpoint is none.
    #[error("the checkpoint's scene: {0}")]
    Scene(#[from] SceneError),
    /// The scene in the checkpoint could not be set up.
    #[error("the checkpoint's scene: {0}")]
    Install(#[from] InstallError),
    /// The world holds no scene.
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
