//! A surface of triangles with normals and velocities at its vertices.

use glam::{DVec3, Vec3};

/// The surface of the fluid at one time. All lists of vertices have the same length.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct SurfaceMesh {
    /// Number of the step.
    pub step: u64,
    /// Simulated time \[s].
    pub time: f64,
    /// Positions of the vertices \[m].
    pub positions: Vec<Vec3>,
    /// Unit normals at the vertices, out of the fluid.
    pub normals: Vec<Vec3>,
    /// Velocities of the fluid at the vertices \[m/s].
    pub velocities: Vec<Vec3>,
    /// Vertices of the triangles, counter-clockwise seen from outside.
    pub triangles: Vec<[u32; 3]>,
}

impl SurfaceMesh {
    /// Area \[m²].
    pub fn area(&self) -> f64 {
        let areas = self
            .corners()
            .map(|[a, b, c]| (b - a).cross(c - a).length());
        0.5 * areas.sum::<f64>()
    }

    /// Volume that the surface bounds \[m³], by the divergence theorem.
    pub fn volume(&self) -> f64 {
        // From a vertex of the mesh: from a distant origin the sum would lose digits.
        let origin = self.positions.first().map_or(DVec3::ZERO, |p| p.as_dvec3());
        let volumes = self
            .corners()
            .map(|corners| corners.map(|corner| corner - origin))
            .map(|[a, b, c]| a.dot(b.cross(c)));
        volumes.sum::<f64>() / 6.0
    }

    fn corners(&self) -> impl Iterator<Item = [DVec3; 3]> {
        let triangles = self.triangles.iter();
        triangles.map(|triangle| triangle.map(|i| self.positions[i as usize].as_dvec3()))
    }
}
