//! Triangle meshes: read from a file, placed in the scene, asked for distances and for what a ray meets.
//!
//! Whether a point is in the solid is the sign of its offset from the nearest point of the surface along the
//! angle-weighted pseudonormal there (Bærentzen & Aanæs 2005), which is right for every closed mesh and, unlike
//! counting crossings of a ray, local: it serves open meshes, too.
//!
//! Option 2 was the geometry library parry, which has all of this; it would add some thirty crates to the library of an
//! embedder.

mod bvh;
mod error;
mod load;
mod obj;
mod polygon;
mod read;
mod shells;
mod soup;
mod stl;
mod surface;
mod text;
mod topology;
mod triangle;
mod weld;

pub use error::MeshError;
pub(crate) use load::TOLERANCE;
pub(crate) use surface::FeatureEdge;
pub use surface::{Mesh, Nearest};
