//! Triangle meshes: read from a file, placed in the scene, queried for distances and ray intersections.
//!
//! Whether a point is in the solid is decided by the sign of its offset from the nearest point of the surface, along
//! the angle-weighted pseudonormal there (Bærentzen & Aanæs 2005). This is correct for every closed mesh. Unlike
//! counting the intersections of a ray it is local, so it serves open meshes, too.
//!
//! Option 2 was the geometry library parry, which offers all of this; it would add about thirty crates to the
//! dependencies of a host.

mod bvh;
#[cfg(feature = "polygons")]
mod delaunay;
mod error;
mod ground;
#[cfg(feature = "images")]
mod ground_image;
mod height_field;
mod load;
mod obj;
mod place;
mod polygon;
mod random;
mod read;
mod revolution;
mod shells;
mod side;
mod soup;
mod stl;
mod surface;
mod text;
mod topology;
mod triangle;
mod weld;

pub(crate) use bvh::Bvh;
pub use error::MeshError;
pub(crate) use ground::Ground;
pub use ground::{Channel, Rolling};
pub(crate) use height_field::HeightField;
pub(crate) use load::{TOLERANCE, vertices};
pub(crate) use place::Place;
pub(crate) use random::split_mix;
pub use side::MeshSide;
pub(crate) use surface::FeatureEdge;
pub use surface::{Mesh, Nearest};
