//! Thin parts of a mesh: where a solid is thinner than two layers, the layer of samples behind its faces does not
//! exist.

use glam::DVec3;

use super::{
    BoundarySample,
    candidates::{CANDIDATES, for_each_point},
    front::Front,
};
use crate::{mesh::Mesh, scene::MeshSide};

/// Faces are the two sides of a thin part if the cosine between their normals is below this.
const OPPOSITE: f64 = -0.5;
/// A part of the surface is unguarded if no sample of its side is this close \[spacings]. The layers of a built-in tank
/// and box leave 0.90 and 1.04.
const GUARDED: f32 = 1.15;

/// Samples the thin parts, each side separately. Samples are centres of the largest balls that fit into the solid and
/// touch its surface (shrinking balls: Ma, Bae & Choi 2012), with the normal of that side. Two sides in one place share
/// its volume, because volumes follow from the density of samples. Parts between two sides come first, then rims. At
/// rims the balls shrink towards the edge, and the largest are taken first.
pub(super) fn fill_thin_parts(mesh: &Mesh, spacing: f32, depth: f64, front: &mut Front) {
    let guarded = GUARDED * spacing;
    let mut balls = Vec::new();
    for triangle in 0..mesh.triangles.len() {
        let step = f64::from(spacing) / CANDIDATES;
        for_each_inner_point(mesh, triangle, step, |point, normal| {
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

/// Points per spacing of the surface that are asked whether the solid is thin behind them.
const ASKED: f64 = 2.0;

/// Radius of a ball between two faces up to which samples of their rims may lie nearer to a face than the layer
/// \[depths]: those of a part 1.6 spacings thick do.
const RIMS: f64 = 1.8;

/// Whether a part of a mesh is so thin that samples may lie nearer to its faces than the layer does.
pub(crate) fn has_thin_parts(mesh: &Mesh, spacing: f64, depth: f64) -> bool {
    if mesh.heights.is_some() || mesh.side == MeshSide::Both {
        return false;
    }
    (0..mesh.triangles.len()).any(|triangle| {
        let mut is_thin = false;
        for_each_inner_point(mesh, triangle, spacing / ASKED, |point, normal| {
            let ball = || Ball::largest(mesh, point, normal, RIMS * depth);
            is_thin = is_thin || ball().is_none_or(|ball| ball.is_between);
        });
        is_thin
    })
}

/// Points of a triangle, slightly inside it, where its own normal applies.
fn for_each_inner_point(
    mesh: &Mesh,
    triangle: usize,
    step: f64,
    mut visit: impl FnMut(DVec3, DVec3),
) {
    let normal = mesh.normals[triangle];
    let corners = mesh.corners(triangle);
    let middle = (corners[0] + corners[1] + corners[2]) / 3.0;
    let corners = corners.map(|corner| corner.lerp(middle, 1e-3));
    for_each_point(corners, step, |point| visit(point, normal));
}

/// The largest ball in the solid that touches its surface at a given point.
#[derive(Debug, Clone, Copy)]
struct Ball {
    centre: DVec3,
    radius: f64,
    /// The point of contact.
    touches: DVec3,
    /// Normal of the surface there.
    normal: DVec3,
    /// Whether the surface that limits its radius faces the other way.
    is_between: bool,
}

impl Ball {
    /// The largest ball with a radius of at most `depth`.
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
            // The ball through the point of contact and the nearest point. The nearest point is inside the present
            // ball, unless the centre is beyond the other side of the solid.
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

    /// At the edge of a thin part, moves the centre as deep behind the rim as the layer is behind any face, if the part
    /// is no thinner there.
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
            depth: 0.0,
            position: self.centre.as_vec3(),
            normal: self.normal.as_vec3(),
        }
    }
}
