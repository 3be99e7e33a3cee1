//! Where things are: dimension, boxes, bodies of fluid, solid boundaries.

use glam::{DVec3, Vec3};
use serde::{Deserialize, Serialize};

use super::{
    FileShape, MeshBoundary, RevolutionBoundary, TerrainBoundary, VelocityField, WallMotion,
    WallSlip,
};

/// The number of space dimensions, 2 or 3 in the file.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(try_from = "u8", into = "u8")]
pub enum Dimension {
    /// The plane z = 0.
    Two,
    /// Space.
    #[default]
    Three,
}

/// An axis-aligned box. In 2-D its z range only has to hold 0.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct Bounds {
    /// Lower corner \[m].
    #[cfg_attr(feature = "schema", schemars(with = "[f32; 3]"))]
    pub min: Vec3,
    /// Upper corner \[m].
    #[cfg_attr(feature = "schema", schemars(with = "[f32; 3]"))]
    pub max: Vec3,
}

/// One body of fluid: a shape filled with particles on a lattice.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct FluidBody {
    /// Where.
    pub shape: Shape,
    /// Angles about axes through the shape's centre along x, y and z, turned in this order \[°]; in 2-D about z alone.
    #[serde(default)]
    #[cfg_attr(feature = "schema", schemars(with = "[f64; 3]"))]
    pub rotation: DVec3,
    /// Velocity at the start, of the shape's centre \[m/s].
    #[serde(default)]
    #[cfg_attr(feature = "schema", schemars(with = "[f32; 3]"))]
    pub velocity: Vec3,
    /// Rows of the gradient `∂v_i/∂x_j` of the velocity at the start \[1/s]: a strain or a rotation about the shape's
    /// centre. `((0, -w, 0), (w, 0, 0), (0, 0, 0))` turns by w about z.
    #[serde(default)]
    #[cfg_attr(feature = "schema", schemars(with = "[[f32; 3]; 3]"))]
    pub velocity_gradient: [Vec3; 3],
    /// Velocities at the start that come to these: rotation about a point, vortices; none if absent.
    #[serde(default)]
    pub velocity_field: Option<VelocityField>,
    /// Random displacement of the particles; none if absent.
    #[serde(default)]
    pub jitter: Option<Jitter>,
    /// Whether particles of it that boundaries leave no room for are left out, as water over ground needs it. If not,
    /// a body that overlaps a boundary is refused. A tank cuts nothing.
    #[serde(default)]
    pub cut: bool,
}

/// Random displacement of a lattice: the same seed gives the same particles everywhere.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct Jitter {
    /// Largest displacement a coordinate, in spacings \[-]; from 0 to below 0.5.
    pub amplitude: f32,
    /// Seed of the generator.
    #[serde(default)]
    pub seed: u64,
}

/// The volume a body of fluid fills at the start; [`shapes`](super::shapes) says with which particles.
///
/// In 2-D a box's z range only has to hold 0, a sphere is a disc with its centre at z = 0, and a cylinder is refused.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
#[non_exhaustive]
pub enum Shape {
    /// Axis-aligned box.
    Box {
        /// Lower corner \[m].
        #[cfg_attr(feature = "schema", schemars(with = "[f32; 3]"))]
        min: Vec3,
        /// Upper corner \[m].
        #[cfg_attr(feature = "schema", schemars(with = "[f32; 3]"))]
        max: Vec3,
    },
    /// Ball.
    Sphere {
        /// Centre \[m].
        #[cfg_attr(feature = "schema", schemars(with = "[f32; 3]"))]
        center: Vec3,
        /// Radius \[m].
        radius: f32,
    },
    /// Cylinder between two points, with flat ends.
    Cylinder {
        /// Centre of one end \[m].
        #[cfg_attr(feature = "schema", schemars(with = "[f32; 3]"))]
        start: Vec3,
        /// Centre of the other end \[m].
        #[cfg_attr(feature = "schema", schemars(with = "[f32; 3]"))]
        end: Vec3,
        /// Radius \[m].
        radius: f32,
    },
    /// What a closed triangle mesh (`.obj`, `.stl`) bounds, filled with a lattice along its file's axes; 3-D only.
    Mesh(FileShape),
    /// The particles of a file: PLY (ASCII or binary), VTU (base64, raw or ASCII) or CSV, with positions and, if
    /// the file has them, velocities, to which `velocity` is added. No lattice is made.
    Particles(FileShape),
}

