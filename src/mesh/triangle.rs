//! One triangle: its point nearest to a given point, and its intersection with a ray.

use glam::DVec3;

/// A feature of a triangle.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Feature {
    Face,
    /// The edge from this corner to the next.
    Edge(usize),
    Vertex(usize),
}

/// The nearest point of a triangle.
#[derive(Debug, Clone, Copy)]
pub(super) struct Closest {
    pub(super) at: DVec3,
    pub(super) feature: Feature,
}

/// The point of a triangle nearest to `point`, by its Voronoi regions (Ericson 2005, 5.1.5).
pub(super) fn closest([a, b, c]: [DVec3; 3], point: DVec3) -> Closest {
    let vertex = |k: usize| Closest {
        at: [a, b, c][k],
        feature: Feature::Vertex(k),
    };
    let (ab, ac, ap) = (b - a, c - a, point - a);
    let (d1, d2) = (ab.dot(ap), ac.dot(ap));
    if d1 <= 0.0 && d2 <= 0.0 {
        return vertex(0);
    }
    let bp = point - b;
    let (d3, d4) = (ab.dot(bp), ac.dot(bp));
    if d3 >= 0.0 && d4 <= d3 {
        return vertex(1);
    }
    let vc = d1 * d4 - d3 * d2;
    if vc <= 0.0 && d1 >= 0.0 && d3 <= 0.0 {
        return Closest {
            at: a + ab * (d1 / (d1 - d3)),
            feature: Feature::Edge(0),
        };
    }
    let cp = point - c;
    let (d5, d6) = (ab.dot(cp), ac.dot(cp));
    if d6 >= 0.0 && d5 <= d6 {
        return vertex(2);
    }
    let vb = d5 * d2 - d1 * d6;
    if vb <= 0.0 && d2 >= 0.0 && d6 <= 0.0 {
        return Closest {
            at: a + ac * (d2 / (d2 - d6)),
            feature: Feature::Edge(2),
        };
    }
    let va = d3 * d6 - d5 * d4;
    if va <= 0.0 && d4 >= d3 && d5 >= d6 {
        let along = (d4 - d3) / ((d4 - d3) + (d5 - d6));
        return Closest {
            at: b + (c - b) * along,
            feature: Feature::Edge(1),
        };
    }
    let all = va + vb + vc;
    Closest {
        at: a + ab * (vb / all) + ac * (vc / all),
        feature: Feature::Face,
    }
}

/// The depth at which a ray meets a triangle, from either side (Möller & Trumbore 1997).
pub(super) fn hit([a, b, c]: [DVec3; 3], origin: DVec3, direction: DVec3) -> Option<f64> {
    let (ab, ac) = (b - a, c - a);
    let p = direction.cross(ac);
    let determinant = ab.dot(p);
    if determinant == 0.0 {
        return None;
    }
    let from = origin - a;
    let u = from.dot(p) / determinant;
    let q = from.cross(ab);
    let v = direction.dot(q) / determinant;
    let depth = ac.dot(q) / determinant;
    (u >= 0.0 && v >= 0.0 && u + v <= 1.0 && depth > 0.0).then_some(depth)
}
