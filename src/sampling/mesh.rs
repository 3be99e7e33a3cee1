//! Samples triangle meshes: one layer of particles at the spacing, as deep in the solid as for the other shapes.
//!
//! The layer is the mesh with its vertices moved into the solid by [`layer_depth`](super::layer_depth) from every
//! adjacent face, so that its faces meet in edges and corners as those of a tank do. Parts too close to another part of
//! the surface are left out. Samples are spread evenly over the layer ([`Front`]), first along sharp and border edges,
//! then over faces. Acute valleys are sampled last (`Layer::guard_valleys`), then thin parts ([`fill_thin_parts`]). A
//! sheet, which is wet on both sides, is sampled in its own surface, every sample twice.

use glam::{DMat3, DVec3};

use super::{
    BoundarySample,
    candidates::{CANDIDATES, for_each_point},
    front::Front,
    thin_parts::fill_thin_parts,
};
use crate::{
    mesh::{FeatureEdge, Mesh},
    scene::MeshSide,
};

/// Least distance between two samples \[spacings]: the mean area per sample is then 1.02 spacings squared.
const DISTANCE: f32 = 0.96;
/// A vertex is moved by at most this many depths: in valleys sharper than 47° the layer would extend far away.
const LONGEST_MITRE: f64 = 2.5;
/// Least depth of a sample behind the surface \[depths].
const DEEP: f64 = 0.98;
/// A part of a face is unguarded if no sample of the same face is this close along it \[spacings]: contact considers
/// samples up to 1.15.
const OWN: f32 = 1.05;

/// Appends the samples of a mesh.
pub(super) fn sample_mesh(
    mesh: &Mesh,
    spacing: f32,
    (depth, is_first): (f32, bool),
    out: &mut Vec<BoundarySample>,
) {
    let step = f64::from(spacing) / CANDIDATES;
    if mesh.side == MeshSide::Both {
        let sheet = Layer {
            mesh,
            vertices: mesh.vertices.clone(),
            is_mitred: vec![true; mesh.vertices.len()],
            depth: 0.0,
        };
        let mut front = Front::new(DISTANCE * spacing);
        sheet.spread(&mut front, f64::from(spacing), step, &|_| true);
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
    let right = |sample: &BoundarySample| {
        let nearest = mesh.nearest(sample.position.as_dvec3());
        nearest.distance < -DEEP * depth
    };
    layer.spread(&mut front, f64::from(spacing), step, &right);
    if is_first {
        fill_thin_parts(mesh, spacing, depth, &mut front);
        layer.guard_valleys(&mut front, spacing, &right);
    }
    out.extend(front.into_samples());
}

/// The mesh with its vertices moved.
struct Layer<'a> {
    mesh: &'a Mesh,
    vertices: Vec<DVec3>,
    /// Whether a vertex is deep enough behind all adjacent faces, or cannot be.
    is_mitred: Vec<bool>,
    /// Depth of the layer behind the faces \[m].
    depth: f64,
}

