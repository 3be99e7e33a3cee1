//! A mesh in the scene, queried for distances and ray intersections.

use glam::DVec3;

use super::{
    bvh::Bvh,
    height_field::HeightField,
    side::MeshSide,
    topology::Topology,
    triangle::{self, Feature},
};

/// A mesh in the scene: its normals point from the solid into the fluid.
#[derive(Debug, PartialEq)]
pub struct Mesh {
    /// Corners \[m].
    pub(crate) vertices: Vec<DVec3>,
    /// Rows of `vertices`, counter-clockwise seen from the fluid. Every triangle has an area.
    pub(crate) triangles: Vec<[u32; 3]>,
    /// Unit normals of the triangles.
    pub(crate) normals: Vec<DVec3>,
    /// Which side is solid.
    pub(crate) side: MeshSide,
    pub(super) topology: Topology,
    pub(super) bvh: Bvh,
    /// What the surface is as a function, if it is a ground.
    pub(crate) heights: Option<HeightField>,
}

/// The point of a mesh that is nearest to a given point.
#[derive(Debug, Clone, Copy)]
pub struct Nearest {
    /// Its position \[m].
    pub at: DVec3,
    /// The triangle that it lies on.
    pub triangle: usize,
    /// Distance \[m]; negative on the side that normals point away from.
    pub distance: f64,
    /// Whether it lies on the border of an open mesh.
    pub on_border: bool,
}

impl Mesh {
    /// Corners of a triangle \[m].
    pub(crate) fn corners(&self, triangle: usize) -> [DVec3; 3] {
        self.triangles[triangle].map(|corner| self.vertices[corner as usize])
    }

    /// Unit pseudonormals of the vertices.
    pub(crate) fn vertex_normals(&self) -> &[DVec3] {
        &self.topology.vertex_normals
    }

    /// The box around the mesh \[m].
    pub fn bounds(&self) -> (DVec3, DVec3) {
        self.bvh.bounds()
    }

    /// Area of the surface \[m²].
    pub fn area(&self) -> f64 {
        let double = |t| {
            let [a, b, c]: [DVec3; 3] = self.corners(t);
            (b - a).cross(c - a).length()
        };
        0.5 * (0..self.triangles.len()).map(double).sum::<f64>()
    }

    /// Volume that the surface bounds, by the divergence theorem \[m³]: the solid's, or the fluid's with
    /// [`Inside`](MeshSide::Inside). Meaningless for an open surface.
    pub(crate) fn volume(&self) -> f64 {
        let middle = 0.5 * (self.bounds().0 + self.bounds().1);
        let of_one = |t| {
            let [a, b, c]: [DVec3; 3] = self.corners(t).map(|corner| corner - middle);
            a.dot(b.cross(c)) / 6.0
        };
        (0..self.triangles.len()).map(of_one).sum::<f64>().abs()
    }

    /// The nearest point of the surface.
    pub fn nearest(&self, point: DVec3) -> Nearest {
        let closest = |triangle| triangle::closest(self.corners(triangle), point);
        let nearest = self.bvh.nearest(point, |triangle| Some(closest(triangle)));
        // A mesh has at least one triangle, and points are finite. Only NaN finds none.
        let (triangle, closest) = nearest.unwrap_or_else(|| (0, closest(0)));
        let (normal, on_border) = match closest.feature {
            Feature::Face => (self.normals[triangle], false),
            Feature::Edge(edge) => {
                let edge = self.topology.edges[triangle][edge];
                (edge.normal, edge.is_border)
            }
            Feature::Vertex(corner) => {
                let vertex = self.triangles[triangle][corner] as usize;
                (
                    self.topology.vertex_normals[vertex],
                    self.topology.on_border[vertex],
                )
            }
        };
        let offset = point - closest.at;
        let distance = offset.length();
        Nearest {
            at: closest.at,
            triangle,
            distance: if offset.dot(normal) < 0.0 {
                -distance
            } else {
                distance
            },
            on_border,
        }
    }

    /// Depths at which a ray meets the surface [lengths of `direction`], each with its triangle, sorted by depth.
    pub fn hits(&self, origin: DVec3, direction: DVec3, hits: &mut Vec<(f64, usize)>) {
        hits.clear();
        self.bvh
            .visit(origin, direction, f64::INFINITY, |triangle| {
                if let Some(depth) = triangle::hit(self.corners(triangle), origin, direction) {
                    hits.push((depth, triangle));
                }
            });
        hits.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
    }

    /// Sharp and border edges.
    pub(crate) fn feature_edges(&self) -> Vec<FeatureEdge> {
        let mut edges = Vec::new();
        for (corners, sides) in self.triangles.iter().zip(&self.topology.edges) {
            for (k, edge) in sides.iter().enumerate() {
                let ends = [corners[k], corners[(k + 1) % 3]];
                // Each edge once, from the triangle that has its vertices in ascending order.
                if edge.is_border || (edge.is_sharp && ends[0] < ends[1]) {
                    edges.push(FeatureEdge {
                        ends,
                        normal: edge.normal,
                        mitre: edge.mitre,
                    });
                }
            }
        }
        edges
    }
}

/// An edge along which samples are placed.
#[derive(Debug, Clone, Copy)]
pub(crate) struct FeatureEdge {
    /// Rows of the vertices.
    pub(crate) ends: [u32; 2],
    /// Unit mean of the normals of the triangles that meet here.
    pub(crate) normal: DVec3,
    /// Ratio of the offset along `normal` to the offset from every adjacent face.
    pub(crate) mitre: f64,
}
