//! Thin parts of a mesh, which the layer of samples behind its faces does not reach.

use glam::DVec3;

use super::{
    BoundarySample,
    candidates::{CANDIDATES, for_each_point},
    front::Front,
};
use crate::mesh::Mesh;

/// Faces whose normals are further apart than by this cosine are the two sides of a thin part.
const OPPOSITE: f64 = -0.5;
/// A part of the surface without a sample of its side this near is not guarded \[spacings]. The layers of a built-in
/// tank and box leave 0.90 and 1.04.
const GUARDED: f32 = 1.15;

/// Guards what the layer does not reach, each side for itself: first between two sides, then along rims, where balls
/// are the smaller the nearer to the edge they touch, from the largest on.
pub(super) fn fill_thin_parts(mesh: &Mesh, spacing: f32, depth: f64, front: &mut Front) {
    let guarded = GUARDED * spacing;
    let mut balls = Vec::new();
    for triangle in 0..mesh.triangles.len() {
        let normal = mesh.normals[triangle];
        // A little inside of the triangle, where its own normal counts.
        let corners = mesh.corners(triangle);
        let middle = (corners[0] + corners[1] + corners[2]) / 3.0;
        let corners = corners.map(|corner| corner.lerp(middle, 1e-3));
        for_each_point(corners, f64::from(spacing) / CANDIDATES, |point| {
            if !front.covers(point.as_vec3(), normal.as_vec3(), guarded) {
                balls.extend(Ball::largest(mesh, point, normal, depth));
            }
        });
    }
    let between = balls.iter().filter(|ball| ball.is_between);
    let between: Vec<BoundarySample> = between.map(Ball::sample).collect();
    front.advance(&between, |_| true);
    balls.sort_by(|a, b| b.radius.total_cmp(&a.radius));
    for ball in &balls {
        if !front.covers(ball.touches.as_vec3(), ball.normal.as_vec3(), guarded) {
            front.offer(ball.beside_rim(mesh, depth).sample());
        }
    }
}

/// The largest ball in the solid that touches its surface at a place.
#[derive(Debug, Clone, Copy)]
struct Ball {
    centre: DVec3,
    radius: f64,
    /// The place.
    touches: DVec3,
    /// Of the surface there.
    normal: DVec3,
    /// Whether the surface that keeps it from being larger faces the other way.
    is_between: bool,
}

impl Ball {
    /// With a radius of `depth` at most.
    fn largest(mesh: &Mesh, touches: DVec3, normal: DVec3, depth: f64) -> Option<Self> {
        let mut ball = Self {
            centre: touches - depth * normal,
            radius: depth,
            touches,
            normal,
            is_between: false,
        };
        for _ in 0..20 {
            ball.centre = touches - ball.radius * normal;
            let nearest = mesh.nearest(ball.centre);
            if nearest.distance <= -0.99 * ball.radius {
                return Some(ball);
            }
            ball.is_between = mesh.normals[nearest.triangle].dot(normal) < OPPOSITE;
            // Through the place and the nearest point: that is in the ball, or the centre is past the solid's other
            // side.
            let offset = touches - nearest.at;
            let along = 2.0 * normal.dot(offset);
            if along <= 0.0 {
                return None;
            }
            ball.radius = ball.radius.min(offset.length_squared() / along);
        }
        ball.centre = touches - ball.radius * normal;
        Some(ball)
    }

    /// On the edge of a thin part the layer is as deep behind the rim as behind any face, if the part is no thinner
    /// there.
    fn beside_rim(self, mesh: &Mesh, depth: f64) -> Self {
        let centre = self.touches - depth * self.normal;
        let is_within = mesh.nearest(centre).distance <= -0.98 * self.radius;
        if is_within {
            Self { centre, ..self }
        } else {
            self
        }
    }

    fn sample(&self) -> BoundarySample {
        BoundarySample {
            position: self.centre.as_vec3(),
            normal: self.normal.as_vec3(),
        }
    }
}
