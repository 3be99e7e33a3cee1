//! Loads a mesh into the scene: reads the file, places the mesh, welds vertices, orients faces.

use std::path::Path;

use glam::DVec3;

use super::{
    bvh::Bvh,
    error::MeshError,
    height_field::HeightField,
    place::Place,
    read, shells,
    side::MeshSide,
    soup::Soup,
    surface::Mesh,
    topology::{self, Topology},
    weld::weld,
};

/// Vertices on borders closer than this are merged; surfaces closer than this touch \[spacings].
pub(crate) const TOLERANCE: f64 = 0.01;

/// The vertices of a file, placed \[m].
pub(crate) fn vertices(file: &Path, place: Place) -> Result<Vec<DVec3>, MeshError> {
    let mut soup = read::read(file)?;
    place.put(&mut soup.vertices);
    Ok(soup.vertices)
}

/// A remark on a surface of a size that no scene has; else nothing. Its triangles fail for reasons that mislead.
fn units(soup: &Soup, spacing: f32) -> String {
    let low = soup.vertices.iter().copied().reduce(DVec3::min);
    let high = soup.vertices.iter().copied().reduce(DVec3::max);
    let size = low
        .zip(high)
        .map_or(0.0, |(low, high)| (high - low).max_element());
    let spacings = size / f64::from(spacing);
    if size == 0.0 || (1.0..1e9).contains(&spacings) {
        return String::new();
    }
    format!(
        ". It is {size:.1e} m large, with a spacing of {spacing:e} m: if its units are others, set `scale`, the metres \
         in one of them"
    )
}

impl Mesh {
    /// Reads a file and places it, for particles at a spacing \[m].
    pub(crate) fn read(
        file: &Path,
        place: Place,
        side: MeshSide,
        spacing: f32,
    ) -> Result<Self, MeshError> {
        let mut soup = read::read(file)?;
        place.put(&mut soup.vertices);
        let units = units(&soup, spacing);
        Self::of_soup(soup, side, spacing).map_err(|message| MeshError::Unusable {
            file: file.to_owned(),
            message: message + &units,
        })
    }

    /// The surface of a ground, solid below, for particles at a spacing \[m].
    pub(crate) fn of_ground(heights: HeightField, spacing: f32) -> Result<Self, MeshError> {
        let mesh = Self::of_soup(heights.soup(), MeshSide::Front, spacing);
        let mut mesh = mesh.map_err(MeshError::Surface)?;
        mesh.heights = Some(heights);
        Ok(mesh)
    }

    /// Connects triangles to a surface for particles at a spacing \[m].
    pub(super) fn of_soup(soup: Soup, side: MeshSide, spacing: f32) -> Result<Self, String> {
        Self::new(soup, side, TOLERANCE * f64::from(spacing))
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
            heights: None,
        })
    }
}
