//! Meshes for tests: shapes with known surfaces.

#![allow(
    dead_code,
    reason = "every crate that has this module uses a part of it"
)]

use std::fmt::Write;
use std::path::PathBuf;

use glam::Vec3;

/// A surface of polygons.
#[derive(Debug, Clone, Default)]
pub(crate) struct Surface {
    pub(crate) vertices: Vec<Vec3>,
    /// Counter-clockwise seen from outside.
    pub(crate) faces: Vec<Vec<usize>>,
}

impl Surface {
    /// The box `min`–`max`, six squares.
    pub(crate) fn block(min: Vec3, max: Vec3) -> Self {
        let pick = |i: usize, axis: usize| {
            if i >> axis & 1 == 0 {
                min[axis]
            } else {
                max[axis]
            }
        };
        Self {
            vertices: (0..8)
                .map(|i| Vec3::new(pick(i, 0), pick(i, 1), pick(i, 2)))
                .collect(),
            faces: [
                [0, 4, 6, 2],
                [1, 3, 7, 5],
                [0, 1, 5, 4],
                [2, 6, 7, 3],
                [0, 2, 3, 1],
                [4, 5, 7, 6],
            ]
            .map(Vec::from)
            .into(),
        }
    }

    /// A polygon in the plane, counter-clockwise, extruded along z. Its ends are fans from the first vertex.
    pub(crate) fn prism(outline: &[(f32, f32)], depth: f32) -> Self {
        let n = outline.len();
        let layer = |z: f32| outline.iter().map(move |&(x, y)| Vec3::new(x, y, z));
        let mut faces: Vec<Vec<usize>> = (0..n)
            .map(|k| vec![k, (k + 1) % n, n + (k + 1) % n, n + k])
            .collect();
        for k in 1..n - 1 {
            faces.push(vec![0, k + 1, k]);
            faces.push(vec![n, n + k, n + k + 1]);
        }
        Self {
            vertices: layer(0.0).chain(layer(depth)).collect(),
            faces,
        }
    }

    /// A profile (radius, height) rotated about the y axis, from one point on the axis to another.
    pub(crate) fn turned(profile: &[(f32, f32)], count: usize) -> Self {
        let mut surface = Self::default();
        let mut rings = Vec::new();
        for &(radius, height) in profile {
            let first = surface.vertices.len();
            let points = if radius == 0.0 { 1 } else { count };
            rings.push((first, points));
            for k in 0..points {
                let (sin, cos) = (std::f32::consts::TAU * k as f32 / count as f32).sin_cos();
                surface
                    .vertices
                    .push(Vec3::new(radius * cos, height, radius * sin));
            }
        }
        for pair in rings.windows(2) {
            let [(a, m), (b, n)] = [pair[0], pair[1]];
            for k in 0..count {
                let next = (k + 1) % count;
                let mut face = vec![a + k % m, b + k % n, b + next % n, a + next % m];
                face.dedup();
                if face.first() == face.last() {
                    face.pop();
                }
                surface.faces.push(face);
            }
        }
        surface
    }

    /// As a Wavefront OBJ file.
    pub(crate) fn obj(&self) -> String {
        let mut text = String::new();
        for x in &self.vertices {
            writeln!(text, "v {} {} {}", x.x, x.y, x.z).expect("a string");
        }
        for face in &self.faces {
            text.push('f');
            for row in face {
                write!(text, " {}", row + 1).expect("a string");
            }
            text.push('\n');
        }
        text
    }

    /// Triangles, as fans.
    pub(crate) fn triangles(&self) -> Vec<[Vec3; 3]> {
        let mut triangles = Vec::new();
        for face in &self.faces {
            for k in 1..face.len() - 1 {
                triangles.push([face[0], face[k], face[k + 1]].map(|row| self.vertices[row]));
            }
        }
        triangles
    }

    pub(crate) fn stl_text(&self) -> String {
        let mut text = "solid s\n".to_owned();
        for corners in self.triangles() {
            text.push_str("facet normal 0 0 0\nouter loop\n");
            for x in corners {
                writeln!(text, "vertex {} {} {}", x.x, x.y, x.z).expect("a string");
            }
            text.push_str("endloop\nendfacet\n");
        }
        text + "endsolid s\n"
    }

    pub(crate) fn stl_binary(&self, header: &[u8]) -> Vec<u8> {
        let mut bytes = header.to_vec();
        bytes.resize(80, b' ');
        let triangles = self.triangles();
        bytes.extend((triangles.len() as u32).to_le_bytes());
        for corners in triangles {
            bytes.extend([0; 12]);
            for x in corners {
                bytes.extend(x.to_array().iter().flat_map(|x| x.to_le_bytes()));
            }
            bytes.extend([0; 2]);
        }
        bytes
    }
}

/// A folder of mesh files that is removed with its owner.
pub(crate) struct Files(tempfile::TempDir);

impl Files {
    pub(crate) fn new() -> Self {
        Self(tempfile::tempdir().expect("a folder"))
    }

    /// Writes a file and returns its path in the notation of a scene.
    pub(crate) fn put(&self, name: &str, contents: impl AsRef<[u8]>) -> String {
        let path: PathBuf = self.0.path().join(name);
        std::fs::write(&path, contents).expect("a file");
        path.display().to_string()
    }
}
