//! Triangle meshes into particles: one layer at the spacing, as deep in the solid as the layers of the other shapes.
//!
//! The layer is the mesh itself with its vertices moved into the solid by [`layer_depth`](super::layer_depth) from every
//! face around them, so that it meets in edges and corners as those of a tank do. What comes out too near to another
//! part of the surface is left out. Then samples are spread evenly over it ([`Front`]): along sharp and border edges
//! first, then over the faces.
//!
//! Where a solid is thinner than two layers none of this layer is left. There the samples are centres of the largest
//! balls that fit into the solid and touch its surface (by shrinking balls: Ma, Bae & Choi 2012), for each side with its
//! own normals. Two sides in one place share its volume, since that follows from how dense the samples are. A sheet, whose
//! both sides are wet, is sampled in itself, every sample twice.

use glam::{DMat3, DVec3};

use super::{BoundarySample, front::Front};
use crate::{mesh::Mesh, scene::MeshSide};

/// Least distance of two samples, in spacings: the mean area for each is then 1.02 spacings squared.
const DISTANCE: f32 = 0.96;
/// Candidates in a spacing.
const CANDIDATES: f64 = 6.0;
/// A vertex is moved at most so many depths: at sharper valleys than 47° the layer would run far off.
const LONGEST_MITRE: f64 = 2.5;
/// A part of the surface without a sample of its side this near is not guarded [spacings]. The layers of a built-in tank
/// and box leave 0.90 and 1.04.
const GUARDED: f32 = 1.15;

/// Appends the samples of a mesh.
pub(super) fn sample_mesh(mesh: &Mesh, spacing: f32, depth: f32, out: &mut Vec<BoundarySample>) {
    let step = f64::from(spacing) / CANDIDATES;
    if mesh.side == MeshSide::Both {
        let sheet = Layer {
            mesh,
            vertices: mesh.vertices.clone(),
        };
        let mut front = Front::new(DISTANCE * spacing);
        sheet.spread(&mut front, f64::from(spacing), step, |_| true);
        for sample in front.into_samples() {
            out.extend([1.0, -1.0].map(|sign| BoundarySample {
                normal: sign * sample.normal,
                ..sample
            }));
        }
        return;
    }
    let depth = f64::from(depth);
    let mut front = Front::new(DISTANCE * spacing);
    let layer = Layer::new(mesh, depth);
    layer.spread(&mut front, f64::from(spacing), step, |sample| {
        let nearest = mesh.nearest(sample.position.as_dvec3());
        nearest.distance < -0.98 * depth
    });
    fill_thin_parts(mesh, spacing, depth, &mut front);
    out.extend(front.into_samples());
}

/// The mesh with its vertices moved.
struct Layer<'a> {
    mesh: &'a Mesh,
    vertices: Vec<DVec3>,
}

impl<'a> Layer<'a> {
    /// Every vertex at `depth` behind all faces around it, as nearly as can be: the least squares of `n·x + depth`,
    /// weighted by the faces' angles. Nearly flat corners are kept from sliding by a little of `x²`.
    fn new(mesh: &'a Mesh, depth: f64) -> Self {
        let mut sums = vec![(DMat3::ZERO, DVec3::ZERO); mesh.vertices.len()];
        for (triangle, corners) in mesh.triangles.iter().enumerate() {
            let (at, n) = (mesh.corners(triangle), mesh.normals[triangle]);
            let square = DMat3::from_cols(n * n.x, n * n.y, n * n.z);
            for (k, &corner) in corners.iter().enumerate() {
                let (next, last) = (at[(k + 1) % 3] - at[k], at[(k + 2) % 3] - at[k]);
                let angle = next.angle_between(last);
                let sum = &mut sums[corner as usize];
                sum.0 += square * angle;
                sum.1 -= n * angle;
            }
        }
        let moved = mesh
            .vertices
            .iter()
            .zip(sums)
            .map(|(&vertex, (square, sum))| {
                // Half the trace is what a flat corner would have along its normal twice over.
                let trace = square.x_axis.x + square.y_axis.y + square.z_axis.z;
                if trace == 0.0 {
                    return vertex;
                }
                let square = square + DMat3::IDENTITY * (1e-3 * trace);
                let mitre = square.inverse() * sum;
                vertex + depth * (1.0 + 1e-3) * mitre.clamp_length_max(LONGEST_MITRE)
            });
        Self {
            mesh,
            vertices: moved.collect(),
        }
    }

