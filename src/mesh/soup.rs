//! The raw triangles of a file, before they are connected to a surface.

use glam::DVec3;

/// Triangles without connectivity.
#[derive(Debug, Default)]
pub(super) struct Soup {
    pub(super) vertices: Vec<DVec3>,
    pub(super) triangles: Vec<[u32; 3]>,
}
