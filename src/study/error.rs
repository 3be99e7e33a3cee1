//! Why a study is refused or cannot go on.

use std::path::PathBuf;

use crate::scene::{Place, SceneError};
use crate::{state::StepError, step::InstallError};

/// A study that cannot be read, makes no sense, or could not be started.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum StudyError {
    /// A file cannot be read.
    #[error("{}: cannot read the {what}: {source}", .file.display())]
    Unreadable {
        /// What the file is: a study, figures to compare with.
        what: &'static str,
        /// The file.
        file: PathBuf,
        /// What the operating system says.
        source: std::io::Error,
    },
    /// The study, or a file it names, is wrong.
    #[error("{place}: {message}")]
    Refused {
        /// Where.
        place: Place,
        /// What is wrong and what would be right.
        message: String,
    },
    /// The text is no study, or the scene it names is wrong in itself.
    #[error(transparent)]
    Scene(#[from] SceneError),
    /// A variant could not be set up.
    #[error("{variant}: {error}")]
    Install {
        /// The variant's label.
        variant: String,
        /// Why.
        error: Box<InstallError>,
    },
    /// The state that all variants of a case set out from could not be simulated.
    #[error("the start of {case} failed: {error}")]
    Start {
        /// The case, or the study if it has none.
        case: String,
        /// Why.
        error: Box<StepError>,
    },
    /// The system gave no threads.
    #[error("could not start threads: {0}")]
    Threads(#[from] rayon::ThreadPoolBuildError),
}