    /// Samples along edges, then over faces.
    fn spread(
        &self,
        front: &mut Front,
        spacing: f64,
        step: f64,
        right: impl Fn(&BoundarySample) -> bool,
    ) {
        let edges = self.mesh.feature_edges();
        let mut short = Vec::new();
        for &(a, b, normal) in &edges {
            let (from, to) = (self.vertices[a as usize], self.vertices[b as usize]);
            let length = from.distance(to);
            let count = (length / spacing - 1e-3).ceil().max(1.0) as u32;
            if count == 1 {
                short.push((a, b, normal));
                continue;
            }
            for k in 0..=count {
                let normal = match k {
                    0 => self.mesh.vertex_normals()[a as usize],
                    _ if k == count => self.mesh.vertex_normals()[b as usize],
                    _ => normal,
                };
                let sample = BoundarySample {
                    position: from.lerp(to, f64::from(k) / f64::from(count)).as_vec3(),
                    normal: normal.as_vec3(),
                };
                if right(&sample) {
                    front.offer(sample, 0.6);
                }
            }
        }
        let mut candidates = Vec::new();
        for (a, b, normal) in short {
            let (from, to) = (self.vertices[a as usize], self.vertices[b as usize]);
            let count = (from.distance(to) / step).ceil().max(1.0) as u32;
            candidates.extend((0..=count).map(|k| BoundarySample {
                position: from.lerp(to, f64::from(k) / f64::from(count)).as_vec3(),
                normal: normal.as_vec3(),
            }));
        }
        front.advance(&candidates, &right);
        candidates.clear();
        for triangle in 0..self.mesh.triangles.len() {
            let normal = self.mesh.normals[triangle].as_vec3();
            let corners = self.mesh.triangles[triangle].map(|k| self.vertices[k as usize]);
            for_each_point(corners, step, |position| {
                candidates.push(BoundarySample {
                    position: position.as_vec3(),
                    normal,
                });
            });
        }
        front.advance(&candidates, &right);
    }
}

/// Points of a triangle in rows along its longest edge, no further apart than `step`, corners included.
fn for_each_point(corners: [DVec3; 3], step: f64, mut visit: impl FnMut(DVec3)) {
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

/// How many samples a mesh has, roughly and rather too many, and how many candidates they are chosen from.
pub(crate) fn expected(mesh: &Mesh, spacing: f32) -> (f64, f64) {
    let spacing = f64::from(spacing);
    let step = spacing / CANDIDATES;
    let mut candidates = 0.0;
    for triangle in 0..mesh.triangles.len() {
        let [a, b, c] = mesh.corners(triangle);
        let base = a.distance(b).max(b.distance(c)).max(c.distance(a));
        let height = (b - a).cross(c - a).length() / base.max(f64::MIN_POSITIVE);
        // As `for_each_point` goes: rows whose length falls from that of the longest edge to zero.
        let rows = (height / step).ceil().max(1.0) + 1.0;
        candidates += rows * (0.5 * base / step + 1.5);
    }
    let edges = mesh.feature_edges().into_iter().map(|(a, b, _)| {
        let [a, b] = [a, b].map(|corner| mesh.vertices[corner as usize]);
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

/// Guards what the layer does not reach, each side for itself.
fn fill_thin_parts(mesh: &Mesh, spacing: f32, depth: f64, front: &mut Front) {
    let mut centres = Vec::new();
    for triangle in 0..mesh.triangles.len() {
        let normal = mesh.normals[triangle];
        // A little inside of the triangle, where its own normal counts.
        let corners = mesh.corners(triangle);
        let middle = (corners[0] + corners[1] + corners[2]) / 3.0;
        let corners = corners.map(|corner| corner.lerp(middle, 1e-3));
        for_each_point(corners, f64::from(spacing) / CANDIDATES, |point| {
            if !front.covers(point.as_vec3(), normal.as_vec3(), GUARDED * spacing)
                && let Some(centre) = medial_ball(mesh, point, normal, depth)
            {
                centres.push(BoundarySample {
                    position: centre.as_vec3(),
                    normal: normal.as_vec3(),
                });
            }
        });
    }
    front.advance(&centres, |_| true);
}

/// Centre of the largest ball in the solid that touches the surface at `point`, of radius `depth` at most.
fn medial_ball(mesh: &Mesh, point: DVec3, normal: DVec3, depth: f64) -> Option<DVec3> {
    let mut radius = depth;
    for _ in 0..20 {
        let centre = point - radius * normal;
        let nearest = mesh.nearest(centre);
        if nearest.distance <= -0.99 * radius {
            return Some(centre);
        }
        // Through `point` and the nearest point: that is in the ball, or the centre is past the solid's other side.
        let offset = point - nearest.at;
        let along = 2.0 * normal.dot(offset);
        if along <= 0.0 {
            return None;
        }
        radius = radius.min(offset.length_squared() / along);
    }
    Some(point - radius * normal)
}
