//! Wavefront OBJ: vertices and faces, in double precision; all objects of a file as one surface.
//!
//! Option 2 was the crate `tobj`, which knows neither lines that `\` continues nor `#` after numbers, cuts every face
//! as a fan and does not say in which line an error is. What a boundary needs of the format is two of its statements.

use glam::DVec3;

use super::{
    polygon::triangulate,
    soup::Soup,
    text::{lines, point, text_of},
};

/// Statements of surfaces that are no polygons, or of other files: a file without them would be another surface.
const NOT_READ: [&str; 9] = [
    "surf", "curv", "curv2", "bzp", "bsp", "cdp", "cdc", "call", "csh",
];

/// All faces of a file. Fails with the line where a face cannot be.
pub(super) fn read(bytes: &[u8]) -> Result<Soup, String> {
    let text = text_of(bytes);
    let mut soup = Soup::default();
    // Faces may name vertices that follow, so they are cut when all are known.
    let mut corners: Vec<u32> = Vec::new();
    let mut faces: Vec<(usize, usize)> = Vec::new();
    for (number, line) in statements(&text) {
        let mut words = line.split_whitespace();
        match words.next() {
            None => {}
            Some("v") => {
                let vertex = point(words).ok_or_else(|| {
                    format!(
                        "line {number}: a line `v` needs three numbers, it is `{}`",
                        line.trim()
                    )
                })?;
                soup.vertices.push(vertex);
            }
            Some("f" | "fo") => {
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
                    "line {number}: `{word}` is not read, polygons alone are; export the surface as polygons"
                ));
            }
            Some(word) if word.starts_with(|c: char| c.is_ascii_digit() || c == '-') => {
                return Err(format!(
                    "line {number} starts with `{word}`, which belongs to no statement; a line that goes on ends in \
                     `\\`"
                ));
            }
            // Texture, normals, groups, materials, points and lines.
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

/// Statements of a file without their comments, with the numbers of their first lines: a line that ends in `\` goes on
/// in the next.
fn statements(text: &str) -> impl Iterator<Item = (usize, String)> {
    let mut lines = lines(text);
    std::iter::from_fn(move || {
        let (number, mut line) = lines.next()?;
        let mut statement = String::new();
        loop {
            // A comment cannot be continued: what ends in `\` by chance would take a line of the surface with it.
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

/// The row of a vertex from a word such as `7`, `7/1/3` or `-2//1`, of which only the first number counts. Negative
/// numbers count back from the last of `known` vertices.
fn row(word: &str, known: usize) -> Option<u32> {
    let number: i64 = word.split('/').next()?.parse().ok()?;
    let row = if number < 0 {
        number.checked_add(known as i64)?
    } else {
        number - 1
    };
    // A row that cannot be is found out where all vertices are known.
    Some(u32::try_from(row).unwrap_or(u32::MAX))
}
