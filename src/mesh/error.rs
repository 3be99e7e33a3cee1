//! Why a mesh cannot be used.

use std::path::PathBuf;

/// Why a mesh cannot be a boundary. The message names the file and the remedy.
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
}