/// A solid boundary, sampled with one layer of particles at the spacing, about half a spacing inside the solid.
///
/// Fluid must start at least half a spacing (from a particle's centre) off it; where there are tanks, inside one. A
/// solid that is thinner than twice the depth of its layer of samples, about 1.2 spacings, counts as that thick, and so
/// do the walls of a tank. In 2-D a box's or tank's z range only has to hold 0; centres and normals have z = 0.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
#[non_exhaustive]
pub enum BoundaryShape {
    /// A tank that holds fluid inside the box `min`–`max`.
    Tank {
        /// Lower inner corner \[m].
        #[cfg_attr(feature = "schema", schemars(with = "[f32; 3]"))]
        min: Vec3,
        /// Upper inner corner \[m].
        #[cfg_attr(feature = "schema", schemars(with = "[f32; 3]"))]
        max: Vec3,
        /// Whether the side towards +y is missing.
        #[serde(default)]
        open: bool,
        /// Angles about axes through its centre along x, y and z, turned in this order \[°]; in 2-D about z alone.
        #[serde(default)]
        #[cfg_attr(feature = "schema", schemars(with = "[f64; 3]"))]
        rotation: DVec3,
        /// What gauges call it; boundaries of one name are one body to them.
        #[serde(default)]
        name: Option<String>,
        /// How it moves; it stands if absent.
        #[serde(default)]
        motion: Option<WallMotion>,
        /// How it holds the fluid along its face; not at all if absent.
        #[serde(default)]
        slip: WallSlip,
    },
    /// A solid box.
    Box {
        /// Lower corner \[m].
        #[cfg_attr(feature = "schema", schemars(with = "[f32; 3]"))]
        min: Vec3,
        /// Upper corner \[m].
        #[cfg_attr(feature = "schema", schemars(with = "[f32; 3]"))]
        max: Vec3,
        /// Angles about axes through its centre along x, y and z, turned in this order \[°]; in 2-D about z alone.
        #[serde(default)]
        #[cfg_attr(feature = "schema", schemars(with = "[f64; 3]"))]
        rotation: DVec3,
        /// What gauges call it; boundaries of one name are one body to them.
        #[serde(default)]
        name: Option<String>,
        /// How it moves; it stands if absent.
        #[serde(default)]
        motion: Option<WallMotion>,
        /// How it holds the fluid along its face; not at all if absent.
        #[serde(default)]
        slip: WallSlip,
    },
    /// A solid sphere (a disc in 2-D).
    Sphere {
        /// Centre \[m].
        #[cfg_attr(feature = "schema", schemars(with = "[f32; 3]"))]
        center: Vec3,
        /// Radius \[m].
        radius: f32,
        /// Angles about axes through its centre along x, y and z, turned in this order \[°]; in 2-D about z alone.
        #[serde(default)]
        #[cfg_attr(feature = "schema", schemars(with = "[f64; 3]"))]
        rotation: DVec3,
        /// What gauges call it; boundaries of one name are one body to them.
        #[serde(default)]
        name: Option<String>,
        /// How it moves; it stands if absent.
        #[serde(default)]
        motion: Option<WallMotion>,
        /// How it holds the fluid along its face; not at all if absent.
        #[serde(default)]
        slip: WallSlip,
    },
    /// A flat rectangular wall (a line in 2-D) that is solid on the far side of its normal.
    Plane {
        /// Centre of the wall \[m].
        #[cfg_attr(feature = "schema", schemars(with = "[f32; 3]"))]
        center: Vec3,
        /// Direction from the solid into the fluid; any length but zero.
        #[cfg_attr(feature = "schema", schemars(with = "[f32; 3]"))]
        normal: Vec3,
        /// Half the edge of the square \[m]; its edges lie along [`shapes::wall_axes`](super::shapes::wall_axes).
        half_size: f32,
        /// Angles about axes through its centre along x, y and z, turned in this order \[°]; in 2-D about z alone.
        #[serde(default)]
        #[cfg_attr(feature = "schema", schemars(with = "[f64; 3]"))]
        rotation: DVec3,
        /// What gauges call it; boundaries of one name are one body to them.
        #[serde(default)]
        name: Option<String>,
        /// How it moves; it stands if absent.
        #[serde(default)]
        motion: Option<WallMotion>,
        /// How it holds the fluid along its face; not at all if absent.
        #[serde(default)]
        slip: WallSlip,
    },
    /// A surface of triangles; 3-D only.
    Mesh(MeshBoundary),
    /// A surface of revolution; 3-D only.
    Revolution(RevolutionBoundary),
    /// Ground by its heights; 3-D only.
    Terrain(TerrainBoundary),
}

