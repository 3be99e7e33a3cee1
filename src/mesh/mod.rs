//! Triangle meshes: read from a file, placed in the scene, queried for distances and ray intersections.
//!
//! Whether a point is in the solid is decided by the sign of its offset from the nearest point of the surface, along
//! the angle-weighted pseudonormal there (Bærentzen & Aanæs 2005). This is correct for every closed mesh. Unlike
//! counting the intersections of a ray it is local, so it serves open meshes, too.
//!
//! Option 2 was the geometry library parry, which offers all of this; it would add about thirty crates to the
//! dependencies of a host.

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
