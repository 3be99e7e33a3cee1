//! Errors of writing and reading files.

use std::path::{Path, PathBuf};

/// Why a file could not be written or read.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum OutputError {
    /// The operating system reported an error.
    #[error("{path}: {source}", path = .path.display())]
    Io {
        /// The file.
        path: PathBuf,
        /// Error of the operating system.
        source: std::io::Error,
    },
    /// The file does not have the format of its name, or is damaged.
    #[error("{path}: {reason}", path = .path.display())]
    Malformed {
        /// The file.
        path: PathBuf,
        /// What is wrong with it.
        reason: String,
    },
    /// The name ends in no known format.
    #[error("{path}: unknown format; a frame's name ends in .vtu or .ply", path = .path.display())]
    UnknownFormat {
        /// The file.
        path: PathBuf,
    },
    /// The columns of a frame differ in length.
    #[error("field {field} has {found} rows, the positions have {expected}")]
    UnequalColumns {
        /// Name of the column.
        field: &'static str,
        /// Number of its rows.
        found: usize,
        /// Number of rows of the positions.
        expected: usize,
    },
    /// More particles than the format can number.
    #[error("{particles} particles are more than a frame file can number (2147483647)")]
    TooManyParticles {
        /// Particles of the frame.
        particles: usize,
    },
    /// A picture takes more memory while it is drawn than the process can have.
    #[error(
        "a picture of {width} × {height} pixels: drawing it takes about {needed} of memory, which the process cannot \
         have; run with `--no-pictures`, and draw the pictures later with `overfall picture`, or raise the limit \
         (`ulimit -v`)"
    )]
    NoMemory {
        /// Width \[pixels].
        width: usize,
        /// Height \[pixels].
        height: usize,
        /// What it takes, in words.
        needed: String,
    },
    /// More vertices or corners of a surface than its file can number.
    #[error(
        "a surface of {vertices} vertices or corners is more than a file can number (2147483647); make its cubes larger"
    )]
    TooManyVertices {
        /// Vertices or corners of the surface.
        vertices: usize,
    },
}

impl OutputError {
    pub(super) fn io(path: &Path, source: std::io::Error) -> Self {
        Self::Io {
            path: path.to_owned(),
            source,
        }
    }

    pub(super) fn malformed(path: &Path, reason: impl Into<String>) -> Self {
        Self::Malformed {
            path: path.to_owned(),
            reason: reason.into(),
        }
    }
}

/// Fails at the first column whose number of rows is not that of the positions.
pub(super) fn equal_columns(
    expected: usize,
    columns: impl IntoIterator<Item = (&'static str, usize)>,
) -> Result<(), OutputError> {
    let other = columns.into_iter().find(|&(_, found)| found != expected);
    other.map_or(Ok(()), |(field, found)| {
        Err(OutputError::UnequalColumns {
            field,
            found,
            expected,
        })
    })
}
