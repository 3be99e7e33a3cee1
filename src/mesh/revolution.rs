//! Surfaces of revolution: a profile of (radius, height) goes round the y axis.

use std::f64::consts::TAU;

use glam::DVec3;

use super::{error::MeshError, place::Place, side::MeshSide, soup::Soup, surface::Mesh};

/// Fewest triangles round the axis, and most.
const ROUND: (f64, f64) = (16.0, 2048.0);

impl Mesh {
    /// The surface of a profile \[m], for particles at a spacing \[m]. Fails if the profile is none, or does not bound
    /// a solid where `side` needs one.
    pub(crate) fn of_revolution(
        profile: &[[f32; 2]],
        place: Place,
        side: MeshSide,
        spacing: f32,
    ) -> Result<Self, MeshError> {
        let refuse = MeshError::Surface;
        let points: Vec<[f64; 2]> = profile.iter().map(|x| x.map(f64::from)).collect();
        check(&points, side).map_err(refuse)?;
        let mut soup = turned(&points, f64::from(spacing));
        place.put(&mut soup.vertices);
        Self::of_soup(soup, side, spacing).map_err(refuse)
    }
}

fn check(points: &[[f64; 2]], side: MeshSide) -> Result<(), String> {
    if points.len() < 2 {
        return Err(format!(
            "the profile has {} points; it needs two or more (radius, height)",
            points.len()
        ));
    }
    for (k, [radius, height]) in points.iter().enumerate() {
        if *radius < 0.0 {
            return Err(format!(
                "the radius of point {k} of the profile is {radius} m; it must be 0, on the axis, or above"
            ));
        }
        if k > 0 && points[k - 1] == [*radius, *height] {
            return Err(format!(
                "points {} and {k} of the profile are the same, ({radius}, {height}) m; leave one out",
                k - 1
            ));
        }
        let is_end = k == 0 || k + 1 == points.len();
        if *radius == 0.0 && !is_end {
            return Err(format!(
                "point {k} of the profile is on the axis, where only its ends may be; make two surfaces of it"
            ));
        }
    }
    if points.len() == 2 && points.iter().all(|point| point[0] == 0.0) {
        return Err("the profile lies on the axis; give it a radius".to_owned());
    }
    let (first, last) = (points[0], points[points.len() - 1]);
    let closed = (first[0] == 0.0 && last[0] == 0.0) || first == last;
    if !closed && matches!(side, MeshSide::Outside | MeshSide::Inside) {
        return Err(format!(
            "the profile begins at ({}, {}) m and ends at ({}, {}) m, so its surface is not closed; begin and end it \
             on the axis (radius 0) or end it where it begins, or write `side: Front` for a surface that is solid to \
             the right of the profile, `side: Both` for a thin sheet",
            first[0], first[1], last[0], last[1]
        ));
    }
    match crossing(points) {
        Some((a, b)) => Err(format!(
            "the profile crosses itself between points {a} and {} and points {b} and {}; order its points along the \
             surface",
            a + 1,
            b + 1
        )),
        None => Ok(()),
    }
}

/// Two pieces of a profile that cross, by their first points.
fn crossing(points: &[[f64; 2]]) -> Option<(usize, usize)> {
    let side = |a: [f64; 2], b: [f64; 2], c: [f64; 2]| {
        let (u, v) = ([b[0] - a[0], b[1] - a[1]], [c[0] - a[0], c[1] - a[1]]);
        u[0] * v[1] - u[1] * v[0]
    };
    let pieces = points.len() - 1;
    (0..pieces).find_map(|i| {
        let (a, b) = (points[i], points[i + 1]);
        let mut later = i + 2..pieces;
        let crosses = |&j: &usize| {
            let (c, d) = (points[j], points[j + 1]);
            side(a, b, c) * side(a, b, d) < 0.0 && side(c, d, a) * side(c, d, b) < 0.0
        };
        later.find(crosses).map(|j| (i, j))
    })
}

