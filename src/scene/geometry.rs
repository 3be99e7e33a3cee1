//! Where things are: dimension, boxes, bodies of fluid, solid boundaries.

use glam::{DVec3, Vec3};
use serde::{Deserialize, Serialize};

use super::{VelocityField, WallMotion, WallSlip};

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
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
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
}

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

fn one() -> f64 {
    1.0
}

/// Where the solid is that a mesh bounds.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[non_exhaustive]
pub enum MeshSide {
    /// The mesh is closed and the solid in it: fluid is outside. The winding must be the same all over a shell; a shell
    /// within another bounds a cavity and is wound the other way. Shells that cross are refused.
    #[default]
    Outside,
    /// The mesh is closed and fluid is in it, as in a tank. Shells as above, with fluid in the place of the solid.
    Inside,
    /// Fluid is where triangles are seen counter-clockwise, the solid behind them. The mesh may be open, as a terrain
    /// is; past its border there is nothing.
    Front,
    /// A sheet with fluid on both sides, or thin walls that need not be closed. It acts as a wall as thick as twice the
    /// depth of the layer of samples, about 1.2 spacings.
    Both,
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
        let center = self.shape.center();
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
        let field = self.velocity_field.as_ref();
        let field = field.map_or(0.0, |field| field.greatest_speed(center, reach));
        self.velocity.length() + gradient * reach + field
    }
}

impl Shape {
    /// The point that the shape is symmetric about \[m].
    pub fn center(&self) -> DVec3 {
        match *self {
            Self::Box { min, max } => 0.5 * (min.as_dvec3() + max.as_dvec3()),
            Self::Sphere { center, .. } => center.as_dvec3(),
            Self::Cylinder { start, end, .. } => 0.5 * (start.as_dvec3() + end.as_dvec3()),
        }
    }

    /// Distance from the centre to the farthest point \[m].
    pub fn reach(&self) -> f32 {
        match *self {
            Self::Box { min, max } => 0.5 * (max - min).length(),
            Self::Sphere { radius, .. } => radius,
            Self::Cylinder { start, end, radius } => (0.5 * (end - start).length()).hypot(radius),
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
