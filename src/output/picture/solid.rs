//! Obstacles: their intersection with a ray, and their normal there.

use std::sync::Arc;

use glam::{Vec3, vec3};

use super::projection::{NEAREST, Ray};
use crate::mesh::Mesh;
use crate::scene::{Bounds, Frame, MeshSide};

/// How a solid is turned.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Turned(pub(super) Frame);

/// A solid object in the picture.
#[derive(Debug, Clone, PartialEq)]
pub enum Solid {
    /// An axis-aligned box.
    Box(Bounds),
    /// A box that is turned about its centre.
    TurnedBox(Bounds, Turned),
    /// A ball.
    Sphere {
        /// Centre \[m].
        center: Vec3,
        /// Radius \[m].
        radius: f32,
    },
    /// A rectangular wall; invisible from behind, so that a wall between the eye and the fluid does not hide it.
    Wall {
        /// Centre \[m].
        center: Vec3,
        /// Direction from the solid into the fluid.
        normal: Vec3,
        /// Vectors from the centre to the midpoints of two adjacent edges \[m].
        half_edges: [Vec3; 2],
    },
    /// A triangle mesh. Thin parts, such as the walls of a glass, and back faces are transparent. Of several thin walls
    /// only the farthest is drawn, so that fluid between them is visible.
    Mesh {
        /// The surface.
        mesh: Arc<Mesh>,
        /// Largest thickness of a thin part along the line of sight \[m].
        thin: f32,
    },
}

impl Solid {
    /// Depth at which a ray enters the solid \[m]; infinity if it misses or starts inside.
    pub(super) fn hit(&self, ray: &Ray) -> f32 {
        let depth = match *self {
            Self::Box(bounds) => hit_box(&bounds, ray),
            Self::TurnedBox(bounds, Turned(frame)) => hit_box(&bounds, &frame_ray(&frame, ray)),
            Self::Sphere { center, radius } => hit_sphere(center, radius, ray),
            Self::Wall {
                center,
                normal,
                half_edges,
            } => hit_wall(center, normal, half_edges, ray),
            Self::Mesh { ref mesh, thin } => hit_mesh(mesh, thin, ray),
        };
        if depth > NEAREST {
            depth
        } else {
            f32::INFINITY
        }
    }

    /// Corners of a box around the solid.
    pub(super) fn corners(&self) -> [Vec3; 8] {
        let bounds = match *self {
            Self::Box(bounds) => bounds,
            Self::TurnedBox(Bounds { min, max }, Turned(frame)) => {
                let corners = frame.corners(min.as_dvec3(), max.as_dvec3());
                return corners.map(|corner| corner.as_vec3());
            }
            Self::Mesh { ref mesh, .. } => {
                let (min, max) = mesh.bounds();
                Bounds {
                    min: min.as_vec3(),
                    max: max.as_vec3(),
                }
            }
            Self::Sphere { center, radius } => around(center, Vec3::splat(radius)),
            Self::Wall {
                center,
                half_edges: [u, v],
                ..
            } => around(center, u.abs() + v.abs()),
        };
        corners(&bounds)
    }

    /// Unit normal at a point of the surface, outwards; for a mesh, towards the origin of the ray.
    pub(super) fn normal(&self, at: Vec3, direction: Vec3) -> Vec3 {
        match *self {
            Self::Box(bounds) => normal_of_box(&bounds, at),
            Self::TurnedBox(bounds, Turned(frame)) => {
                let normal = normal_of_box(&bounds, frame.local(at.as_dvec3()).as_vec3());
                frame.direction(normal.as_dvec3()).as_vec3()
            }
            Self::Sphere { center, .. } => (at - center).normalize_or(Vec3::Y),
            Self::Wall { normal, .. } => normal.normalize_or(Vec3::Y),
            Self::Mesh { ref mesh, .. } => {
                let normal = mesh.normals[mesh.nearest(at.as_dvec3()).triangle].as_vec3();
                if normal.dot(direction) > 0.0 {
                    -normal
                } else {
                    normal
                }
            }
        }
    }
}

/// The corners of a box: bit 0 of the index selects x, bit 1 y, bit 2 z.
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

fn normal_of_box(bounds: &Bounds, at: Vec3) -> Vec3 {
    let half = 0.5 * (bounds.max - bounds.min);
    let from_centre = (at - bounds.min - half) / half.max(Vec3::splat(1e-9));
    let face = match from_centre.abs().max_position() {
        0 => Vec3::X,
        1 => Vec3::Y,
        _ => Vec3::Z,
    };
    face * from_centre.dot(face).signum()
}

/// A ray as the shape before it was turned meets it.
fn frame_ray(frame: &Frame, ray: &Ray) -> Ray {
    let end = frame.local((ray.origin + ray.direction).as_dvec3());
    let origin = frame.local(ray.origin.as_dvec3());
    Ray {
        origin: origin.as_vec3(),
        direction: (end - origin).as_vec3(),
    }
}

fn hit_box(bounds: &Bounds, ray: &Ray) -> f32 {
    // Zero components of the direction give infinities, which compare correctly.
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

fn hit_mesh(mesh: &Mesh, thin: f32, ray: &Ray) -> f32 {
    let direction = ray.direction.as_dvec3();
    let mut hits = Vec::new();
    mesh.hits(ray.origin.as_dvec3(), direction, &mut hits);
    hits.retain(|&(depth, _)| depth > f64::from(NEAREST));
    let is_front = |triangle: usize| mesh.normals[triangle].dot(direction) < 0.0;
    let mut fronts = hits.iter().filter(|&&(_, triangle)| is_front(triangle));
    let found = match mesh.side {
        MeshSide::Both => hits.last(),
        MeshSide::Inside | MeshSide::Front => fronts.next(),
        MeshSide::Outside => {
            let mut last = None;
            for (k, hit) in hits.iter().enumerate() {
                if is_front(hit.1) {
                    last = Some(hit);
                    let exit = hits[k..].iter().find(|&&(_, triangle)| !is_front(triangle));
                    if exit.is_none_or(|exit| exit.0 - hit.0 > f64::from(thin)) {
                        break;
                    }
                }
            }
            last
        }
    };
    found.map_or(f32::INFINITY, |&(depth, _)| depth as f32)
}