/// Triangles of the surface: as long as the spacing round the widest place, and along the profile where it has points.
fn turned(points: &[[f64; 2]], spacing: f64) -> Soup {
    let widest = points.iter().map(|point| point[0]).fold(0.0, f64::max);
    let around = (TAU * widest / spacing).ceil().clamp(ROUND.0, ROUND.1) as u32;
    let mut soup = Soup::default();
    // The first vertex of every point; one on the axis has a single vertex, and an end that is the start has its.
    let mut rings: Vec<(u32, bool)> = Vec::new();
    for (k, &[radius, height]) in points.iter().enumerate() {
        if k > 0 && k + 1 == points.len() && points[0] == [radius, height] && radius > 0.0 {
            rings.push(rings[0]);
            continue;
        }
        let first = soup.vertices.len() as u32;
        rings.push((first, radius > 0.0));
        let count = if radius > 0.0 { around } else { 1 };
        soup.vertices.extend((0..count).map(|i| {
            let (sin, cos) = (TAU * f64::from(i) / f64::from(around)).sin_cos();
            DVec3::new(radius * cos, height, radius * sin)
        }));
    }
    for pair in rings.windows(2) {
        let [(from, from_is_ring), (to, to_is_ring)] = [pair[0], pair[1]];
        for i in 0..around {
            let next = (i + 1) % around;
            let at = |first: u32, is_ring: bool, i: u32| if is_ring { first + i } else { first };
            let (a, b) = (at(from, from_is_ring, i), at(from, from_is_ring, next));
            let (c, d) = (at(to, to_is_ring, i), at(to, to_is_ring, next));
            // Normals point to the left of the profile.
            if from_is_ring {
                soup.triangles.push([a, b, c]);
            }
            if to_is_ring {
                soup.triangles.push([b, d, c]);
            }
        }
    }
    soup
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(profile: &[[f32; 2]], side: MeshSide) -> Result<Mesh, String> {
        let place = Place::turned(glam::DMat3::IDENTITY, DVec3::ZERO);
        let mesh = Mesh::of_revolution(profile, place, side, 0.02);
        mesh.map_err(|error| error.to_string())
    }

    /// Cone, cylinder, ring and ball hold their volumes, whichever way their profiles go.
    #[test]
    fn solids_of_revolution_hold_their_volumes() {
        let pi = std::f64::consts::PI;
        let mut ball: Vec<[f32; 2]> = (0..=60)
            .map(|k| {
                let (sin, cos) = (std::f32::consts::PI * k as f32 / 60.0).sin_cos();
                [0.5 * sin, -0.5 * cos]
            })
            .collect();
        (ball[0][0], ball[60][0]) = (0.0, 0.0);
        for (profile, volume) in [
            (vec![[0.0, 0.0], [0.5, 0.0], [0.0, 1.0]], pi * 0.25 / 3.0),
            (
                vec![[0.0, 0.0], [0.5, 0.0], [0.5, 1.0], [0.0, 1.0]],
                pi * 0.25,
            ),
            (
                vec![[0.4, 0.0], [0.5, 0.0], [0.5, 1.0], [0.4, 1.0], [0.4, 0.0]],
                pi * (0.25 - 0.16),
            ),
            (ball, pi / 6.0),
        ] {
            let mut other = profile.clone();
            other.reverse();
            for profile in [profile, other] {
                let mesh = of(&profile, MeshSide::Outside).expect("a solid");
                let error = mesh.volume() / volume - 1.0;
                assert!(error.abs() < 3e-3, "{error} of {profile:?}");
            }
        }
    }

    #[test]
    fn the_fluid_of_an_open_profile_is_to_its_left() {
        // A cup, from the axis outwards and up: fluid is above its floor and within its wall.
        let cup = of(&[[0.0, 0.0], [0.5, 0.0], [0.5, 1.0]], MeshSide::Front).expect("a sheet");
        assert!(cup.nearest(DVec3::new(0.1, 0.2, 0.0)).distance > 0.0);
        assert!(cup.nearest(DVec3::new(0.4, 0.5, 0.0)).distance > 0.0);
        assert!(cup.nearest(DVec3::new(0.0, -0.2, 0.1)).distance < 0.0);
        assert!(cup.nearest(DVec3::new(0.0, 0.5, 0.7)).distance < 0.0);
    }

    #[test]
    fn what_is_no_profile_is_refused_with_the_remedy() {
        for (profile, side, expected) in [
            (&[[0.1, 0.0]][..], MeshSide::Front, "needs two or more"),
            (
                &[[-0.1, 0.0], [0.1, 0.0]],
                MeshSide::Front,
                "the radius of point 0",
            ),
            (&[[0.1, 0.0], [0.1, 0.0]], MeshSide::Front, "points 0 and 1"),
            (
                &[[0.0, 0.0], [0.0, 1.0]],
                MeshSide::Front,
                "lies on the axis",
            ),
            (
                &[[0.1, 0.0], [0.0, 0.5], [0.1, 1.0]],
                MeshSide::Front,
                "where only its ends may be",
            ),
            (
                &[[0.0, 0.0], [0.5, 0.0]],
                MeshSide::Outside,
                "write `side: Front`",
            ),
            (
                &[[0.0, 0.0], [0.5, 0.0], [0.1, 1.0], [0.5, 1.0], [0.1, -1.0]],
                MeshSide::Front,
                "crosses itself between points 0 and 1 and points 3 and 4",
            ),
        ] {
            let error = of(profile, side).expect_err(expected);
            assert!(error.contains(expected), "{error}");
        }
    }
}
