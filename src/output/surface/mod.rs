//! The fluid's surface as a mesh of triangles: its files, and how it is found.
//!
//! `Surfacing::of` (feature `surface`) makes a [`SurfaceMesh`] from a [`Frame`](super::Frame); it is written as PLY,
//! OBJ or VTK, and `picture::draw_surface` (feature `cli`) draws it.

mod files;
mod mesh;
#[cfg(feature = "surface")]
mod motion;
#[cfg(feature = "surface")]
mod reconstruct;

pub use files::SurfaceFormat;
pub use mesh::SurfaceMesh;
#[cfg(feature = "surface")]
pub use reconstruct::{SurfaceError, Surfacing};
