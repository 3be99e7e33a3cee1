//! How near a point is to a solid.

use glam::DVec3;

use crate::mesh::Mesh;
use crate::sampling::layer_depth;
use crate::scene::shapes::wall_axes;
use crate::scene::{BoundaryShape, Dimension, Frame, MeshSide, Scene};

/// An obstacle, to be asked for distances. A tank is none: it is asked as the box it is.
pub(crate) struct Obstacle<'a> {
    /// What a message calls it.
    pub(crate) name: &'static str,
    kind: Kind<'a>,
    frame: Frame,
    flat: bool,
    /// What it counts as at least, if it is thinner: its samples would lie too near to its faces \[m].
    thickness: Option<f64>,
}

enum Kind<'a> {
    Mesh {
        mesh: &'a Mesh,
        /// Of a sheet's face before the sheet itself \[m].
        face: f64,
        /// Further away it does not matter how far \[m].
        reach: f64,
    },
    Box {
        min: DVec3,
        max: DVec3,
    },
    Sphere {
        center: DVec3,
        radius: f64,
    },
    Plane {
        center: DVec3,
        normal: DVec3,
        axes: (DVec3, DVec3),
        half_size: f64,
    },
}

impl<'a> Obstacle<'a> {
    /// `mesh` is what the boundary's file holds, if it is a mesh.
    pub(crate) fn new(
        boundary: &BoundaryShape,
        mesh: Option<&'a Mesh>,
        scene: &Scene,
    ) -> Option<Self> {
        let dimension = scene.dimension;
        let depth = f64::from(layer_depth(scene));
        let mut thickness = None;
        let (name, kind) = match *boundary {
            BoundaryShape::Tank { .. } => return None,
            BoundaryShape::Mesh(_) | BoundaryShape::Revolution(_) | BoundaryShape::Terrain(_) => {
                let mesh = mesh?;
                let face = match mesh.side {
                    MeshSide::Both => depth,
                    MeshSide::Outside | MeshSide::Inside | MeshSide::Front => 0.0,
                };
                let reach = f64::from(scene.spacing) + face;
                let name = match boundary {
                    BoundaryShape::Revolution(_) => "surface of revolution",
                    BoundaryShape::Terrain(_) => "ground",
                    _ => "mesh",
                };
                (name, Kind::Mesh { mesh, face, reach })
            }
            BoundaryShape::Box { min, max, .. } => {
                let (min, max) = (min.as_dvec3(), max.as_dvec3());
                let thinnest = (max - min).to_array()[..usize::from(u8::from(dimension))]
                    .iter()
                    .fold(f64::INFINITY, |a, b| a.min(*b));
                thickness = (thinnest < 2.0 * depth).then_some(2.0 * depth);
                let middle = 0.5 * (min + max);
                let (min, max) = (min.min(middle - depth), max.max(middle + depth));
                ("solid box", Kind::Box { min, max })
            }
            BoundaryShape::Sphere { center, radius, .. } => {
                let radius = f64::from(radius);
                // Its samples are at half the radius at least.
                let counted = radius.max(0.5 * radius + depth);
                thickness = (counted > radius).then_some(2.0 * counted);
                let center = center.as_dvec3();
                (
                    "solid sphere",
                    Kind::Sphere {
                        center,
                        radius: counted,
                    },
                )
            }
            BoundaryShape::Plane {
                center,
                normal,
                half_size,
                ..
            } => {
                let (first, second) = wall_axes(normal, dimension);
                (
                    "plane",
                    Kind::Plane {
                        center: center.as_dvec3(),
                        normal: normal.as_dvec3().normalize(),
                        axes: (first.as_dvec3(), second.as_dvec3()),
                        half_size: f64::from(half_size),
                    },
                )
            }
        };
        Some(Self {
            name,
            kind,
            frame: boundary.frame(),
            flat: dimension == Dimension::Two,
            thickness,
        })
    }

    pub(crate) fn is_mesh(&self) -> bool {
        matches!(self.kind, Kind::Mesh { .. })
    }

    /// The box without which it is further away than a spacing \[m]; none if there is no such box.
    pub(crate) fn bounds(&self) -> Option<(DVec3, DVec3)> {
        let (mut low, mut high) = match self.kind {
            Kind::Mesh { mesh, reach, .. }
                if mesh.side != MeshSide::Inside && mesh.heights.is_none() =>
            {
                let (min, max) = mesh.bounds();
                (min - reach, max + reach)
            }
            // All that is outside of the one, and behind or below the others, is in the solid.
            Kind::Mesh { .. } | Kind::Plane { .. } => return None,
            Kind::Box { min, max } => self.frame.bounds(min, max),
            Kind::Sphere { center, radius } => (center - radius, center + radius),
        };
        if self.flat {
            (low.z, high.z) = (0.0, 0.0);
        }
        Some((low, high))
    }

    /// For a message: what a thin solid counts as.
    pub(crate) fn counts_as(&self, spacing: f64) -> String {
        self.thickness.map_or_else(String::new, |thickness| {
            format!(
                " (it is so thin that it counts as {:.2} spacings, {thickness:.4} m, thick)",
                thickness / spacing
            )
        })
    }

    /// Distance of a point to the solid \[m], negative inside; infinite where the plane's rectangle does not reach. Far
    /// from a mesh a lower bound of it.
    pub(crate) fn distance(&self, point: DVec3) -> f64 {
        let point = if self.frame.is_turned() {
            self.frame.local(point)
        } else {
            point
        };
        match self.kind {
            Kind::Mesh { mesh, face, reach } => {
                let over = mesh
                    .heights
                    .as_ref()
                    .and_then(|heights| heights.bound(point));
                if let Some(bound) = over.filter(|bound| bound.abs() > reach) {
                    return bound;
                }
                let (min, max) = mesh.bounds();
                let away = point.distance(point.clamp(min, max));
                if away > reach && mesh.side != MeshSide::Inside {
                    return away;
                }
                let nearest = mesh.nearest(point);
                let both = mesh.side == MeshSide::Both || (nearest.on_border && over.is_none());
                let distance = if both {
                    nearest.distance.abs()
                } else {
                    nearest.distance
                };
                distance - face
            }
            Kind::Box { min, max } => {
                let mut outside = (min - point).max(point - max);
                if self.flat {
                    outside.z = f64::NEG_INFINITY;
                }
                outside.max(DVec3::ZERO).length() + outside.max_element().min(0.0)
            }
            Kind::Sphere { center, radius } => (point - center).length() - radius,
            Kind::Plane {
                center,
                normal,
                axes,
                half_size,
            } => {
                let from = point - center;
                let beside = from.dot(axes.0).abs().max(from.dot(axes.1).abs());
                if beside <= half_size {
                    from.dot(normal)
                } else {
                    f64::INFINITY
                }
            }
        }
    }
}
