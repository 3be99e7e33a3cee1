//! What a boundary's shape and its motion say together.

use std::path::Path;

use glam::Vec3;

use super::{BoundaryShape, MotionTable, WallMotion, WallSlip};

impl BoundaryShape {
    /// Its motion; none for walls that stand.
    pub fn motion(&self) -> Option<&WallMotion> {
        match self {
            Self::Tank { motion, .. }
            | Self::Box { motion, .. }
            | Self::Sphere { motion, .. }
            | Self::Plane { motion, .. } => motion.as_ref(),
            Self::Mesh(mesh) => mesh.motion.as_ref(),
            Self::Revolution(surface) => surface.motion.as_ref(),
            Self::Terrain(terrain) => terrain.motion.as_ref(),
        }
    }

    /// How it holds the fluid along its face.
    pub fn slip(&self) -> WallSlip {
        match self {
            Self::Tank { slip, .. }
            | Self::Box { slip, .. }
            | Self::Sphere { slip, .. }
            | Self::Plane { slip, .. } => *slip,
            Self::Mesh(mesh) => mesh.slip,
            Self::Revolution(surface) => surface.slip,
            Self::Terrain(terrain) => terrain.slip,
        }
    }

    /// Largest distance of its points from the line through `point` along `axis` \[m]; a mesh's is not known without
    /// its file.
    fn farthest_from(&self, point: Vec3, axis: Vec3, in_plane: bool) -> Option<f32> {
        let axis = axis.normalize_or_zero();
        let frame = self.frame();
        let distance = |place: Vec3| {
            let place = frame.place(place.as_dvec3()).as_vec3();
            (place - point).cross(axis).length()
        };
        match *self {
            Self::Tank { min, max, .. } | Self::Box { min, max, .. } => {
                Some(farthest_corner(min, max, in_plane, distance))
            }
            Self::Sphere { center, radius, .. } => Some(distance(center) + radius),
            Self::Plane {
                center, half_size, ..
            } => Some(distance(center) + half_size * std::f32::consts::SQRT_2),
            Self::Mesh(_) | Self::Revolution(_) | Self::Terrain(_) => None,
        }
    }

    /// Largest speed of a point of it in the whole motion \[m/s]. None for a mesh that turns, unless its corners are
    /// given. A table that cannot be read counts as standing: the scene's check names it.
    pub(crate) fn greatest_speed(&self, in_plane: bool, mesh: Option<[Vec3; 2]>) -> Option<f32> {
        match *self.motion()? {
            WallMotion::Velocity { velocity, .. } => Some(long(velocity)),
            WallMotion::Rotation {
                center,
                angular_velocity,
                ..
            } => {
                // In double precision: the square of the length may be beyond single.
                let axis = angular_velocity.as_dvec3().normalize_or_zero().as_vec3();
                let of_mesh = |[min, max]: [Vec3; 2]| {
                    farthest_corner(min, max, false, |x| (x - center).cross(axis).length())
                };
                let farthest = self.farthest_from(center, axis, in_plane);
                Some(long(angular_velocity) * farthest.or(mesh.map(of_mesh))?)
            }
            WallMotion::Oscillation {
                amplitude,
                frequency,
                ..
            } => Some(long(amplitude) * std::f32::consts::TAU * frequency.abs()),
            WallMotion::Table { ref file, .. } => {
                let table = MotionTable::load(Path::new(file)).ok()?;
                Some(table.greatest_speed() as f32)
            }
        }
    }

    /// Largest acceleration of its back and forth \[m/s²]. A table that cannot be read counts as standing.
    pub(crate) fn greatest_acceleration(&self) -> Option<f32> {
        match *self.motion()? {
            WallMotion::Oscillation {
                amplitude,
                frequency,
                ..
            } => Some(long(amplitude) * (std::f32::consts::TAU * frequency).powi(2)),
            WallMotion::Table { ref file, .. } => {
                let table = MotionTable::load(Path::new(file)).ok()?;
                Some(table.greatest_acceleration() as f32)
            }
            WallMotion::Velocity { .. } | WallMotion::Rotation { .. } => None,
        }
    }

    /// Period of its back and forth \[s], at a `spacing` \[m]; the shortest of a table. A table that cannot be read
    /// counts as standing.
    pub(crate) fn shortest_period(&self, spacing: f32) -> Option<f32> {
        match *self.motion()? {
            WallMotion::Oscillation { frequency, .. } => Some(1.0 / frequency.abs()),
            WallMotion::Table { ref file, .. } => {
                let table = MotionTable::load(Path::new(file)).ok()?;
                let least = f64::from(LEAST_WAY * spacing);
                table.shortest_period(least).map(|period| period as f32)
            }
            WallMotion::Velocity { .. } | WallMotion::Rotation { .. } => None,
        }
    }
}

/// Length of a vector whose square may be beyond single precision.
fn long(vector: Vec3) -> f32 {
    vector.as_dvec3().length() as f32
}

/// Way that counts as a movement \[spacings].
pub(crate) const LEAST_WAY: f32 = 1e-3;

/// The largest distance of a box's corners; in 2-D of those in the plane.
fn farthest_corner(min: Vec3, max: Vec3, in_plane: bool, distance: impl Fn(Vec3) -> f32) -> f32 {
    let end = |last: bool, axis: usize| [min[axis], max[axis]][usize::from(last)];
    let corner = |k: u8| {
        let z = if in_plane { 0.0 } else { end(k & 4 > 0, 2) };
        Vec3::new(end(k & 1 > 0, 0), end(k & 2 > 0, 1), z)
    };
    (0..8).map(|k| distance(corner(k))).fold(0.0, f32::max)
}
