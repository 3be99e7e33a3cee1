//! Triangulates polygons.
//!
//! If all corners are visible from the first, the polygon is cut as a fan. Others are triangulated in the coordinate
//! plane that is closest to theirs, with the feature `polygons`.

use glam::{DVec2, DVec3};

#[cfg(feature = "polygons")]
use super::delaunay::constrained;

/// Triangles of a polygon with three or more corners, as indices into them, with its winding; all corners are used.
/// Fails if the polygon crosses itself, because then it has no inside.
pub(super) fn triangulate(corners: &[DVec3]) -> Result<Vec<[usize; 3]>, String> {
    let fan = || (1..corners.len() - 1).map(|k| [0, k, k + 1]).collect();
    // Coordinates that are not finite are refused later, with the vertex.
    if corners.len() == 3 || !corners.iter().all(|corner| corner.is_finite()) {
        return Ok(fan());
    }
    let outline = flattened(corners);
    if is_seen_from_the_first(&outline) || is_straight(corners) {
        return Ok(fan());
    }
    #[cfg(feature = "polygons")]
    return constrained(&outline).map_err(|at| {
        let DVec3 { x, y, z } = corners[at];
        format!("crosses or touches itself at the vertex ({x}, {y}, {z}); cut it into triangles")
    });
    #[cfg(not(feature = "polygons"))]
    Err(
        "is no fan about its first corner, and this program was built without the feature `polygons`; build it with \
         that, or cut the face into triangles"
            .to_owned(),
    )
}

/// The corners in the plane of two coordinates, counter-clockwise, from the first on.
fn flattened(corners: &[DVec3]) -> Vec<DVec2> {
    let first = corners[0];
    // The area vector times two (Newell).
    let turns = corners[1..]
        .windows(2)
        .map(|pair| (pair[0] - first).cross(pair[1] - first));
    let area: DVec3 = turns.sum();
    let axis = area.abs().max_position();
    let (mut u, mut v) = ((axis + 1) % 3, (axis + 2) % 3);
    if area[axis] < 0.0 {
        (u, v) = (v, u);
    }
    corners
        .iter()
        .map(|&corner| corner - first)
        .map(|x| DVec2::new(x[u], x[v]))
        .collect()
}

/// Whether the directions from the first corner to the others turn monotonically, by less than half a turn.
fn is_seen_from_the_first(outline: &[DVec2]) -> bool {
    let first = outline[1];
    outline[1..]
        .windows(2)
        .all(|pair| pair[0].perp_dot(pair[1]) > 0.0 && first.perp_dot(pair[1]) > 0.0)
}

/// Whether the corners enclose no area, as in the faces of a collapsed solid: any triangulation will do.
fn is_straight(corners: &[DVec3]) -> bool {
    let arms = || corners[1..].iter().map(|&corner| corner - corners[0]);
    let longest = arms().max_by(|a, b| a.length_squared().total_cmp(&b.length_squared()));
    let longest = longest.unwrap_or_default();
    arms().all(|arm| arm.cross(longest).length() <= 1e-14 * longest.length_squared())
}

#[cfg(all(test, feature = "polygons"))]
mod tests {
    use super::*;

    fn area(corners: &[DVec3], triangles: &[[usize; 3]]) -> (DVec3, f64) {
        let each = triangles.iter().map(|t| {
            let [a, b, c] = t.map(|k| corners[k]);
            0.5 * (b - a).cross(c - a)
        });
        each.fold((DVec3::ZERO, 0.0), |(sum, size), area| {
            (sum + area, size + area.length())
        })
    }

