//! Boundaries that are surfaces of triangles: meshes, surfaces of revolution, ground. And bodies from files.

use std::path::Path;

use glam::DVec3;
use serde::{Deserialize, Serialize};

use super::{Particles, WallMotion, WallSlip, rotation::turn};
use crate::mesh::{Ground, HeightField, Mesh, MeshError, MeshSide, Place, Rolling};

/// A triangle mesh as a boundary: sampled evenly at the spacing, like the other shapes inside the solid.
///
/// A mesh's point p is put at `translation + rotation · (scale · p)`, in double precision, so the coordinates of a map
/// can be moved to the origin. Vertices on borders that are up to 1/100 spacing apart are taken for one.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct MeshBoundary {
    /// A Wavefront OBJ or an STL file (`.obj`, `.stl`), relative to the scene file's folder (after
    /// [`load`](super::Scene::load): to the working directory).
    pub file: String,
    /// Metres in one unit of the file.
    #[serde(default = "one")]
    pub scale: f64,
    /// Angles about the x, y and z axes, turned in this order \[°].
    #[serde(default)]
    #[cfg_attr(feature = "schema", schemars(with = "[f64; 3]"))]
    pub rotation: DVec3,
    /// Where the file's origin is put \[m].
    #[serde(default)]
    #[cfg_attr(feature = "schema", schemars(with = "[f64; 3]"))]
    pub translation: DVec3,
    /// Where the solid is.
    #[serde(default)]
    pub side: MeshSide,
    /// What gauges call it; boundaries of one name are one body to them.
    #[serde(default)]
    pub name: Option<String>,
    /// How it moves; it stands if absent.
    #[serde(default)]
    pub motion: Option<WallMotion>,
    /// How it holds the fluid along its face; not at all if absent.
    #[serde(default)]
    pub slip: WallSlip,
}

pub(super) fn one() -> f64 {
    1.0
}

/// A surface of revolution as a boundary: a profile goes round the y axis.
///
/// It is made of triangles about as large as the spacing, and sampled as a mesh is. The solid is where `side` says; for
/// `Front` the fluid is to the left of the profile, seen with the radius to the right and the height upwards.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct RevolutionBoundary {
    /// Radius and height of the profile's points \[m], in their order. It bounds a solid if it begins and ends on the
    /// axis (radius 0), or where it began.
    pub profile: Vec<[f32; 2]>,
    /// Where the point of the axis at height 0 is put \[m].
    #[serde(default)]
    #[cfg_attr(feature = "schema", schemars(with = "[f64; 3]"))]
    pub center: DVec3,
    /// Angles about axes through `center` along x, y and z, turned in this order \[°].
    #[serde(default)]
    #[cfg_attr(feature = "schema", schemars(with = "[f64; 3]"))]
    pub rotation: DVec3,
    /// Where the solid is.
    #[serde(default)]
    pub side: MeshSide,
    /// What gauges call it; boundaries of one name are one body to them.
    #[serde(default)]
    pub name: Option<String>,
    /// How it moves; it stands if absent.
    #[serde(default)]
    pub motion: Option<WallMotion>,
    /// How it holds the fluid along its face; not at all if absent.
    #[serde(default)]
    pub slip: WallSlip,
}

/// Ground as a boundary: heights on a rectangle, solid below. It is sampled evenly on its slopes. Beyond its border
/// there is nothing.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct TerrainBoundary {
    /// The heights, along y.
    pub heights: Heights,
    /// Edges of the rectangle along x and z \[m].
    pub size: [f32; 2],
    /// Where the rectangle's centre at height 0 is put \[m].
    #[serde(default)]
    #[cfg_attr(feature = "schema", schemars(with = "[f64; 3]"))]
    pub translation: DVec3,
    /// Angles about axes through that point along x, y and z, turned in this order \[°]: about z a ground that falls
    /// along x.
    #[serde(default)]
    #[cfg_attr(feature = "schema", schemars(with = "[f64; 3]"))]
    pub rotation: DVec3,
    /// What gauges call it; boundaries of one name are one body to them.
    #[serde(default)]
    pub name: Option<String>,
    /// How it moves; it stands if absent.
    #[serde(default)]
    pub motion: Option<WallMotion>,
    /// How it holds the fluid along its face; not at all if absent.
    #[serde(default)]
    pub slip: WallSlip,
}

