//! Why a mesh cannot be used.

use std::path::PathBuf;

/// Why a mesh cannot be a boundary. The message names the file and what would be right.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum MeshError {
    /// The file cannot be opened.
    #[error("cannot read the mesh {}: {source}", .file.display())]
    Unreadable {
        /// The file.
        file: PathBuf,
        /// What the operating system says.
        source: std::io::Error,
    },
    /// The file's text or bytes are no mesh, or not one that bounds a solid.
    #[error("the mesh {}: {message}", .file.display())]
    Unusable {
        /// The file.
        file: PathBuf,
        /// What is wrong and what would be right.
        message: String,
    },
}
