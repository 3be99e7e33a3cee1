//! Files into triangles: Wavefront OBJ and STL, binary or text.

use std::io::Cursor;
use std::path::Path;

use glam::{DVec3, Vec3};

use super::{MeshError, Soup};
use crate::input::read_bytes;

/// Header and count of a binary STL file, and a triangle in it [bytes].
const STL_HEADER: usize = 84;
const STL_TRIANGLE: usize = 50;

pub(super) fn read(file: &Path) -> Result<Soup, MeshError> {
    let refuse = |message: String| MeshError::Unusable {
        file: file.to_owned(),
        message,
    };
    let extension = file.extension().unwrap_or_default().to_ascii_lowercase();
    let parse = match extension.to_str() {
        Some("obj") => obj,
        Some("stl") => stl,
        _ => {
            return Err(refuse(
                "its name ends neither in .obj nor in .stl, which are the formats that can be read"
                    .to_owned(),
            ));
        }
    };
    let bytes = read_bytes(file).map_err(|source| MeshError::Unreadable {
        file: file.to_owned(),
        source,
    })?;
    parse(bytes).map_err(refuse)
}

/// All objects of the file as one.
fn obj(bytes: Vec<u8>) -> Result<Soup, String> {
    let text = String::from_utf8_lossy(&bytes);
    // Only positions and faces matter. What is left out cannot be wrong: the reader would refuse a file for a bad
    // texture index, and overflows on a negative one that is out of range.
    let mut lines = String::with_capacity(text.len());
    for line in text.lines() {
        let mut words = line.split_whitespace();
        match words.next() {
            Some("v") => lines.push_str(line),
            Some("f") => {
                lines.push('f');
                for word in words {
                    lines.push(' ');
                    lines.push_str(word.split('/').next().unwrap_or_default());
                }
            }
            _ => continue,
        }
        lines.push('\n');
    }
    let options = tobj::LoadOptions {
        triangulate: true,
        ignore_points: true,
        ignore_lines: true,
        ..Default::default()
    };
    let nothing = |_: &Path| Ok(Default::default());
    let (models, _) =
        tobj::load_obj_buf(&mut Cursor::new(lines), &options, nothing).map_err(|error| {
            let hint = match error {
                tobj::LoadError::FaceVertexOutOfBounds => {
                    "a face names a vertex that the file does not have"
                }
                tobj::LoadError::PositionParseError => "a line `v` needs three numbers",
                tobj::LoadError::FaceParseError => "a line `f` needs whole numbers of vertices",
                _ => "the text is no Wavefront OBJ",
            };
            format!("{hint} ({error})")
        })?;
    let mut soup = Soup::default();
    for model in models {
        let first = soup.vertices.len() as u32;
        let positions = model.mesh.positions.as_chunks::<3>().0;
        soup.vertices
            .extend(positions.iter().map(|x| Vec3::from(*x).as_dvec3()));
        let triangles = model.mesh.indices.as_chunks::<3>().0;
        soup.triangles
            .extend(triangles.iter().map(|rows| rows.map(|row| first + row)));
    }
    Ok(soup)
}

fn stl(mut bytes: Vec<u8>) -> Result<Soup, String> {
    // Some programs start binary files with `solid`, too, which the reader takes for text.
    let count = bytes.get(80..STL_HEADER).map_or(0, |count| {
        u32::from_le_bytes([count[0], count[1], count[2], count[3]]) as usize
    });
    if count > 0 && bytes.len() == STL_HEADER + count * STL_TRIANGLE {
        bytes[0] = 0;
    }
    let explain = |error: std::io::Error| {
        format!("it is no STL file, or cut short ({error}); export it again")
    };
    let mut cursor = Cursor::new(bytes);
    let reader = stl_io::create_stl_reader(&mut cursor).map_err(explain)?;
    let mut soup = Soup::default();
    for triangle in reader {
        let first = soup.vertices.len() as u32;
        let vertices = triangle.map_err(explain)?.vertices;
        soup.vertices
            .extend(vertices.map(|x| DVec3::from(x.0.map(f64::from))));
        soup.triangles.push([first, first + 1, first + 2]);
    }
    Ok(soup)
}