/// Where the heights of a ground come from. Between the points of a grid they are linear.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
#[non_exhaustive]
pub enum Heights {
    /// A grey PNG of 8 or 16 bits, one point of the grid a pixel. Its left edge is at the lowest x, its top at the
    /// lowest z.
    Image {
        /// The file, relative to the scene file's folder (after [`load`](super::Scene::load): to the working
        /// directory).
        file: String,
        /// Height of black \[m].
        #[serde(default)]
        black: f64,
        /// Height of white \[m].
        white: f64,
    },
    /// A CSV file of heights without names: a line for every z, ascending, with the heights of all x, ascending. Lines
    /// that begin with `#` are comments.
    Grid {
        /// The file, relative to the scene file's folder (after [`load`](super::Scene::load): to the working
        /// directory).
        file: String,
        /// Metres in one unit of the file.
        #[serde(default = "one")]
        scale: f64,
    },
    /// A formula.
    Generated(Rolling),
}

/// A file that a body of fluid is made from. Its point p is put at `translation + rotation · (scale · p)`, with the
/// `rotation` of the body.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct FileShape {
    /// The file, relative to the scene file's folder (after [`load`](super::Scene::load): to the working directory).
    pub file: String,
    /// Metres in one unit of the file.
    #[serde(default = "one")]
    pub scale: f64,
    /// Where the file's origin is put \[m].
    #[serde(default)]
    #[cfg_attr(feature = "schema", schemars(with = "[f64; 3]"))]
    pub translation: DVec3,
}

impl Heights {
    /// Path of the file that they come from.
    pub(super) fn file_mut(&mut self) -> Option<&mut String> {
        match self {
            Self::Image { file, .. } | Self::Grid { file, .. } => Some(file),
            Self::Generated(_) => None,
        }
    }
}

impl Mesh {
    /// Reads and places a mesh for particles at a spacing \[m]. Seams of up to 1/100 of the spacing are closed. Fails
    /// if the file is not a mesh or if its surface does not define where the solid is.
    pub fn load(boundary: &MeshBoundary, spacing: f32) -> Result<Self, MeshError> {
        let place = Place::of_mesh(boundary.scale, boundary.rotation, boundary.translation);
        Self::read(Path::new(&boundary.file), place, boundary.side, spacing)
    }
}

impl FileShape {
    /// The mesh in the file before it is turned, solid inside, for particles at a spacing \[m].
    pub(crate) fn mesh(&self, spacing: f32) -> Result<Mesh, MeshError> {
        let place = Place::of_mesh(self.scale, DVec3::ZERO, self.translation);
        Mesh::read(Path::new(&self.file), place, MeshSide::Outside, spacing)
    }

    /// The vertices of the mesh in the file before it is turned \[m].
    pub(super) fn vertices(&self) -> Result<Vec<DVec3>, MeshError> {
        let place = Place::of_mesh(self.scale, DVec3::ZERO, self.translation);
        crate::mesh::vertices(Path::new(&self.file), place)
    }

    /// The particles in the file before they are turned.
    pub(crate) fn particles(&self) -> Result<Particles, String> {
        let mut particles = Particles::load(Path::new(&self.file))?;
        for position in &mut particles.positions {
            *position = self.translation + self.scale * *position;
        }
        Ok(particles)
    }
}

impl RevolutionBoundary {
    /// Its surface for particles at a spacing \[m].
    pub(super) fn mesh(&self, spacing: f32) -> Result<Mesh, MeshError> {
        let place = Place::turned(turn(self.rotation), self.center);
        Mesh::of_revolution(&self.profile, place, self.side, spacing)
    }
}

impl TerrainBoundary {
    /// Its surface for particles at a spacing \[m].
    pub(super) fn mesh(&self, spacing: f32) -> Result<Mesh, MeshError> {
        let ground = match &self.heights {
            Heights::Image { file, black, white } => {
                Ground::image(Path::new(file), *black, *white)?
            }
            Heights::Grid { file, scale } => Ground::grid(Path::new(file), *scale)?,
            Heights::Generated(rolling) => Ground::generated(rolling, self.size)?,
        };
        let place = Place::turned(turn(self.rotation), self.translation);
        Mesh::of_ground(HeightField::new(ground, self.size, place), spacing)
    }
}
