//! Constrained Delaunay triangulation of polygons, by `spade`.
//!
//! Ear clipping (`earcutr`) was the other option. It drops corners on straight sides; a neighbouring face that has such
//! a corner would then not be connected to this one.

use std::collections::{BTreeMap, VecDeque};

use glam::DVec2;
use spade::{ConstrainedDelaunayTriangulation, Point2, Triangulation};

type Cdt = ConstrainedDelaunayTriangulation<Point2<f64>>;

/// Constrained Delaunay triangulation. Fails with the first corner of an invalid side.
pub(super) fn constrained(outline: &[DVec2]) -> Result<Vec<[usize; 3]>, usize> {
    let size = outline
        .iter()
        .fold(0.0_f64, |size, point| size.max(point.abs().max_element()));
    let mut cdt = Cdt::new();
    // For each distinct place, its first corner; for each corner, its place.
    let (mut first, mut places) = (Vec::new(), Vec::new());
    for (row, point) in outline.iter().enumerate() {
        // The crate refuses magnitudes below 1e-40.
        let [x, y] = (*point / size)
            .to_array()
            .map(|x| if x.abs() < 1e-30 { 0.0 } else { x });
        let place = cdt.insert(Point2::new(x, y)).map_err(|_| row)?;
        if place.index() == first.len() {
            first.push(row);
        }
        places.push(place);
    }
    // Net number of times that the outline runs from one place to another: a cut to a hole is passed in both
    // directions.
    let mut passes: BTreeMap<(usize, usize), i32> = BTreeMap::new();
    for row in 0..places.len() {
        let (from, to) = (places[row], places[(row + 1) % places.len()]);
        if from == to {
            continue;
        }
        if !cdt.can_add_constraint(from, to) {
            return Err(row);
        }
        cdt.add_constraint(from, to);
        // If the constraint does not exist, the side passes through another corner.
        if !cdt.exists_constraint(from, to) {
            return Err(row);
        }
        *passes.entry((from.index(), to.index())).or_default() += 1;
        *passes.entry((to.index(), from.index())).or_default() -= 1;
    }
    let triangles = within(&cdt, &passes, &first)?;
    // A bow tie with equal halves has no area, and no plane of its own.
    if triangles.is_empty() {
        return Err(0);
    }
    Ok(triangles)
}

/// The triangles with winding number 1. Fails with a corner where the outline winds differently.
fn within(
    cdt: &Cdt,
    passes: &BTreeMap<(usize, usize), i32>,
    first: &[usize],
) -> Result<Vec<[usize; 3]>, usize> {
    let mut turns: Vec<Option<i32>> = vec![None; cdt.num_all_faces()];
    let outer = cdt.outer_face();
    turns[outer.index()] = Some(0);
    let mut open: VecDeque<_> = cdt.convex_hull().map(|edge| (edge, 0)).collect();
    let mut triangles = Vec::new();
    while let Some((edge, beyond)) = open.pop_front() {
        // One face of each edge is already classified, the other may not be; the inner face is on the left.
        let edge = if edge.face() == outer {
            edge.rev()
        } else {
            edge
        };
        let Some(face) = edge.face().as_inner() else {
            continue;
        };
        if turns[face.index()].is_some() {
            continue;
        }
        let passed = (edge.from().index(), edge.to().index());
        let here = beyond + passes.get(&passed).copied().unwrap_or(0);
        turns[face.index()] = Some(here);
        let corners = face.vertices().map(|vertex| first[vertex.index()]);
        match here {
            0 => {}
            1 => triangles.push(corners),
            _ => return Err(corners[0]),
        }
        for side in face.adjacent_edges() {
            open.push_back((side.rev(), here));
        }
    }
    Ok(triangles)
}
