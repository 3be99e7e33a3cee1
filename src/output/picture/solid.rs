//! Obstacles: where a ray meets them, and how they are turned there.

use glam::{Vec3, vec3};

use super::projection::{NEAREST, Ray};
use crate::scene::Bounds;

/// A solid thing in the picture.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Solid {
    /// An axis-aligned box.
    Box(Bounds),
    /// A ball.
    Sphere {
        /// Centre [m].
        center: Vec3,
        /// Radius [m].
        radius: f32,
    },
    /// A rectangular wall; invisible from behind, so that a wall between the eye and the fluid does not hide it.
    Wall {
        /// Centre [m].
        center: Vec3,
        /// Direction from the solid into the fluid.
        normal: Vec3,
        /// From the centre to the middle of two neighbouring edges [m].
        half_edges: [Vec3; 2],
    },
}

impl Solid {
    /// Depth at which a ray enters [m]; infinity if it misses, or starts inside.
    pub(super) fn hit(&self, ray: &Ray) -> f32 {
        let depth = match *self {
            Self::Box(bounds) => hit_box(&bounds, ray),
            Self::Sphere { center, radius } => hit_sphere(center, radius, ray),
            Self::Wall {
                center,
                normal,
                half_edges,
            } => hit_wall(center, normal, half_edges, ray),
        };
        if depth > NEAREST {
            depth
        } else {
            f32::INFINITY
        }
    }

    /// Corners of a box around it.
    pub(super) fn corners(&self) -> [Vec3; 8] {
        let bounds = match *self {
            Self::Box(bounds) => bounds,
            Self::Sphere { center, radius } => around(center, Vec3::splat(radius)),
            Self::Wall {
                center,
                half_edges: [u, v],
                ..
            } => around(center, u.abs() + v.abs()),
        };
        corners(&bounds)
    }

    /// Unit normal at a point of the surface, outwards.
    pub(super) fn normal(&self, at: Vec3) -> Vec3 {
        match *self {
            Self::Box(bounds) => {
                let half = 0.5 * (bounds.max - bounds.min);
                let from_centre = (at - bounds.min - half) / half.max(Vec3::splat(1e-9));
                let face = match from_centre.abs().max_position() {
                    0 => Vec3::X,
                    1 => Vec3::Y,
                    _ => Vec3::Z,
                };
                face * from_centre.dot(face).signum()
            }
            Self::Sphere { center, .. } => (at - center).normalize_or(Vec3::Y),
            Self::Wall { normal, .. } => normal.normalize_or(Vec3::Y),
        }
    }
}

/// The corners of a box: bit 0 of the index chooses x, bit 1 y, bit 2 z.
pub(super) fn corners(bounds: &Bounds) -> [Vec3; 8] {
    std::array::from_fn(|i| {
        let pick = |axis: usize| {
            let end = if i >> axis & 1 == 0 {
                bounds.min
            } else {
                bounds.max
            };
            end[axis]
        };
        vec3(pick(0), pick(1), pick(2))
    })
}

pub(super) fn around(center: Vec3, reach: Vec3) -> Bounds {
    Bounds {
        min: center - reach,
        max: center + reach,
    }
}

fn hit_box(bounds: &Bounds, ray: &Ray) -> f32 {
    // Directions of zero give infinities, which compare as they should.
    let to_min = (bounds.min - ray.origin) / ray.direction;
    let to_max = (bounds.max - ray.origin) / ray.direction;
    let enter = to_min.min(to_max).max_element();
    let leave = to_min.max(to_max).min_element();
    if enter <= leave { enter } else { f32::INFINITY }
}

fn hit_sphere(center: Vec3, radius: f32, ray: &Ray) -> f32 {
    let to_origin = ray.origin - center;
    let a = ray.direction.length_squared();
    let b = to_origin.dot(ray.direction);
    let c = to_origin.length_squared() - radius * radius;
    let root = b * b - a * c;
    if root < 0.0 {
        return f32::INFINITY;
    }
    (-b - root.sqrt()) / a
}

fn hit_wall(center: Vec3, normal: Vec3, half_edges: [Vec3; 2], ray: &Ray) -> f32 {
    let normal = normal.normalize_or(Vec3::Y);
    let towards = ray.direction.dot(normal);
    if towards >= 0.0 {
        return f32::INFINITY;
    }
    let depth = (center - ray.origin).dot(normal) / towards;
    let from_centre = ray.at(depth) - center;
    let mut edges = half_edges.into_iter();
    let inside = edges.all(|edge| from_centre.dot(edge).abs() <= edge.length_squared());
    if inside { depth } else { f32::INFINITY }
}
