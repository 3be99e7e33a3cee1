//! Points on the surface of a mesh from which its samples are chosen.

use glam::DVec3;

use crate::{mesh::Mesh, scene::MeshSide};

/// Candidates per spacing along a row.
pub(super) const CANDIDATES: f64 = 6.0;

/// Points of a triangle in rows along its longest edge, at most `step` apart, corners included.
pub(super) fn for_each_point(corners: [DVec3; 3], step: f64, mut visit: impl FnMut(DVec3)) {
    let length = |k: usize| corners[k].distance_squared(corners[(k + 1) % 3]);
    let longest = (1..3).fold(0, |best, k| if length(k) > length(best) { k } else { best });
    let [a, b, c] = [0, 1, 2].map(|k| corners[(longest + k) % 3]);
    let base = a.distance(b);
    if base == 0.0 {
        return visit(a);
    }
    let height = (b - a).cross(c - a).length() / base;
    let rows = (height / step).ceil().max(1.0) as u32;
    for row in 0..=rows {
        let up = f64::from(row) / f64::from(rows);
        let (from, to) = (a.lerp(c, up), b.lerp(c, up));
        let count = (from.distance(to) / step).ceil() as u32;
        for k in 0..=count {
            visit(from.lerp(to, f64::from(k) / f64::from(count.max(1))));
        }
    }
}

/// Rough upper estimates for a mesh: its samples, and the candidates from which they are chosen.
pub(crate) fn expected(mesh: &Mesh, spacing: f32) -> (f64, f64) {
    let spacing = f64::from(spacing);
    if let Some(heights) = &mesh.heights {
        // Its samples are made without candidates, but are as many themselves.
        let samples = mesh.area() / (spacing * spacing) + heights.size.element_sum() / spacing;
        return (samples, samples);
    }
    let step = spacing / CANDIDATES;
    let mut candidates = 0.0;
    for triangle in 0..mesh.triangles.len() {
        let [a, b, c] = mesh.corners(triangle);
        let base = a.distance(b).max(b.distance(c)).max(c.distance(a));
        let height = (b - a).cross(c - a).length() / base.max(f64::MIN_POSITIVE);
        // As in `for_each_point`: rows whose length decreases from that of the longest edge to zero.
        let rows = (height / step).ceil().max(1.0) + 1.0;
        candidates += rows * (0.5 * base / step + 1.5);
    }
    let edges = mesh.feature_edges().into_iter().map(|edge| {
        let [a, b] = edge.ends.map(|corner| mesh.vertices[corner as usize]);
        a.distance(b) / spacing + 1.0
    });
    let samples = mesh.area() / (spacing * spacing) + edges.sum::<f64>();
    let sides = if mesh.side == MeshSide::Both {
        2.0
    } else {
        1.0
    };
    (sides * samples, candidates)
}
