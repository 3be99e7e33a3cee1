//! Why a mesh cannot be used.

use std::path::PathBuf;

/// Why a surface cannot be used. The message names the file, if there is one, and the remedy.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum MeshError {
    /// The file cannot be opened.
    #[error("cannot read the mesh {}: {source}", .file.display())]
    Unreadable {
        /// The file.
        file: PathBuf,
        /// Error of the operating system.
        source: std::io::Error,
    },
    /// The content of the file is not a mesh, or its surface does not bound a solid.
    #[error("the mesh {}: {message}", .file.display())]
    Unusable {
        /// The file.
        file: PathBuf,
        /// What is wrong, and the remedy.
        message: String,
    },
    /// The content of the file is no heights of a ground.
    #[error("the heights {}: {message}", .file.display())]
    Heights {
        /// The file.
        file: PathBuf,
        /// What is wrong, and the remedy.
        message: String,
    },
    /// What is written of a surface does not make one; says what is wrong, and the remedy.
    #[error("{0}")]
    Surface(String),
}
