//! Solids of a scene and the depth of points inside them: written for tests only, without code of the engine.

use glam::{DMat3, DVec3};

use crate::mesh_support::Surface;

/// The solid side of a mesh, as in a scene.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Side {
    Outside,
    Inside,
    Front,
    Both,
}

/// A solid in the scene \[m].
#[derive(Debug, Clone)]
pub(crate) enum Solid {
    Tank {
        min: DVec3,
        max: DVec3,
        open: bool,
    },
    Block {
        min: DVec3,
        max: DVec3,
    },
    Ball {
        center: DVec3,
        radius: f64,
    },
    Plane {
        center: DVec3,
        normal: DVec3,
        half_size: f64,
    },
    Mesh {
        triangles: Vec<[DVec3; 3]>,
        /// Edges that belong to one triangle only.
        borders: Vec<[DVec3; 2]>,
        side: Side,
    },
}

impl Solid {
    /// A surface rotated about x, y and z by angles \[°], and translated.
    pub(crate) fn mesh(surface: &Surface, side: Side, angles: DVec3, at: DVec3) -> Self {
        let [x, y, z] = angles.to_array().map(f64::to_radians);
        let turn =
            DMat3::from_rotation_z(z) * DMat3::from_rotation_y(y) * DMat3::from_rotation_x(x);
        let triangles: Vec<[DVec3; 3]> = surface
            .triangles()
            .into_iter()
            .map(|corners| corners.map(|corner| turn * corner.as_dvec3() + at))
            .collect();
        let edges = |[a, b, c]: &[DVec3; 3]| [[*a, *b], [*b, *c], [*c, *a]];
        let all: Vec<[DVec3; 2]> = triangles.iter().flat_map(edges).collect();
        let borders = all
            .iter()
            .filter(|[a, b]| !all.iter().any(|other| other == &[*b, *a]))
            .copied()
            .collect();
        Self::Mesh {
            triangles,
            borders,
            side,
        }
    }

    /// Whether it has an inside, where no particle may be.
    fn is_closed(&self) -> bool {
        !matches!(
            self,
            Self::Plane { .. }
                | Self::Mesh {
                    side: Side::Front | Side::Both,
                    ..
                }
        )
    }

    /// Depth of a point inside the solid \[m], negative outside; for open surfaces, the distance behind them, and
    /// `None` if the nearest point is within `margin` \[m] of a border.
    fn depth(&self, x: DVec3, flat: bool, margin: f64) -> Option<f64> {
        let in_plane = |v: DVec3| if flat { v.with_z(f64::NEG_INFINITY) } else { v };
        match self {
            Self::Tank { min, max, open } => {
                let mut over = in_plane(max - x);
                if *open {
                    over.y = f64::INFINITY;
                }
                let over = if flat {
                    over.with_z(f64::INFINITY)
                } else {
                    over
                };
                let under = if flat {
                    (x - min).with_z(f64::INFINITY)
                } else {
                    x - min
                };
                // Beyond the rim of an open tank there is no solid.
                let beside = *open && x.y > max.y;
                let depth = -over.min(under).min_element();
                (!beside).then_some(depth)
            }
            Self::Block { min, max } => {
                let outside = in_plane((min - x).max(x - max));
                Some(-outside.max_element())
            }
            Self::Ball { center, radius } => Some(radius - x.distance(*center)),
            Self::Plane {
                center,
                normal,
                half_size,
            } => {
                let from = x - center;
                let height = from.dot(*normal);
                let beside = (from - height * normal).length();
                (beside < half_size - margin).then_some(-height)
            }
            Self::Mesh {
                triangles,
                borders,
                side,
            } => {
                let nearest = triangles
                    .iter()
                    .map(|corners| closest(corners, x))
                    .min_by(|a, b| a.distance(x).total_cmp(&b.distance(x)))?;
                let distance = nearest.distance(x);
                match side {
                    Side::Outside | Side::Inside => {
                        let inside = winding(triangles, x) > 0.5;
                        let in_solid = inside == (*side == Side::Outside);
                        Some(if in_solid { distance } else { -distance })
                    }
                    Side::Front | Side::Both => {
                        let on_border = |[a, b]: &[DVec3; 2]| {
                            let part = (nearest - a).dot(b - a) / (b - a).length_squared();
                            a.lerp(*b, part.clamp(0.0, 1.0)).distance(nearest) < margin
                        };
                        if borders.iter().any(on_border) {
                            return None;
                        }
                        // At edges, the face that the point sees most frontally decides.
                        let normal = triangles
                            .iter()
                            .filter(|corners| {
                                closest(corners, x).distance(nearest) < 1e-9 + 1e-6 * distance
                            })
                            .map(|[a, b, c]| (b - a).cross(c - a).normalize())
                            .fold(DVec3::ZERO, |sum, normal| sum + normal);
                        Some(-(x - nearest).dot(normal).signum() * distance)
                    }
                }
            }
        }
    }

