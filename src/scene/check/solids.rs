//! Solid boundaries and the domain: proper shapes, and how near a point is to a solid.

use glam::{DVec3, Vec3};

use super::{Checked, box_is_proper, ensure, is_flat, radius_is_proper};
use crate::scene::shapes::wall_axes;
use crate::scene::{BoundaryShape, Dimension, Scene};

pub(super) fn shapes(scene: &Scene) -> Checked {
    let dimension = scene.dimension;
    for (index, boundary) in scene.boundaries.iter().enumerate() {
        let path = format!("boundaries.{index}");
        match *boundary {
            BoundaryShape::Tank { min, max, .. } | BoundaryShape::Box { min, max } => {
                box_is_proper(&path, min, max, dimension)?;
            }
            BoundaryShape::Sphere { center, radius } => {
                radius_is_proper(&path, radius)?;
                is_flat(format!("{path}.center"), center, dimension)?;
            }
            BoundaryShape::Plane {
                center,
                normal,
                half_size,
            } => {
                ensure(normal != Vec3::ZERO, format!("{path}.normal"), || {
                    "the normal is zero; it must point from the solid into the fluid".to_owned()
                })?;
                ensure(half_size > 0.0, format!("{path}.half_size"), || {
                    format!("the half size is {half_size} m; it must be above 0")
                })?;
                is_flat(format!("{path}.center"), center, dimension)?;
                is_flat(format!("{path}.normal"), normal, dimension)?;
            }
        }
    }
    match scene.domain {
        Some(domain) => box_is_proper("domain", domain.min, domain.max, dimension),
        None => Ok(()),
    }
}

/// An obstacle, to be asked for distances. A tank is none: it is asked as the box it is.
pub(super) struct Obstacle {
    /// What a message calls it.
    pub(super) name: &'static str,
    kind: Kind,
    flat: bool,
}

enum Kind {
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

impl Obstacle {
    pub(super) fn new(boundary: &BoundaryShape, dimension: Dimension) -> Option<Self> {
        let (name, kind) = match *boundary {
            BoundaryShape::Tank { .. } => return None,
            BoundaryShape::Box { min, max } => (
                "solid box",
                Kind::Box {
                    min: min.as_dvec3(),
                    max: max.as_dvec3(),
                },
            ),
            BoundaryShape::Sphere { center, radius } => (
                "solid sphere",
                Kind::Sphere {
                    center: center.as_dvec3(),
                    radius: f64::from(radius),
                },
            ),
            BoundaryShape::Plane {
                center,
                normal,
                half_size,
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
            flat: dimension == Dimension::Two,
        })
    }

    /// Distance of a point to the solid [m], negative inside; infinite where the plane's rectangle does not reach.
    pub(super) fn distance(&self, point: DVec3) -> f64 {
        match self.kind {
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