    /// A comb, a star and an L with extra corners on their sides, in every orientation and from every first corner: the
    /// triangles cover them exactly once, all corners are used, and every side belongs to one triangle.
    #[test]
    fn concave_polygons_are_covered_once_with_all_their_corners() {
        let comb = [
            (0., 0.),
            (4., 0.),
            (4., 2.),
            (3., 2.),
            (3., 1.),
            (2., 1.),
            (2., 2.),
            (1., 2.),
            (1., 1.),
            (0., 1.),
        ];
        let l = [
            (0., 0.),
            (1., 0.),
            (2., 0.),
            (2., 0.5),
            (2., 1.),
            (1., 1.),
            (1., 1.5),
            (1., 2.),
            (0., 2.),
            (0., 1.),
        ];
        let star: Vec<(f64, f64)> = (0..14)
            .map(|k| {
                let (sin, cos) = (std::f64::consts::TAU * f64::from(k) / 14.0).sin_cos();
                let radius = if k % 2 == 0 { 1.0 } else { 0.2 };
                (radius * cos, radius * sin)
            })
            .collect();
        for (outline, size) in [(&comb[..], 6.0), (&l[..], 3.0), (&star[..], f64::NAN)] {
            for start in 0..outline.len() {
                for turn in 0..7 {
                    let turn = glam::DQuat::from_euler(
                        glam::EulerRot::XYZ,
                        f64::from(turn),
                        0.7 * f64::from(turn),
                        0.0,
                    );
                    let corners: Vec<DVec3> = (0..outline.len())
                        .map(|k| outline[(start + k) % outline.len()])
                        .map(|(x, y)| turn * DVec3::new(x, y, 0.0) + DVec3::new(3.0, 4e3, -1.0))
                        .collect();
                    let triangles = triangulate(&corners).expect("a simple polygon");
                    assert_eq!(triangles.len(), corners.len() - 2);
                    let (sum, total) = area(&corners, &triangles);
                    assert!(
                        (sum.length() - total).abs() < 1e-9 * total,
                        "a triangle is turned over"
                    );
                    assert!(
                        sum.dot(turn * DVec3::Z) > 0.0
                            && (size.is_nan() || (total - size).abs() < 1e-9)
                    );
                    for k in 0..corners.len() {
                        let next = (k + 1) % corners.len();
                        let sides = triangles
                            .iter()
                            .flat_map(|&[a, b, c]| [(a, b), (b, c), (c, a)]);
                        assert_eq!(sides.filter(|side| *side == (k, next)).count(), 1);
                    }
                }
            }
        }
    }

    #[test]
    fn a_hole_that_a_cut_leads_to_stays_free() {
        let square = |low: f64, high: f64| {
            [
                (low, low),
                (high, low),
                (high, high),
                (low, high),
                (low, low),
            ]
        };
        let mut hole = square(1.0, 2.0);
        hole.reverse();
        let corners: Vec<DVec3> = square(0.0, 3.0)
            .into_iter()
            .chain(hole)
            .map(|(x, y)| DVec3::new(x, y, 1.0))
            .collect();
        let triangles = triangulate(&corners).expect("a polygon with a cut");
        let (sum, total) = area(&corners, &triangles);
        assert!(
            (sum.z - 8.0).abs() < 1e-12 && (total - 8.0).abs() < 1e-12,
            "{sum} {total}"
        );
    }

    #[test]
    fn polygons_that_cross_themselves_are_refused() {
        let bow = [(0., 0.), (1., 1.), (1., 0.), (0., 1.)];
        let pentagram = [
            (1., 0.),
            (-0.8, 0.6),
            (0.3, -0.95),
            (0.3, 0.95),
            (-0.8, -0.6),
        ];
        let twice = [(0., 0.), (1., 0.), (0., 1.), (0., 0.), (1., 0.), (0., 1.)];
        for outline in [&bow[..], &pentagram[..], &twice[..]] {
            let corners: Vec<DVec3> = outline
                .iter()
                .map(|&(x, y)| DVec3::new(x, y, 0.0))
                .collect();
            assert!(triangulate(&corners).is_err(), "{outline:?}");
        }
        let line: Vec<DVec3> = [0.0, 1.0, 3.0, 2.0].map(|x| DVec3::new(x, x, -x)).into();
        assert_eq!(triangulate(&line).expect("a line").len(), 2);
    }
}
