//! Parts of a scene made in Rust: what a file must say, with the defaults of a file for the rest.

use glam::{DVec3, Vec3};

use super::{
    BoundaryShape, Bounds, Camera, FileShape, FluidBody, Gauge, GaugeKind, GaugeReference, Heights,
    MeshBoundary, MeshSide, Rate, RevolutionBoundary, Shape, TerrainBoundary, VelocityField,
    WallMotion, WallSlip,
};

impl Bounds {
    /// The box between two corners \[m].
    pub fn new(min: impl Into<Vec3>, max: impl Into<Vec3>) -> Self {
        let (min, max) = (min.into(), max.into());
        Self { min, max }
    }
}

impl Shape {
    /// A [`Box`](Self::Box) between two corners \[m].
    pub fn cuboid(min: impl Into<Vec3>, max: impl Into<Vec3>) -> Self {
        let (min, max) = (min.into(), max.into());
        Self::Box { min, max }
    }

    /// A [`Sphere`](Self::Sphere) \[m].
    pub fn sphere(center: impl Into<Vec3>, radius: f32) -> Self {
        let center = center.into();
        Self::Sphere { center, radius }
    }
}

impl FluidBody {
    /// Fluid at rest, on its lattice.
    pub fn new(shape: Shape) -> Self {
        Self {
            shape,
            rotation: DVec3::ZERO,
            velocity: Vec3::ZERO,
            velocity_gradient: [Vec3::ZERO; 3],
            velocity_field: None,
            jitter: None,
            cut: false,
        }
    }

    /// The same turned about the shape's centre by angles about the x, y and z axes, in this order \[°].
    #[must_use]
    pub fn turned(mut self, angles: impl Into<DVec3>) -> Self {
        self.rotation = angles.into();
        self
    }

    /// The same with a field of velocities at the start.
    #[must_use]
    pub fn with_field(mut self, field: VelocityField) -> Self {
        self.velocity_field = Some(field);
        self
    }
}

impl From<Shape> for FluidBody {
    fn from(shape: Shape) -> Self {
        Self::new(shape)
    }
}

impl BoundaryShape {
    /// A closed [`Tank`](Self::Tank) between two corners \[m].
    pub fn tank(min: impl Into<Vec3>, max: impl Into<Vec3>) -> Self {
        Self::Tank {
            min: min.into(),
            max: max.into(),
            open: false,
            rotation: DVec3::ZERO,
            name: None,
            motion: None,
            slip: WallSlip::Free,
        }
    }

    /// A [`Tank`](Self::Tank) without a lid.
    pub fn open_tank(min: impl Into<Vec3>, max: impl Into<Vec3>) -> Self {
        Self::Tank {
            min: min.into(),
            max: max.into(),
            open: true,
            rotation: DVec3::ZERO,
            name: None,
            motion: None,
            slip: WallSlip::Free,
        }
    }

    /// A solid [`Box`](Self::Box) between two corners \[m].
    pub fn cuboid(min: impl Into<Vec3>, max: impl Into<Vec3>) -> Self {
        Self::Box {
            min: min.into(),
            max: max.into(),
            rotation: DVec3::ZERO,
            name: None,
            motion: None,
            slip: WallSlip::Free,
        }
    }

    /// A solid [`Sphere`](Self::Sphere) \[m].
    pub fn sphere(center: impl Into<Vec3>, radius: f32) -> Self {
        Self::Sphere {
            center: center.into(),
            radius,
            rotation: DVec3::ZERO,
            name: None,
            motion: None,
            slip: WallSlip::Free,
        }
    }

    /// A square [`Plane`](Self::Plane) \[m].
    pub fn plane(center: impl Into<Vec3>, normal: impl Into<Vec3>, half_size: f32) -> Self {
        Self::Plane {
            center: center.into(),
            normal: normal.into(),
            half_size,
            rotation: DVec3::ZERO,
            name: None,
            motion: None,
            slip: WallSlip::Free,
        }
    }

    /// The same with a name, by which gauges find it.
    #[must_use]
    pub fn named(mut self, name: impl Into<String>) -> Self {
        let place = match &mut self {
            Self::Tank { name, .. }
            | Self::Box { name, .. }
            | Self::Sphere { name, .. }
            | Self::Plane { name, .. } => name,
            Self::Mesh(mesh) => &mut mesh.name,
            Self::Revolution(surface) => &mut surface.name,
            Self::Terrain(terrain) => &mut terrain.name,
        };
        *place = Some(name.into());
        self
    }