impl<'a> Layer<'a> {
    /// Moves every vertex to `depth` behind all adjacent faces, as nearly as possible: least squares of `n·x + depth`,
    /// weighted by the angles of the faces. A small term in `x²` keeps nearly flat corners from sliding.
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
                // A flat corner would have half the trace along its normal, weighted twice.
                let trace = square.x_axis.x + square.y_axis.y + square.z_axis.z;
                if trace == 0.0 {
                    return vertex;
                }
                let square = square + DMat3::IDENTITY * (1e-3 * trace);
                let mitre = square.inverse() * sum;
                vertex + depth * (1.0 + 1e-3) * mitre.clamp_length_max(LONGEST_MITRE)
            });
        let mut layer = Self {
            mesh,
            vertices: moved.collect(),
            is_mitred: vec![true; mesh.vertices.len()],
            depth,
        };
        for (corners, &normal) in mesh.triangles.iter().zip(&mesh.normals) {
            for &corner in corners {
                if !layer.is_deep(corner, normal) {
                    layer.is_mitred[corner as usize] = false;
                }
            }
        }
        // At the edge of a thin solid the layer does not fit, so its depth is accepted as it is.
        for vertex in 0..mesh.vertices.len() {
            if !layer.is_mitred[vertex] {
                let behind = mesh.nearest(layer.behind(vertex)).distance;
                layer.is_mitred[vertex] = behind > -DEEP * depth;
            }
        }
        layer
    }

    /// The point behind a vertex at the depth of the layer.
    fn behind(&self, vertex: usize) -> DVec3 {
        let normal = self.mesh.vertex_normals()[vertex];
        self.mesh.vertices[vertex] - (1.0 + 1e-3) * self.depth * normal
    }

    /// Whether a vertex was moved far enough along the normal of a face.
    fn is_deep(&self, vertex: u32, normal: DVec3) -> bool {
        let way = self.vertices[vertex as usize] - self.mesh.vertices[vertex as usize];
        way.dot(normal) <= -DEEP * self.depth
    }

    /// Corners of a triangle in the layer.
    fn corners(&self, triangle: usize) -> [DVec3; 3] {
        let normal = self.mesh.normals[triangle];
        self.mesh.triangles[triangle].map(|corner| {
            if self.is_mitred[corner as usize] || self.is_deep(corner, normal) {
                self.vertices[corner as usize]
            } else {
                self.mesh.vertices[corner as usize] - (1.0 + 1e-3) * self.depth * normal
            }
        })
    }

    /// Ends of an edge in the layer, and whether its faces meet at an angle blunt enough for a common layer.
    fn ends(&self, edge: &FeatureEdge) -> ([DVec3; 2], bool) {
        let is_blunt = edge.mitre <= LONGEST_MITRE;
        let mitre = if is_blunt { edge.mitre } else { 1.0 };
        let ends = edge.ends.map(|end| {
            if self.is_mitred[end as usize] {
                self.vertices[end as usize]
            } else {
                self.mesh.vertices[end as usize] - (1.0 + 1e-3) * self.depth * mitre * edge.normal
            }
        });
        let is_mitred = edge.ends.iter().all(|&end| self.is_mitred[end as usize]);
        (ends, is_blunt || is_mitred)
    }

    /// Samples along edges, then over faces.
    fn spread(
        &self,
        front: &mut Front,
        spacing: f64,
        step: f64,
        right: &impl Fn(&BoundarySample) -> bool,
    ) {
        let mut short = Vec::new();
        for edge in self.mesh.feature_edges() {
            let ([from, to], is_one_layer) = self.ends(&edge);
            if !is_one_layer {
                continue;
            }
            let count = rows(from.distance(to), spacing);
            if count == 1 {
                short.push(([from, to], edge.normal));
                continue;
            }
            for k in 0..=count {
                let end = match k {
                    0 => Some(edge.ends[0]),
                    _ if k == count => Some(edge.ends[1]),
                    _ => None,
                };
                let end = end.filter(|&end| self.is_mitred[end as usize]);
                let normal =
                    end.map_or(edge.normal, |end| self.mesh.vertex_normals()[end as usize]);
                let sample = BoundarySample {
                    depth: 0.0,
                    position: from.lerp(to, f64::from(k) / f64::from(count)).as_vec3(),
                    normal: normal.as_vec3(),
                };
                if right(&sample) {
                    front.offer_of_edge(sample, 0.6);
                }
            }
        }
        let mut candidates = Vec::new();
        for ([from, to], normal) in short {
            let count = (from.distance(to) / step).ceil().max(1.0) as u32;
            candidates.extend((0..=count).map(|k| BoundarySample {
                depth: 0.0,
                position: from.lerp(to, f64::from(k) / f64::from(count)).as_vec3(),
                normal: normal.as_vec3(),
            }));
        }
        front.advance(&candidates, right);
        candidates.clear();
        for triangle in 0..self.mesh.triangles.len() {
            let normal = self.mesh.normals[triangle].as_vec3();
            for_each_point(self.corners(triangle), step, |position| {
                candidates.push(BoundarySample {
                    depth: 0.0,
                    position: position.as_vec3(),
                    normal,
                });
            });
        }
        front.advance(&candidates, right);
    }

    /// Samples where faces meet at too acute an angle for a common layer: the layers of the faces then meet far behind
    /// the edge. There, the nearest sample belongs to another face and does not guard this one. So each face gets
    /// samples of its own, then the edges and vertices between them.
    fn guard_valleys(
        &self,
        front: &mut Front,
        spacing: f32,
        right: &impl Fn(&BoundarySample) -> bool,
    ) {
        let sample = |position: DVec3, normal: DVec3| BoundarySample {
            depth: 0.0,
            position: position.as_vec3(),
            normal: normal.as_vec3(),
        };
        for (triangle, corners) in self.mesh.triangles.iter().enumerate() {
            if corners
                .iter()
                .all(|&corner| self.is_mitred[corner as usize])
            {
                continue;
            }
            let normal = self.mesh.normals[triangle];
            let step = f64::from(spacing) / CANDIDATES;
            for_each_point(self.mesh.corners(triangle), step, |point| {
                let behind = sample(point - (1.0 + 1e-3) * self.depth * normal, normal);
                if !front.speaks_for(&behind, OWN * spacing) && right(&behind) {
                    front.accept(behind);
                }
            });
        }
        for edge in self.mesh.feature_edges() {
            let ([from, to], is_one_layer) = self.ends(&edge);
            if is_one_layer {
                continue;
            }
            let count = rows(from.distance(to), f64::from(spacing));
            for k in 0..=count {
                let along = from.lerp(to, f64::from(k) / f64::from(count));
                let behind = sample(along, edge.normal);
                if !front.speaks_for(&behind, DISTANCE * spacing) && right(&behind) {
                    front.accept(behind);
                }
            }
        }
        for vertex in (0..self.vertices.len()).filter(|&vertex| !self.is_mitred[vertex]) {
            let behind = sample(self.behind(vertex), self.mesh.vertex_normals()[vertex]);
            if !front.speaks_for(&behind, DISTANCE * spacing) && right(&behind) {
                front.accept(behind);
            }
        }
    }
}

/// Number of intervals in a row of a length at the spacing.
fn rows(length: f64, spacing: f64) -> u32 {
    (length / spacing - 1e-3).ceil().max(1.0) as u32
}
