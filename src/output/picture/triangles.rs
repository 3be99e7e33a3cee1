//! Triangles of the fluid's surface on the picture.

use glam::{Vec2, Vec3, vec2};
use rayon::prelude::*;

use super::projection::{Projected, Projection};
use super::target::{Splat, Target};
use crate::output::surface::SurfaceMesh;

/// Share of a corner below which a sample is outside of a triangle: slightly below 0, so that no sample falls between
/// two triangles.
const OUTSIDE: f32 = -1e-4;

/// A surface as the eye sees it.
pub(super) struct Faces<'a> {
    mesh: &'a SurfaceMesh,
    /// Its vertices on the picture.
    vertices: Vec<Projected>,
    /// Whether each is in front of the eye.
    seen: Vec<bool>,
}

impl<'a> Faces<'a> {
    pub(super) fn new(projection: &Projection, mesh: &'a SurfaceMesh) -> Self {
        let positions = mesh.positions.par_iter();
        let vertices: Vec<Projected> = positions.map(|at| projection.project(*at)).collect();
        let seen = vertices
            .iter()
            .map(|vertex| vertex.at.is_finite() && projection.sees(vertex.depth))
            .collect();
        Self {
            mesh,
            vertices,
            seen,
        }
    }

    /// A circle around a triangle; of radius 0 around one that is not on the picture.
    pub(super) fn splat(&self, triangle: u32, (width, height): (usize, usize)) -> Splat {
        let size = vec2(width as f32, height as f32);
        let triangle = &self.mesh.triangles[triangle as usize];
        let corners = triangle.map(|i| self.vertices[i as usize].at);
        let low = corners.into_iter().fold(Vec2::INFINITY, Vec2::min);
        let high = corners.into_iter().fold(Vec2::NEG_INFINITY, Vec2::max);
        let in_front = triangle.iter().all(|i| self.seen[*i as usize]);
        let on_picture = in_front && high.cmpgt(Vec2::ZERO).all() && low.cmplt(size).all();
        Splat {
            at: 0.5 * (low + high),
            radius: if on_picture {
                (0.5 * (high - low)).max_element().max(1.0)
            } else {
                0.0
            },
            depth: 0.0,
        }
    }

    /// Draws the part of a triangle that is in a band.
    pub(super) fn draw(&self, triangle: u32, projection: &Projection, target: &mut Target<'_>) {
        let corners = self.mesh.triangles[triangle as usize].map(|i| self.vertices[i as usize]);
        let [a, b, c] = corners.map(|corner| corner.at);
        let depths = Vec3::from(corners.map(|corner| corner.depth));
        let twice_area = (b - a).perp_dot(c - a);
        if twice_area == 0.0 {
            return;
        }
        let (low, high) = (a.min(b).min(c), a.max(b).max(c));
        let rows = target.depth.len() / target.width;
        // The casts turn negative numbers into 0.
        let first = ((low.y - 0.5).floor() as usize).saturating_sub(target.first_row);
        let end = ((high.y + 0.5).ceil() as usize).saturating_sub(target.first_row);
        for y in first..end.min(rows) {
            for x in
                (low.x - 0.5).floor() as usize..((high.x + 0.5).ceil() as usize).min(target.width)
            {
                let at = vec2(x as f32 + 0.5, (target.first_row + y) as f32 + 0.5);
                let of_b = (at - a).perp_dot(c - a) / twice_area;
                let of_c = (b - a).perp_dot(at - a) / twice_area;
                let shares = Vec3::new(1.0 - of_b - of_c, of_b, of_c);
                if shares.min_element() < OUTSIDE {
                    continue;
                }
                let depth = projection.depth_within(depths, shares);
                let i = y * target.width + x;
                if depth < target.depth[i] {
                    target.depth[i] = depth;
                    target.surface[i] = triangle;
                }
            }
        }
    }
}

/// The corners of a triangle, and their shares of a point in it.
pub(super) fn shares(mesh: &SurfaceMesh, triangle: u32, at: Vec3) -> ([usize; 3], Vec3) {
    let corners = mesh.triangles[triangle as usize].map(|i| i as usize);
    let [a, b, c] = corners.map(|i| mesh.positions[i]);
    let normal = (b - a).cross(c - a);
    let of_b = (at - a).cross(c - a).dot(normal) / normal.length_squared();
    let of_c = (b - a).cross(at - a).dot(normal) / normal.length_squared();
    if !(of_b.is_finite() && of_c.is_finite()) {
        return (corners, Vec3::X);
    }
    let shares = Vec3::new(1.0 - of_b - of_c, of_b, of_c);
    (corners, shares.clamp(Vec3::ZERO, Vec3::ONE))
}
