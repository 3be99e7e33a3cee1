//! Merges coincident vertices.
//!
//! First, vertices with identical coordinates are merged: STL repeats them for every triangle. Then border vertices
//! closer than a tolerance are merged, because many programs write the corners of a seam with different last digits.
//! Only borders are searched, so that the two sides of a closed plate stay separate, however thin it is.

use std::collections::{BTreeMap, HashMap, HashSet};

use glam::{DVec3, I64Vec3};

use super::{soup::Soup, topology::borders};

/// Meshes with more triangles are made for rendering.
const MAX_TRIANGLES: usize = 5_000_000;

/// Welds a mesh. Collapsed and duplicate triangles, and unused vertices, are removed. `tolerance` is in metres.
pub(super) fn weld(soup: Soup, tolerance: f64) -> Result<Soup, String> {
    let count = soup.triangles.len();
    if count == 0 {
        return Err("it has no triangle; export the surface with its faces".to_owned());
    }
    few_enough(count)?;
    let mut welded = close_seams(same_places(soup)?, tolerance);
    let mut known = HashSet::with_capacity(welded.triangles.len());
    welded
        .triangles
        .retain(|&corners| known.insert(from_the_least(corners)));
    if welded.triangles.is_empty() {
        return Err(format!(
            "none of its {count} triangles has an area; export the surface with its faces"
        ));
    }
    Ok(welded)
}

/// Refuses more triangles than are read.
pub(super) fn few_enough(count: usize) -> Result<(), String> {
    if count <= MAX_TRIANGLES {
        return Ok(());
    }
    Err(format!(
        "it has {count} triangles; at most {MAX_TRIANGLES} are read, so decimate it to triangles of about the spacing"
    ))
}

fn same_places(soup: Soup) -> Result<Soup, String> {
    let mut known = HashMap::with_capacity(soup.vertices.len());
    let mut welded = Soup::default();
    for corners in soup.triangles {
        let mut triangle = [0; 3];
        for (corner, row) in corners.into_iter().zip(&mut triangle) {
            let vertex = soup.vertices[corner as usize];
            if !vertex.is_finite() {
                return Err(format!(
                    "the vertex {vertex} is not finite; coordinates must be numbers"
                ));
            }
            // Adding 0 turns −0 into +0.
            let key = (vertex + 0.0).to_array().map(f64::to_bits);
            let next = welded.vertices.len() as u32;
            *row = *known.entry(key).or_insert(next);
            if *row == next {
                welded.vertices.push(vertex);
            }
        }
        push(&mut welded.triangles, triangle);
    }
    Ok(welded)
}

/// Replaces border vertices by the first one within the tolerance.
fn close_seams(mut soup: Soup, tolerance: f64) -> Soup {
    let mut on_border: Vec<u32> = borders(&soup).flat_map(|(a, b)| [a, b]).collect();
    on_border.sort_unstable();
    on_border.dedup();
    let cell = |point: DVec3| (point / tolerance).floor().as_i64vec3();
    let mut cells: HashMap<I64Vec3, Vec<u32>> = HashMap::new();
    let mut moved: BTreeMap<u32, u32> = BTreeMap::new();
    for row in on_border {
        let point = soup.vertices[row as usize];
        let around = (0..27).map(|k| I64Vec3::new(k % 3 - 1, k / 3 % 3 - 1, k / 9 - 1));
        let known = around
            .filter_map(|offset| cells.get(&cell(point).saturating_add(offset)))
            .flatten()
            .map(|&other| (point.distance(soup.vertices[other as usize]), other))
            .filter(|&(distance, _)| distance <= tolerance)
            .min_by(|a, b| a.0.total_cmp(&b.0));
        match known {
            Some((_, other)) => {
                moved.insert(row, other);
            }
            None => cells.entry(cell(point)).or_default().push(row),
        }
    }
    if moved.is_empty() {
        return soup;
    }
    let mut triangles = Vec::with_capacity(soup.triangles.len());
    for corners in soup.triangles {
        push(
            &mut triangles,
            corners.map(|row| moved.get(&row).copied().unwrap_or(row)),
        );
    }
    soup.triangles = triangles;
    soup
}

/// Removes pairs of triangles back to back, such as the wall that two solids share.
pub(super) fn cancel(triangles: &mut Vec<[u32; 3]>) {
    let known: HashSet<[u32; 3]> = triangles.iter().copied().map(from_the_least).collect();
    triangles.retain(|&[a, b, c]| !known.contains(&from_the_least([a, c, b])));
}

/// The same triangle with the same winding, its smallest index first.
fn from_the_least([a, b, c]: [u32; 3]) -> [u32; 3] {
    if a < b && a < c {
        [a, b, c]
    } else if b < c {
        [b, c, a]
    } else {
        [c, a, b]
    }
}

fn push(triangles: &mut Vec<[u32; 3]>, [a, b, c]: [u32; 3]) {
    if a != b && b != c && c != a {
        triangles.push([a, b, c]);
    }
}
