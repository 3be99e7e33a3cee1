//! Why a file of figures cannot be used.

use std::path::{Path, PathBuf};

/// Why a file gives no curve.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum CurveError {
    /// It cannot be read.
    #[error("{}: {source}", .file.display())]
    Unreadable {
        /// The file.
        file: PathBuf,
        /// What the system says.
        source: std::io::Error,
    },
    /// It has no such column.
    #[error("{}: there is no column `{name}`; the columns are {known}", .file.display())]
    NoColumn {
        /// The file.
        file: PathBuf,
        /// The field that names it, `time` or `value`.
        field: &'static str,
        /// The name.
        name: String,
        /// What there is.
        known: String,
    },
    /// A line is no row of figures, or there is none.
    #[error("{}:{line}: {message}", .file.display())]
    Malformed {
        /// The file.
        file: PathBuf,
        /// From 1.
        line: usize,
        /// What is wrong and what would be right.
        message: String,
    },
}

impl CurveError {
    /// The field of the reference that it is about.
    pub(crate) fn field(&self) -> &'static str {
        match self {
            Self::NoColumn { field, .. } => field,
            Self::Unreadable { .. } | Self::Malformed { .. } => "file",
        }
    }
}

/// A line that cannot be used.
pub(crate) fn malformed(file: &Path, line: usize, message: String) -> CurveError {
    CurveError::Malformed {
        file: file.to_owned(),
        line,
        message,
    }
}