    /// The reason why a particle that moved between two positions in a step is in a forbidden place, if it is.
    /// `deepest` \[m] is the allowed depth, `reach` \[m] the largest distance in a step.
    pub(crate) fn is_broken(
        &self,
        from: DVec3,
        to: DVec3,
        flat: bool,
        (deepest, reach): (f64, f64),
    ) -> Option<String> {
        let depth = self.depth(to, flat, reach)?;
        if self.is_closed() {
            let deepest = deepest + self.rounding(to, reach);
            return (depth > deepest).then(|| format!("{depth:.4} m in {}", self.name()));
        }
        let before = self.depth(from, flat, reach)?;
        let sheet = matches!(
            self,
            Self::Mesh {
                side: Side::Both,
                ..
            }
        );
        let passed = if sheet {
            before * depth < 0.0 && before.abs().max(depth.abs()) < reach
        } else {
            before <= deepest && depth > deepest && before.abs().max(depth.abs()) < reach
        };
        passed.then(|| format!("{depth:.4} m behind {}, {before:.4} before", self.name()))
    }

    /// Additional depth that is allowed near the edge of a box \[m]. Its samples lie on the diagonal: a quarter of the
    /// spacing along it is deeper when measured along the faces' normals.
    fn rounding(&self, x: DVec3, reach: f64) -> f64 {
        let Self::Block { min, max } = self else {
            return 0.0;
        };
        let depths = (x - min).min(max - x);
        let near = depths
            .to_array()
            .iter()
            .filter(|depth| **depth < 0.5 * reach)
            .count();
        if near > 1 { 0.06 * reach } else { 0.0 }
    }

    fn name(&self) -> String {
        match self {
            Self::Mesh {
                triangles, side, ..
            } => format!("a mesh of {} triangles, {side:?}", triangles.len()),
            other => format!("{other:?}"),
        }
    }
}

/// The point of a triangle nearest to a given point (Ericson 2005, 5.1.5).
fn closest([a, b, c]: &[DVec3; 3], p: DVec3) -> DVec3 {
    let (ab, ac, ap) = (b - a, c - a, p - a);
    let (d1, d2) = (ab.dot(ap), ac.dot(ap));
    if d1 <= 0.0 && d2 <= 0.0 {
        return *a;
    }
    let bp = p - b;
    let (d3, d4) = (ab.dot(bp), ac.dot(bp));
    if d3 >= 0.0 && d4 <= d3 {
        return *b;
    }
    let vc = d1 * d4 - d3 * d2;
    if vc <= 0.0 && d1 >= 0.0 && d3 <= 0.0 {
        return a + d1 / (d1 - d3) * ab;
    }
    let cp = p - c;
    let (d5, d6) = (ab.dot(cp), ac.dot(cp));
    if d6 >= 0.0 && d5 <= d6 {
        return *c;
    }
    let vb = d5 * d2 - d1 * d6;
    if vb <= 0.0 && d2 >= 0.0 && d6 <= 0.0 {
        return a + d2 / (d2 - d6) * ac;
    }
    let va = d3 * d6 - d5 * d4;
    if va <= 0.0 && d4 - d3 >= 0.0 && d5 - d6 >= 0.0 {
        return b + (d4 - d3) / ((d4 - d3) + (d5 - d6)) * (c - b);
    }
    let sum = va + vb + vc;
    a + vb / sum * ab + vc / sum * ac
}

/// Winding number of a closed surface around a point: its solid angle over 4 π (van Oosterom & Strackee 1983).
fn winding(triangles: &[[DVec3; 3]], x: DVec3) -> f64 {
    let angle = |corners: &[DVec3; 3]| {
        let [a, b, c] = corners.map(|corner| corner - x);
        let [la, lb, lc] = [a.length(), b.length(), c.length()];
        let above = a.dot(b.cross(c));
        let below = la * lb * lc + a.dot(b) * lc + b.dot(c) * la + c.dot(a) * lb;
        2.0 * above.atan2(below)
    };
    (triangles.iter().map(angle).sum::<f64>() / (4.0 * std::f64::consts::PI)).abs()
}
