//! Wavefront OBJ: vertices and faces, in double precision; all objects of a file as one surface.
//!
//! Option 2 was the crate `tobj`. It handles neither lines continued by `\` nor `#` after numbers, cuts every face as a
//! fan and does not report the line of an error. A boundary needs only two statements of the format.

use glam::DVec3;

use super::{
    polygon::triangulate,
    soup::Soup,
    text::{lines, point, text_of},
};

/// Statements for curved surfaces and for other files: without them the surface would be a different one.
const NOT_READ: [&str; 9] = [
    "surf", "curv", "curv2", "bzp", "bsp", "cdp", "cdc", "call", "csh",
];

/// All faces of a file. Fails with the line of an invalid face.
pub(super) fn read(bytes: &[u8]) -> Result<Soup, String> {
    let text = text_of(bytes);
    let mut soup = Soup::default();
    // Faces may refer to vertices that follow, so they are triangulated after all lines are read.
    let mut corners: Vec<u32> = Vec::new();
    let mut faces: Vec<(usize, usize)> = Vec::new();
    for (number, line) in statements(&text) {
        let mut words = line.split_whitespace();
        match words.next() {
            None => {}
            // Capitals are no statements of the format, but a surface without its faces would be another one.
            Some("v" | "V") => {
                let vertex = point(words).ok_or_else(|| {
                    format!(
                        "line {number}: a line `v` needs three numbers, it is `{}`",
                        line.trim()
                    )
                })?;
                soup.vertices.push(vertex);
            }
            Some("f" | "F" | "fo") => {
                for word in words {
                    let row = row(word, soup.vertices.len()).ok_or_else(|| {
                        format!(
                            "line {number}: a line `f` needs whole numbers of vertices, `{word}` \
                         is none"
                        )
                    })?;
                    corners.push(row);
                }
                faces.push((number, corners.len()));
            }
            Some(word) if NOT_READ.contains(&word) => {
                return Err(format!(
                    "line {number}: `{word}` is not supported, only polygons are; export the surface as polygons"
                ));
            }
            Some(word) if word.starts_with(|c: char| c.is_ascii_digit() || c == '-') => {
                return Err(format!(
                    "line {number} starts with `{word}`, which is not a statement; a continued line must end in \
                     `\\`"
                ));
            }
            // Texture coordinates, normals, groups, materials, points and lines.
            Some(_) => {}
        }
    }
    let mut start = 0;
    let mut polygon: Vec<DVec3> = Vec::new();
    for (number, end) in faces {
        let rows = &corners[start..end];
        start = end;
        if rows.len() < 3 {
            return Err(format!(
                "line {number}: a face has {} vertices; it needs three or more",
                rows.len()
            ));
        }
        polygon.clear();
        for &row in rows {
            let vertex = soup.vertices.get(row as usize).ok_or_else(|| {
                format!(
                    "line {number}: a face names a vertex that the file does not have (it has {})",
                    soup.vertices.len()
                )
            })?;
            polygon.push(*vertex);
        }
        let triangles =
            triangulate(&polygon).map_err(|fault| format!("line {number}: the face {fault}"))?;
        soup.triangles.extend(
            triangles
                .into_iter()
                .map(|corners| corners.map(|k| rows[k])),
        );
    }
    Ok(soup)
}

/// Statements of a file without their comments, with the numbers of their first lines. A line that ends in `\`
/// continues on the next.
fn statements(text: &str) -> impl Iterator<Item = (usize, String)> {
    let mut lines = lines(text);
    std::iter::from_fn(move || {
        let (number, mut line) = lines.next()?;
        let mut statement = String::new();
        loop {
            // A comment cannot be continued: a `\` that happens to end it would hide the next line of the surface.
            let comment = line.find('#');
            let part = line[..comment.unwrap_or(line.len())].trim_end();
            let Some(part) = part.strip_suffix('\\').filter(|_| comment.is_none()) else {
                statement.push_str(part);
                return Some((number, statement));
            };
            statement.push_str(part);
            statement.push(' ');
            let Some(next) = lines.next() else {
                return Some((number, statement));
            };
            line = next.1;
        }
    })
}

/// The row of a vertex from a word such as `7`, `7/1/3` or `-2//1`; only its first number counts. Negative numbers
/// count back from the last of the `known` vertices read so far.
fn row(word: &str, known: usize) -> Option<u32> {
    let number: i64 = word.split('/').next()?.parse().ok()?;
    let row = if number < 0 {
        number.checked_add(known as i64)?
    } else {
        number - 1
    };
    // An invalid row is reported once all vertices are known.
    Some(u32::try_from(row).unwrap_or(u32::MAX))
}
