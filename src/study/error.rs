//! Errors of studies.

use std::path::PathBuf;

use crate::scene::{Place, SceneError};
use crate::{state::StepError, step::InstallError};

/// A study that cannot be read, is invalid, or cannot be started.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum StudyError {
    /// A file cannot be read.
    #[error("{}: cannot read the {what}: {source}", .file.display())]
    Unreadable {
        /// Kind of file: a study, figures to compare with.
        what: &'static str,
        /// The file.
        file: PathBuf,
        /// Error of the operating system.
        source: std::io::Error,
    },
    /// The study, or a file it names, is invalid.
    #[error("{place}: {message}")]
    Refused {
        /// Location of the mistake.
        place: Place,
        /// The mistake and the remedy.
        message: String,
    },
    /// The text is not a study, or the scene it names is itself invalid.
    #[error(transparent)]
    Scene(#[from] SceneError),
    /// A variant could not be set up.
    #[error("{variant}: {error}")]
    Install {
        /// The variant's label.
        variant: String,
        /// Reason.
        error: Box<InstallError>,
    },
    /// The simulation that leads to the start of a case failed.
    #[error("the start of {case} failed: {error}")]
    Start {
        /// Name of the case; of the study if it has no cases.
        case: String,
        /// Reason.
        error: Box<StepError>,
    },
    /// The progress of an earlier study does not fit.
    #[error("the study cannot resume: {0}")]
    Resume(String),
    /// The operating system refused to start threads.
    #[error("could not start threads: {0}")]
    Threads(std::io::Error),
}