impl BoundaryShape {
    /// What gauges call it.
    pub fn name(&self) -> Option<&str> {
        match self {
            Self::Tank { name, .. }
            | Self::Box { name, .. }
            | Self::Sphere { name, .. }
            | Self::Plane { name, .. } => name.as_deref(),
            Self::Mesh(mesh) => mesh.name.as_deref(),
            Self::Revolution(surface) => surface.name.as_deref(),
            Self::Terrain(terrain) => terrain.name.as_deref(),
        }
    }

    /// Paths of the files that it names.
    pub(crate) fn files_mut(&mut self) -> impl Iterator<Item = &mut String> {
        let (mesh, motion) = match self {
            Self::Tank { motion, .. }
            | Self::Box { motion, .. }
            | Self::Sphere { motion, .. }
            | Self::Plane { motion, .. } => (None, motion),
            Self::Mesh(mesh) => (Some(&mut mesh.file), &mut mesh.motion),
            Self::Revolution(surface) => (None, &mut surface.motion),
            Self::Terrain(terrain) => (terrain.heights.file_mut(), &mut terrain.motion),
        };
        let table = motion.as_mut().and_then(WallMotion::file_mut);
        mesh.into_iter().chain(table)
    }
}

impl FluidBody {
    /// Velocity at the start \[m/s] at a point \[m].
    pub fn velocity_at(&self, point: DVec3) -> DVec3 {
        self.velocities()(point)
    }

    /// The same as a function. A file that cannot be read counts for nothing: the scene's check names it.
    pub(crate) fn velocities(&self) -> impl Fn(DVec3) -> DVec3 + use<'_> {
        let center = self.frame().place(self.shape.center());
        let field = self.velocity_field.as_ref();
        let field = field.and_then(|field| field.read().ok());
        move |point| {
            let arm = point - center;
            let rows = self.velocity_gradient.map(|row| row.as_dvec3().dot(arm));
            let field = field.as_ref().map_or(DVec3::ZERO, |field| field.at(point));
            self.velocity.as_dvec3() + DVec3::from_array(rows) + field
        }
    }

    /// A bound on the speeds at the start \[m/s]: exact for a body without a gradient or a field.
    pub fn greatest_speed(&self) -> f32 {
        let squares = self.velocity_gradient.map(Vec3::length_squared);
        let gradient = squares.iter().sum::<f32>().sqrt();
        let (center, reach) = (self.shape.center(), self.shape.reach());
        let center = self.frame().place(center);
        let own = self.shape.greatest_speed();
        let field = self.velocity_field.as_ref();
        let field = field.map_or(0.0, |field| field.greatest_speed(center, reach));
        self.velocity.length() + gradient * reach + field + own
    }
}

impl Shape {
    /// The middle of the shape before it is turned \[m].
    pub fn center(&self) -> DVec3 {
        match *self {
            Self::Box { min, max } => 0.5 * (min.as_dvec3() + max.as_dvec3()),
            Self::Sphere { center, .. } => center.as_dvec3(),
            Self::Cylinder { start, end, .. } => 0.5 * (start.as_dvec3() + end.as_dvec3()),
            Self::Mesh(ref file) | Self::Particles(ref file) => {
                let extent = self.extent_of_file();
                extent.map_or(file.translation, |(low, high)| 0.5 * (low + high))
            }
        }
    }

    /// Distance from the centre to the farthest point \[m], or a little more.
    pub fn reach(&self) -> f32 {
        match *self {
            Self::Box { min, max } => 0.5 * (max - min).length(),
            Self::Sphere { radius, .. } => radius,
            Self::Cylinder { start, end, radius } => (0.5 * (end - start).length()).hypot(radius),
            Self::Mesh(_) | Self::Particles(_) => {
                let extent = self.extent_of_file();
                extent.map_or(0.0, |(low, high)| 0.5 * (high - low).length() as f32)
            }
        }
    }

    /// The point that the shape is turned about \[m]: its centre, or where the origin of its file is put.
    pub(crate) fn pivot(&self) -> DVec3 {
        match self {
            Self::Mesh(file) | Self::Particles(file) => file.translation,
            _ => self.center(),
        }
    }

    /// Path of the file that it names.
    pub(crate) fn file_mut(&mut self) -> Option<&mut String> {
        match self {
            Self::Mesh(file) | Self::Particles(file) => Some(&mut file.file),
            _ => None,
        }
    }
}

impl TryFrom<u8> for Dimension {
    type Error = String;

    fn try_from(value: u8) -> Result<Self, Self::Error> {
        match value {
            2 => Ok(Self::Two),
            3 => Ok(Self::Three),
            other => Err(format!("dimension is {other}; it must be 2 or 3")),
        }
    }
}

impl From<Dimension> for u8 {
    fn from(value: Dimension) -> Self {
        match value {
            Dimension::Two => 2,
            Dimension::Three => 3,
        }
    }
}
