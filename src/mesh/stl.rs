//! STL, ASCII and binary; all solids of a file as one surface.
//!
//! Normals are ignored: many programs write zeros or NaN. Option 2 was the crate `stl_io`, which stops at the first
//! `endsolid`, refuses a solid without a name, and reads ASCII files in single precision.

use std::iter::Peekable;
use std::str::SplitWhitespace;

use glam::{DVec3, Vec3};

use super::{
    soup::Soup,
    text::{lines, point, text_of},
    weld::few_enough,
};

/// Size of a binary file's header and count, and of one of its triangles \[bytes].
const HEADER: usize = 84;
const TRIANGLE: usize = 50;

/// All triangles of a file.
pub(super) fn read(bytes: &[u8]) -> Result<Soup, String> {
    // Some programs start binary files with `solid`, too. The length of the file decides: it must match the count in
    // bytes 80 to 83.
    let count = bytes.get(80..HEADER).map_or(0, |count| {
        u32::from_le_bytes([count[0], count[1], count[2], count[3]]) as usize
    });
    let length = HEADER + count * TRIANGLE;
    let rest = bytes.get(length..);
    let is_binary = count > 0 && rest.is_some_and(is_padding);
    let head = text_of(&bytes[..bytes.len().min(1024)]);
    let says_solid = head
        .trim_start()
        .get(..5)
        .is_some_and(|word| word.eq_ignore_ascii_case("solid"));
    if says_solid && !is_binary {
        return text(&text_of(bytes));
    }
    match rest {
        None => Err(format!(
            "it is no STL file, or cut short: {} bytes, where a header and {count} triangles take {length}; export it \
             again",
            bytes.len().max(1)
        )),
        Some(rest) if !is_padding(rest) => Err(format!(
            "{} bytes follow its {count} triangles; a file holds one list of triangles, so write one file each",
            rest.len()
        )),
        // Before memory is taken for them.
        Some(_) => few_enough(count).map(|()| binary(&bytes[HEADER..length])),
    }
}

fn is_padding(rest: &[u8]) -> bool {
    rest.iter()
        .all(|byte| matches!(byte, 0 | b' ' | b'\r' | b'\n'))
}

/// Triangles of 50 bytes: normal, three corners in single precision, an unused word.
fn binary(bytes: &[u8]) -> Soup {
    let mut soup = Soup::default();
    for triangle in bytes.as_chunks::<TRIANGLE>().0 {
        let first = soup.vertices.len() as u32;
        for corner in triangle[12..48].as_chunks::<12>().0 {
            let coordinate = |k: usize| {
                let at = 4 * k;
                f32::from_le_bytes([corner[at], corner[at + 1], corner[at + 2], corner[at + 3]])
            };
            let corner = Vec3::new(coordinate(0), coordinate(1), coordinate(2));
            soup.vertices.push(corner.as_dvec3());
        }
        soup.triangles.push([first, first + 1, first + 2]);
    }
    soup
}

/// Any number of `solid` \[name] facets `endsolid` \[name]. A facet is `facet normal x y z outer loop`, three times
/// `vertex x y z`, `endloop endfacet`. Lines may break anywhere except within names, which end at the end of their
/// line.
fn text(text: &str) -> Result<Soup, String> {
    let mut soup = Soup::default();
    // Corners of the current facet; first line of the current solid.
    let mut facet: Option<Vec<DVec3>> = None;
    let mut solid: Option<usize> = None;
    for (number, line) in lines(text) {
        let mut words = line.split_whitespace().peekable();
        while let Some(word) = words.next() {
            match (word.to_ascii_lowercase().as_str(), &mut facet) {
                ("solid", None) if solid.is_none() => {
                    solid = Some(number);
                    skip_name(&mut words);
                }
                ("endsolid", None) if solid.is_some() => {
                    solid = None;
                    skip_name(&mut words);
                }
                ("facet", None) if solid.is_some() => {
                    facet = Some(Vec::new());
                    if words
                        .next_if(|word| word.eq_ignore_ascii_case("normal"))
                        .is_some()
                    {
                        // Three numbers of the normal, or whatever a program wrote in their place.
                        for _ in 0..3 {
                            words.next_if(|word| !word.eq_ignore_ascii_case("outer"));
                        }
                    }
                }
                ("outer" | "loop" | "endloop", Some(_)) => {}
                ("vertex", Some(corners)) => {
                    let corner = point(&mut words).ok_or_else(|| {
                        format!(
                            "line {number}: `vertex` needs three numbers, it is `{}`",
                            line.trim()
                        )
                    })?;
                    corners.push(corner);
                }
                ("endfacet", Some(corners)) => {
                    let [a, b, c] = corners[..] else {
                        return Err(format!(
                            "line {number}: a facet has {} vertices; it needs three",
                            corners.len()
                        ));
                    };
                    let first = soup.vertices.len() as u32;
                    soup.vertices.extend([a, b, c]);
                    soup.triangles.push([first, first + 1, first + 2]);
                    facet = None;
                }
                _ => {
                    return Err(format!(
                        "it is no STL file: `{word}` in line {number} is out of place; export it again"
                    ));
                }
            }
        }
    }
    match solid {
        Some(line) => Err(format!(
            "it is cut short: the solid of line {line} has no `endsolid`; export it again"
        )),
        None => Ok(soup),
    }
}

/// A name extends to the end of its line; in a file of a single line, to the next statement.
fn skip_name(words: &mut Peekable<SplitWhitespace>) {
    let ahead: Vec<&str> = words.clone().collect();
    let is = |word: &str, one: &str| word.eq_ignore_ascii_case(one);
    // A name may have these two words; a facet has a number behind them, which some programs write as `-nan(ind)`.
    let is_number = |word: &str| {
        let word = word.to_ascii_lowercase();
        word.parse::<f64>().is_ok() || word.contains("nan") || word.contains('#')
    };
    let goes_on = ahead
        .windows(3)
        .any(|words| is(words[0], "facet") && is(words[1], "normal") && is_number(words[2]));
    let ends = |word: &str| {
        goes_on
            && ["facet", "endsolid", "solid"]
                .iter()
                .any(|next| is(word, next))
    };
    while words.next_if(|word| !ends(word)).is_some() {}
}
