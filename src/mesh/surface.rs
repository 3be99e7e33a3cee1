//! Triangle meshes: read from a file, placed in the scene, asked for distances and for what a ray meets.
//!
//! Whether a point is in the solid is the sign of its offset from the nearest point of the surface along the
//! angle-weighted pseudonormal there (Bærentzen & Aanæs 2005), which is right for every closed mesh and, unlike
//! counting crossings of a ray, local: it serves open meshes, too.
//!
//! Option 2 was the geometry library parry, which has all of this; it would add some thirty crates to the library of an
//! embedder.

mod bvh;
mod obj;
mod polygon;
mod read;
mod shells;
mod stl;
mod topology;
mod triangle;
mod weld;

use std::path::{Path, PathBuf};

use glam::{DMat3, DQuat, DVec3, EulerRot};

use crate::scene::{MeshBoundary, MeshSide};
use bvh::Bvh;
use topology::Topology;
use triangle::Feature;
use weld::weld;

/// Why a mesh cannot be a boundary. The message names the file and what would be right.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum MeshError {
    /// The file cannot be opened.
    #[error("cannot read the mesh {}: {source}", .file.display())]
    Unreadable {
        /// The file.
        file: PathBuf,
        /// What the operating system says.
        source: std::io::Error,
    },
    /// The file's text or bytes are no mesh, or not one that bounds a solid.
    #[error("the mesh {}: {message}", .file.display())]
    Unusable {
        /// The file.
        file: PathBuf,
        /// What is wrong and what would be right.
        message: String,
    },
}

/// Triangles of no file.
#[derive(Debug, Default)]
struct Soup {
    vertices: Vec<DVec3>,
    triangles: Vec<[u32; 3]>,
}

/// Vertices on borders that are so near become one; surfaces that are so near touch [spacings].
pub(crate) const TOLERANCE: f64 = 0.01;

/// A mesh in the scene: its normals point from the solid into the fluid.
#[derive(Debug, PartialEq)]
pub struct Mesh {
    /// Corners [m].
    pub(crate) vertices: Vec<DVec3>,
    /// Rows of `vertices`, counter-clockwise seen from the fluid. None is without area.
    pub(crate) triangles: Vec<[u32; 3]>,
    /// Unit normals of the triangles.
    pub(crate) normals: Vec<DVec3>,
    /// Which side is solid.
    pub(crate) side: MeshSide,
    topology: Topology,
    bvh: Bvh,
}

/// The point of a mesh nearest to another.
#[derive(Debug, Clone, Copy)]
pub struct Nearest {
    /// Where [m].
    pub at: DVec3,
    /// On which triangle.
    pub triangle: usize,
    /// Distance [m]; negative on the side that normals point away from.
    pub distance: f64,
    /// Whether it is on the border of an open mesh.
    pub on_border: bool,
}

impl Mesh {
    /// Reads and places a mesh, for particles at a spacing [m]: seams of up to 1/100 of it are closed. Fails if the
    /// file is no mesh or its surface does not say where the solid is.
    pub fn load(boundary: &MeshBoundary, spacing: f32) -> Result<Self, MeshError> {
        let file = Path::new(&boundary.file);
        let refuse = |message: String| MeshError::Unusable {
            file: file.to_owned(),
            message,
        };
        let mut soup = read::read(file)?;
        let place = placement(boundary);
        for vertex in &mut soup.vertices {
            *vertex = place.0 * *vertex + place.1;
        }
        Self::new(soup, boundary.side, TOLERANCE * f64::from(spacing)).map_err(refuse)
    }

    fn new(soup: Soup, side: MeshSide, tolerance: f64) -> Result<Self, String> {
        let mut soup = weld(soup, tolerance)?;
        let fault = topology::fault(&soup, tolerance);
        let closed = matches!(side, MeshSide::Outside | MeshSide::Inside);
        if let (true, Some(fault)) = (closed, fault) {
            return Err(fault);
        }
        if closed {
            shells::orient(&mut soup, side == MeshSide::Inside, tolerance)?;
        }
        let normals = soup.triangles.iter().map(|corners| {
            let [a, b, c] = corners.map(|corner| soup.vertices[corner as usize]);
            (b - a).cross(c - a).normalize_or_zero()
        });
        let normals: Vec<DVec3> = normals.collect();
        // Slivers count for what is connected to what, but have no surface to speak of.
        let topology = Topology::new(&soup, &normals);
        let kept: Vec<usize> = (0..normals.len())
            .filter(|&triangle| normals[triangle] != DVec3::ZERO)
            .collect();
        if kept.is_empty() {
            return Err(format!(
                "none of its {} triangles has an area; export the surface with its faces",
                normals.len()
            ));
        }
        let triangles: Vec<[u32; 3]> = kept.iter().map(|&k| soup.triangles[k]).collect();
        let normals: Vec<DVec3> = kept.iter().map(|&k| normals[k]).collect();
        let topology = topology.of(&kept);
        let bvh = Bvh::new(&soup.vertices, &triangles);
        Ok(Self {
            vertices: soup.vertices,
            triangles,
            normals,
            side,
            topology,
            bvh,
        })
    }

    /// Corners of a triangle [m].
    pub(crate) fn corners(&self, triangle: usize) -> [DVec3; 3] {
        self.triangles[triangle].map(|corner| self.vertices[corner as usize])
    }

    /// Unit pseudonormals of the vertices.
    pub(crate) fn vertex_normals(&self) -> &[DVec3] {
        &self.topology.vertex_normals
    }

    /// The box around the mesh [m].
    pub fn bounds(&self) -> (DVec3, DVec3) {
        self.bvh.bounds()
    }

    /// Area of the surface [m²].
    pub fn area(&self) -> f64 {
        let double = |t| {
            let [a, b, c]: [DVec3; 3] = self.corners(t);
            (b - a).cross(c - a).length()
        };
        0.5 * (0..self.triangles.len()).map(double).sum::<f64>()
    }

    /// The nearest point of the surface.
    pub fn nearest(&self, point: DVec3) -> Nearest {
        let closest = |triangle| triangle::closest(self.corners(triangle), point);
        let nearest = self.bvh.nearest(point, |triangle| Some(closest(triangle)));
        // There is a triangle, and points are finite; NaN would find none.
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

    /// Depths at which a ray meets the surface [lengths of `direction`], from the nearest on, and on which triangle.
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
                // Each edge once, from the triangle that goes along it upwards.
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

/// An edge that samples lie along.
#[derive(Debug, Clone, Copy)]
pub(crate) struct FeatureEdge {
    /// Rows of the vertices.
    pub(crate) ends: [u32; 2],
    /// Unit mean of the normals of the triangles that meet here.
    pub(crate) normal: DVec3,
    /// How much farther along the normal than along theirs a place is that is behind all as far.
    pub(crate) mitre: f64,
}

/// Scaled, then turned about x, y and z in this order, then moved.
fn placement(boundary: &MeshBoundary) -> (DMat3, DVec3) {
    let turn = boundary.rotation * (std::f64::consts::PI / 180.0);
    let turn = DQuat::from_euler(EulerRot::ZYX, turn.z, turn.y, turn.x);
    let scale = DMat3::from_diagonal(DVec3::splat(boundary.scale));
    (DMat3::from_quat(turn) * scale, boundary.translation)
}
