//! Where bodies and boundaries are: their frames, and what their files hold.

use glam::DVec3;

use super::{BoundaryShape, FluidBody, Frame, Shape};
use crate::mesh::{Mesh, MeshError};

impl FluidBody {
    /// Where the body is: its shape, turned.
    pub(crate) fn frame(&self) -> Frame {
        Frame::new(self.shape.pivot(), self.rotation)
    }
}

impl BoundaryShape {
    /// Angles by which it is turned about the x, y and z axes \[°].
    pub(crate) fn rotation(&self) -> DVec3 {
        match self {
            Self::Tank { rotation, .. }
            | Self::Box { rotation, .. }
            | Self::Sphere { rotation, .. }
            | Self::Plane { rotation, .. } => *rotation,
            Self::Mesh(mesh) => mesh.rotation,
            Self::Revolution(surface) => surface.rotation,
            Self::Terrain(terrain) => terrain.rotation,
        }
    }

    /// Where the boundary is: what is written of it, turned.
    pub(crate) fn frame(&self) -> Frame {
        match *self {
            Self::Tank {
                min, max, rotation, ..
            }
            | Self::Box {
                min, max, rotation, ..
            } => Frame::new(0.5 * (min.as_dvec3() + max.as_dvec3()), rotation),
            Self::Sphere {
                center, rotation, ..
            }
            | Self::Plane {
                center, rotation, ..
            } => Frame::new(center.as_dvec3(), rotation),
            // These are placed as a whole.
            Self::Mesh(_) | Self::Revolution(_) | Self::Terrain(_) => {
                Frame::new(DVec3::ZERO, DVec3::ZERO)
            }
        }
    }
}

impl Shape {
    /// The box around what its file holds, before it is turned \[m]; none for other shapes, or if the file cannot be
    /// read: the scene's check names it.
    pub(crate) fn extent_of_file(&self) -> Option<(DVec3, DVec3)> {
        let around = |points: &[DVec3]| {
            let empty = (DVec3::INFINITY, DVec3::NEG_INFINITY);
            let grow = |(low, high): (DVec3, DVec3), x: &DVec3| (low.min(*x), high.max(*x));
            (!points.is_empty()).then(|| points.iter().fold(empty, grow))
        };
        match self {
            Self::Mesh(file) => around(&file.vertices().ok()?),
            Self::Particles(file) => around(&file.particles().ok()?.positions),
            _ => None,
        }
    }

    /// Largest speed of the particles of its file \[m/s].
    pub(super) fn greatest_speed(&self) -> f32 {
        let Self::Particles(file) = self else {
            return 0.0;
        };
        let particles = file.particles().ok();
        let velocities = particles.and_then(|particles| particles.velocities);
        let speeds = velocities.iter().flatten().map(|v| v.length());
        speeds.fold(0.0, f64::max) as f32
    }
}

impl BoundaryShape {
    /// The surface of triangles that it is, for particles at a spacing \[m]; none for other shapes.
    pub(crate) fn mesh(&self, spacing: f32) -> Option<Result<Mesh, MeshError>> {
        match self {
            Self::Mesh(mesh) => Some(Mesh::load(mesh, spacing)),
            Self::Revolution(surface) => Some(surface.mesh(spacing)),
            Self::Terrain(terrain) => Some(terrain.mesh(spacing)),
            _ => None,
        }
    }
}
