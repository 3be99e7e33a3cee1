//! Files of surfaces: PLY, OBJ, VTK.

use std::io::Write;
use std::path::Path;

use glam::Vec3;

use super::SurfaceMesh;
use crate::output::OutputError;
use crate::output::atomic::write_atomically;
use crate::output::error::equal_columns;
use crate::output::grid::{Cells, Grid, bytes, vectors};

/// File format of a surface.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum SurfaceFormat {
    /// Stanford PLY, binary little endian, with normals nx, ny, nz and velocities vx, vy, vz \[m/s].
    Ply,
    /// Wavefront OBJ, with normals; it has no place for velocities.
    Obj,
    /// VTK XML unstructured grid of triangles, with normals and velocities; ParaView opens it.
    Vtu,
}

impl SurfaceFormat {
    /// Suffix of its files, without the dot.
    pub fn extension(self) -> &'static str {
        match self {
            Self::Ply => "ply",
            Self::Obj => "obj",
            Self::Vtu => "vtu",
        }
    }
}

impl SurfaceMesh {
    /// Writes the surface in a format; `path` should end in that format's [`extension`](SurfaceFormat::extension).
    ///
    /// # Errors
    /// If the lists of vertices differ in length, there are more than 2³¹ − 1 vertices or corners, or the operating
    /// system reports an error.
    pub fn write(&self, path: &Path, format: SurfaceFormat) -> Result<(), OutputError> {
        self.check()?;
        write_atomically(path, |out| match format {
            SurfaceFormat::Ply => self.write_ply(out),
            SurfaceFormat::Obj => self.write_obj(out),
            SurfaceFormat::Vtu => self.grid().write(out),
        })
    }

    fn check(&self) -> Result<(), OutputError> {
        let expected = self.positions.len();
        let columns = [
            ("normal", self.normals.len()),
            ("velocity", self.velocities.len()),
        ];
        equal_columns(expected, columns)?;
        let most = expected.max(3 * self.triangles.len());
        if i32::try_from(most).is_err() {
            return Err(OutputError::TooManyVertices { vertices: most });
        }
        Ok(())
    }

    fn write_ply(&self, out: &mut impl Write) -> std::io::Result<()> {
        let names = ["x", "y", "z", "nx", "ny", "nz", "vx", "vy", "vz"];
        let properties = names.map(|name| format!("property float {name}\n"));
        write!(
            out,
            "ply\nformat binary_little_endian 1.0\ncomment time_s {}\ncomment step {}\nelement vertex {}\n{}\
             element face {}\nproperty list uchar int vertex_indices\nend_header\n",
            self.time,
            self.step,
            self.positions.len(),
            properties.concat(),
            self.triangles.len(),
        )?;
        let vertices = self.positions.iter().zip(&self.normals);
        for ((position, normal), velocity) in vertices.zip(&self.velocities) {
            for vector in [position, normal, velocity] {
                out.write_all(&bytes(*vector))?;
            }
        }
        for triangle in &self.triangles {
            out.write_all(&[3])?;
            for corner in triangle {
                out.write_all(&corner.to_le_bytes())?;
            }
        }
        Ok(())
    }

    fn write_obj(&self, out: &mut impl Write) -> std::io::Result<()> {
        writeln!(out, "# time {} s, step {}", self.time, self.step)?;
        for Vec3 { x, y, z } in &self.positions {
            writeln!(out, "v {x} {y} {z}")?;
        }
        for Vec3 { x, y, z } in &self.normals {
            writeln!(out, "vn {x} {y} {z}")?;
        }
        for triangle in &self.triangles {
            // Vertices are counted from 1.
            let [a, b, c] = triangle.map(|corner| corner + 1);
            writeln!(out, "f {a}//{a} {b}//{b} {c}//{c}")?;
        }
        Ok(())
    }

    fn grid(&self) -> Grid<'_> {
        Grid {
            time: self.time,
            step: self.step,
            rows: self.positions.len(),
            points: vectors("position", &self.positions),
            cells: Cells::Triangles(&self.triangles),
            data: vec![
                vectors("velocity", &self.velocities),
                vectors("normal", &self.normals),
            ],
            shown_first: " Vectors=\"velocity\" Normals=\"normal\"",
        }
    }
}
