//! What a file gives before it is a surface.

use glam::DVec3;

/// Triangles of no file.
#[derive(Debug, Default)]
pub(super) struct Soup {
    pub(super) vertices: Vec<DVec3>,
    pub(super) triangles: Vec<[u32; 3]>,
}
