//! Loads a mesh into the scene: reads the file, places the mesh, welds vertices, orients faces.

use std::path::Path;

use glam::{DMat3, DQuat, DVec3, EulerRot};

use super::{
    bvh::Bvh,
    error::MeshError,
    read, shells,
    soup::Soup,
    surface::Mesh,
    topology::{self, Topology},
    weld::weld,
};
use crate::scene::{MeshBoundary, MeshSide};

/// Vertices on borders closer than this are merged; surfaces closer than this touch \[spacings].
pub(crate) const TOLERANCE: f64 = 0.01;

impl Mesh {
    /// Reads and places a mesh for particles at a spacing \[m]. Seams of up to 1/100 of the spacing are closed. Fails
    /// if the file is not a mesh or if its surface does not define where the solid is.
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
        // Slivers count for connectivity, but their area is practically zero.
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
}

/// Linear map and translation: scale first, then rotate about x, y and z in this order, then translate.
fn placement(boundary: &MeshBoundary) -> (DMat3, DVec3) {
    let turn = boundary.rotation * (std::f64::consts::PI / 180.0);
    let turn = DQuat::from_euler(EulerRot::ZYX, turn.z, turn.y, turn.x);
    let scale = DMat3::from_diagonal(DVec3::splat(boundary.scale));
    (DMat3::from_quat(turn) * scale, boundary.translation)
}
