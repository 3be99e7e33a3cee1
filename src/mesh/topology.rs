//! Connectivity of a mesh: whether it is closed, and the pseudonormals of its edges and vertices.

use std::collections::BTreeMap;

use glam::DVec3;

use super::soup::Soup;

/// An edge is sharp if the normals of its faces differ by more than 30°: its cosine.
const SHARP: f64 = 0.866;

/// One side of a triangle.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Edge {
    /// Unit mean of the normals of the triangles that meet here.
    pub(super) normal: DVec3,
    /// Ratio of the offset along `normal` to the offset from both adjacent faces.
    pub(super) mitre: f64,
    pub(super) is_border: bool,
    pub(super) is_sharp: bool,
}

#[derive(Debug, PartialEq)]
pub(super) struct Topology {
    /// Edges of every triangle, each from a corner to the next.
    pub(super) edges: Vec<[Edge; 3]>,
    /// Unit pseudonormals: means of the triangles' normals, weighted by the angles at the vertex.
    pub(super) vertex_normals: Vec<DVec3>,
    /// Whether a vertex is on a border.
    pub(super) on_border: Vec<bool>,
}

/// Key of an edge regardless of its direction: the smaller vertex first.
pub(super) fn key(a: u32, b: u32) -> (u32, u32) {
    (a.min(b), a.max(b))
}

pub(super) fn sides(corners: [u32; 3]) -> [(u32, u32); 3] {
    let [a, b, c] = corners;
    [(a, b), (b, c), (c, a)]
}

/// Edges of exactly one triangle.
pub(super) fn borders(soup: &Soup) -> impl Iterator<Item = (u32, u32)> {
    let mut counts: BTreeMap<(u32, u32), u32> = BTreeMap::new();
    for &corners in &soup.triangles {
        for (a, b) in sides(corners) {
            *counts.entry(key(a, b)).or_default() += 1;
        }
    }
    let alone = counts.into_iter().filter(|&(_, count)| count == 1);
    alone.map(|(edge, _)| edge)
}

/// The reason why the surface does not bound a solid, if it does not: every edge must occur equally often in both
/// directions.
pub(super) fn fault(soup: &Soup, tolerance: f64) -> Option<String> {
    // Number of triangles that have an edge in ascending and in descending order of its vertices.
    let mut passes: BTreeMap<(u32, u32), (u32, u32)> = BTreeMap::new();
    for &corners in &soup.triangles {
        for (a, b) in sides(corners) {
            let passed = passes.entry(key(a, b)).or_default();
            if a < b { passed.0 += 1 } else { passed.1 += 1 }
        }
    }
    let mut faults = passes.iter().filter(|(_, (up, down))| up != down);
    let (&(a, b), &(up, down)) = faults.next()?;
    let count = 1 + faults.count();
    let place = 0.5 * (soup.vertices[a as usize] + soup.vertices[b as usize]);
    let place = format!("({:.4}, {:.4}, {:.4}) m", place.x, place.y, place.z);
    Some(match up + down {
        1 => format!(
            "the surface is not closed: {count} of its edges belong to one triangle only, the first at {place}, and \
             vertices up to {tolerance:.1e} m (1/100 spacing) apart have been merged; close it (merge vertices by a \
             larger distance, fill holes), or write `side: Front` for a surface that is solid behind its triangles, \
             `side: Both` for a thin sheet"
        ),
        2 => format!(
            "two triangles that meet at {place} are wound opposite ways ({count} such edges); recalculate the normals, \
             or write `side: Both` for a thin sheet"
        ),
        all => format!(
            "{all} triangles meet at one edge at {place} ({count} such edges), so inside and outside are not clear; \
             export the solid's surface alone, or write `side: Both` for thin sheets"
        ),
    })
}

impl Topology {
    pub(super) fn new(soup: &Soup, normals: &[DVec3]) -> Self {
        let mut around: BTreeMap<(u32, u32), (DVec3, u32, f64)> = BTreeMap::new();
        let mut vertex_normals = vec![DVec3::ZERO; soup.vertices.len()];
        for (&corners, &normal) in soup.triangles.iter().zip(normals) {
            for (k, (a, b)) in sides(corners).into_iter().enumerate() {
                let (sum, count, likeness) =
                    around.entry(key(a, b)).or_insert((DVec3::ZERO, 0, 1.0));
                if *sum != DVec3::ZERO && normal != DVec3::ZERO {
                    *likeness = likeness.min(sum.normalize_or_zero().dot(normal));
                }
                *sum += normal;
                *count += 1;
                let at = |k: usize| soup.vertices[corners[k % 3] as usize];
                let (next, last) = (at(k + 1) - at(k), at(k + 2) - at(k));
                vertex_normals[a as usize] += normal * next.angle_between(last);
            }
        }
        let mut on_border = vec![false; soup.vertices.len()];
        for (&(a, b), &(_, count, _)) in &around {
            if count == 1 {
                on_border[a as usize] = true;
                on_border[b as usize] = true;
            }
        }
        let edges = soup
            .triangles
            .iter()
            .zip(normals)
            .map(|(&corners, &normal)| {
                sides(corners).map(|(a, b)| {
                    let (sum, count, likeness) = around[&key(a, b)];
                    Edge {
                        normal: sum.normalize_or(normal),
                        mitre: f64::from(count) / sum.length(),
                        is_border: count == 1,
                        is_sharp: likeness < SHARP,
                    }
                })
            });
        Self {
            edges: edges.collect(),
            vertex_normals: vertex_normals
                .into_iter()
                .map(|normal| normal.normalize_or(DVec3::Y))
                .collect(),
            on_border,
        }
    }

    /// The same for a subset of the triangles.
    pub(super) fn of(mut self, triangles: &[usize]) -> Self {
        self.edges = triangles
            .iter()
            .map(|&triangle| self.edges[triangle])
            .collect();
        self
    }
}