    /// The same turned about its centre by angles about the x, y and z axes, in this order \[°]; a mesh about its
    /// file's origin.
    #[must_use]
    pub fn turned(mut self, angles: impl Into<DVec3>) -> Self {
        let place = match &mut self {
            Self::Tank { rotation, .. }
            | Self::Box { rotation, .. }
            | Self::Sphere { rotation, .. }
            | Self::Plane { rotation, .. } => rotation,
            Self::Mesh(mesh) => &mut mesh.rotation,
            Self::Revolution(surface) => &mut surface.rotation,
            Self::Terrain(terrain) => &mut terrain.rotation,
        };
        *place = angles.into();
        self
    }

    /// The same with a hold on the fluid along its face.
    #[must_use]
    pub fn with_slip(mut self, wanted: WallSlip) -> Self {
        let place = match &mut self {
            Self::Tank { slip, .. }
            | Self::Box { slip, .. }
            | Self::Sphere { slip, .. }
            | Self::Plane { slip, .. } => slip,
            Self::Mesh(mesh) => &mut mesh.slip,
            Self::Revolution(surface) => &mut surface.slip,
            Self::Terrain(terrain) => &mut terrain.slip,
        };
        *place = wanted;
        self
    }

    /// The same in motion.
    #[must_use]
    pub fn moving(mut self, motion: WallMotion) -> Self {
        let place = match &mut self {
            Self::Tank { motion, .. }
            | Self::Box { motion, .. }
            | Self::Sphere { motion, .. }
            | Self::Plane { motion, .. } => motion,
            Self::Mesh(mesh) => &mut mesh.motion,
            Self::Revolution(surface) => &mut surface.motion,
            Self::Terrain(terrain) => &mut terrain.motion,
        };
        *place = Some(motion);
        self
    }
}

impl FileShape {
    /// A file as it is: in metres, its origin at that of the scene.
    pub fn new(file: impl Into<String>) -> Self {
        Self {
            file: file.into(),
            scale: 1.0,
            translation: DVec3::ZERO,
        }
    }
}

impl RevolutionBoundary {
    /// A solid surface of revolution about the y axis, from a profile of (radius, height) \[m].
    pub fn new(profile: Vec<[f32; 2]>) -> Self {
        Self {
            profile,
            center: DVec3::ZERO,
            rotation: DVec3::ZERO,
            side: MeshSide::default(),
            name: None,
            motion: None,
            slip: WallSlip::Free,
        }
    }
}

impl TerrainBoundary {
    /// Ground that is `size` \[m] wide along x and z, about the origin.
    pub fn new(heights: Heights, size: [f32; 2]) -> Self {
        Self {
            heights,
            size,
            translation: DVec3::ZERO,
            rotation: DVec3::ZERO,
            name: None,
            motion: None,
            slip: WallSlip::Free,
        }
    }
}

impl MeshBoundary {
    /// A mesh as its file has it, solid.
    pub fn new(file: impl Into<String>) -> Self {
        Self {
            file: file.into(),
            scale: 1.0,
            rotation: DVec3::ZERO,
            translation: DVec3::ZERO,
            side: MeshSide::default(),
            name: None,
            motion: None,
            slip: WallSlip::Free,
        }
    }
}

impl Gauge {
    /// A gauge that is read after every step.
    pub fn new(name: impl Into<String>, kind: GaugeKind) -> Self {
        Self {
            name: name.into(),
            kind,
            every: Rate::default(),
            window: 0.0,
            reference: None,
        }
    }
}

impl GaugeReference {
    /// A table whose first two columns are times and values in SI units.
    pub fn new(file: impl Into<String>) -> Self {
        Self {
            file: file.into(),
            time: None,
            value: None,
            quantity: None,
            scale: glam::Vec2::ONE,
            offset: glam::Vec2::ZERO,
        }
    }
}

impl Camera {
    /// A camera at `position` that looks at `target` \[m].
    pub fn new(position: impl Into<Vec3>, target: impl Into<Vec3>) -> Self {
        Self {
            position: position.into(),
            target: target.into(),
            field_of_view: super::output::default_field_of_view(),
        }
    }
}
