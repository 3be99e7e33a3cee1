//! Walls as particles: surfaces of shapes and meshes into one layer of samples, without a world.

mod candidates;
mod count;
mod front;
mod ground;
mod layer;
mod mesh;
mod round;
mod surfaces;
mod thin_parts;

use glam::Vec3;

pub(crate) use candidates::expected as expected_of_mesh;
pub(crate) use count::count;
pub use layer::{beside_wall, grip_of_wall, layer_depth, layer_depths};
pub use surfaces::sample;
pub(crate) use surfaces::{for_each_sample, for_each_sample_of, sample_boundary};
pub(crate) use thin_parts::has_thin_parts;

/// A boundary particle.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BoundarySample {
    /// Position \[m].
    pub position: Vec3,
    /// Unit vector from the solid into the fluid; in edges and corners the mean of the adjacent faces' normals.
    pub normal: Vec3,
    /// Depth behind the face of the wall \[m].
    pub depth: f32,
}
