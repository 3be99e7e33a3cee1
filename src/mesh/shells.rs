//! Checks that a closed surface defines everywhere which side is solid.
//!
//! Each shell (connected part) must bound a solid, or a cavity in one: the winding number is ±1 on one side of every
//! shell and 0 on the other. Separate shells may have either orientation, which is made uniform here. Shells that
//! cross, coincide, or lie inside another of the same orientation are refused: such a file may mean a union or a
//! cavity, and only its author knows.

use std::collections::BTreeMap;

use glam::DVec3;

use super::{
    bvh::Bvh,
    soup::Soup,
    topology::{key, sides},
    triangle,
    weld::cancel,
};

/// Directions of rays: it is unlikely that an edge of a constructed surface has one of them.
const DIRECTIONS: [DVec3; 3] = [
    DVec3::new(0.577_215, 0.694_147, 0.431_662),
    DVec3::new(-0.302_03, 0.618_034, -0.726_249),
    DVec3::new(0.915_966, -0.265_802, -0.300_512),
];

/// Orients the shells so that normals point out of the solid, or into it (`inwards`). Fails if the solid is ambiguous.
/// Surfaces closer than the tolerance \[m] touch.
pub(super) fn orient(soup: &mut Soup, inwards: bool, tolerance: f64) -> Result<(), String> {
    cancel(&mut soup.triangles);
    if soup.triangles.is_empty() {
        return Err("none of its triangles has an area that bounds a solid, all lie back to back; write `side: Both` \
         for a thin sheet"
                .to_owned());
    }
    let bvh = Bvh::new(&soup.vertices, &soup.triangles);
    if let Some(at) = crossing(soup, &bvh, tolerance) {
        return Err(format!(
            "parts of its surface cross at {}, so inside and outside are not clear; unite them (boolean union), or \
             write a mesh for each",
            place(at)
        ));
    }
    let shells = Shells::of(soup);
    let count = shells.rows.len();
    if let Some(shell) = (0..count).find(|&shell| shells.is_flat(soup, shell, tolerance)) {
        return Err(format!(
            "the shell at {} encloses nothing: parts of it lie on each other and are wound opposite ways; delete one \
             of them, or write `side: Both` for a thin sheet",
            place(shells.middle(soup, shell))
        ));
    }
    let turned: Vec<bool> = (0..count)
        .map(|shell| shells.volume(soup, shell) < 0.0)
        .collect();
    let mut turn = vec![false; count];
    for shell in 0..count {
        // Nested shells must alternate in orientation; the outermost defines the outside.
        let (outermost, winding) = shells.around(soup, &bvh, shell, tolerance)?;
        turn[shell] = turned[outermost.unwrap_or(shell)];
        let sign = if turn[shell] { -1 } else { 1 };
        let before = sign * winding;
        let here = if turned[shell] { -sign } else { sign };
        if !matches!((before, here), (0, 1) | (1, -1)) {
            return Err(format!(
                "a shell at {} lies in another that is wound the same way, so inside and outside are not clear; turn \
                 it over (flip its normals) if it bounds a cavity, delete it if it does not",
                place(shells.middle(soup, shell))
            ));
        }
    }
    for (corners, shell) in soup.triangles.iter_mut().zip(&shells.shell_of) {
        if turn[*shell] != inwards {
            corners.swap(1, 2);
        }
    }
    Ok(())
}

fn place(at: DVec3) -> String {
    format!("({:.4}, {:.4}, {:.4}) m", at.x, at.y, at.z)
}

/// A point where an edge passes through a triangle by more than the tolerance, if there is one.
fn crossing(soup: &Soup, bvh: &Bvh, tolerance: f64) -> Option<DVec3> {
    let corner = |row: u32| soup.vertices[row as usize];
    for &corners in &soup.triangles {
        for (a, b) in sides(corners) {
            // Each edge once: in a closed surface it occurs in both directions.
            if a > b {
                continue;
            }
            let (from, way) = (corner(a), corner(b) - corner(a));
            let mut found = None;
            bvh.visit(from, way, 1.0, |other| {
                let other = soup.triangles[other];
                if other.contains(&a) || other.contains(&b) {
                    return;
                }
                let at = other.map(corner);
                let normal = (at[1] - at[0]).cross(at[2] - at[0]).normalize_or_zero();
                let (before, after) = (normal.dot(from - at[0]), normal.dot(from + way - at[0]));
                let apart = before.abs().min(after.abs()) > tolerance && before * after < 0.0;
                if apart && let Some(depth) = triangle::hit(at, from, way) {
                    found = Some(from + depth * way);
                }
            });
            if found.is_some() {
                return found;
            }
        }
    }
    None
}

/// Assigns triangles to shells, and lists the triangles of each shell.
struct Shells {
    shell_of: Vec<usize>,
    rows: Vec<Vec<usize>>,
}

/// A shell that encloses a point.
#[derive(Debug, Clone, Copy)]
struct Around {
    shell: usize,
    /// Its winding number.
    winding: i32,
    /// Depth at which the ray leaves it \[lengths of the direction].
    depth: f64,
}

impl Shells {
    /// Triangles are connected over edges that have exactly two of them; if shells would then be open, over all edges.
    fn of(soup: &Soup) -> Self {
        let mut around: BTreeMap<(u32, u32), Vec<(usize, bool)>> = BTreeMap::new();
        for (index, &corners) in soup.triangles.iter().enumerate() {
            for (a, b) in sides(corners) {
                around.entry(key(a, b)).or_default().push((index, a < b));
            }
        }
        let joined = |most: usize| {
            let mut root: Vec<usize> = (0..soup.triangles.len()).collect();
            for triangles in around.values().filter(|triangles| triangles.len() <= most) {
                for pair in triangles.windows(2) {
                    let (a, b) = (find(&mut root, pair[0].0), find(&mut root, pair[1].0));
                    root[a.max(b)] = a.min(b);
                }
            }
            // The first triangle of a shell is its root.
            let (mut shell_of, mut rows): (Vec<usize>, Vec<Vec<usize>>) = Default::default();
            for index in 0..root.len() {
                let first = find(&mut root, index);
                let shell = if first == index {
                    rows.len()
                } else {
                    shell_of[first]
                };
                if shell == rows.len() {
                    rows.push(Vec::new());
                }
                shell_of.push(shell);
                rows[shell].push(index);
            }
            Self { shell_of, rows }
        };
        let apart = joined(2);
        let is_open = around.values().any(|triangles| {
            let mut passes: BTreeMap<usize, i32> = BTreeMap::new();
            for &(triangle, up) in triangles {
                *passes.entry(apart.shell_of[triangle]).or_default() += if up { 1 } else { -1 };
            }
            passes.values().any(|&sum| sum != 0)
        });
        if is_open { joined(usize::MAX) } else { apart }
    }

    fn triangles<'a>(
        &'a self,
        soup: &'a Soup,
        shell: usize,
    ) -> impl Iterator<Item = [DVec3; 3]> + 'a {
        self.rows[shell].iter().map(|&row| corners(soup, row))
    }

    /// Six times the volume \[m³]; negative if normals point inwards.
    fn volume(&self, soup: &Soup, shell: usize) -> f64 {
        let mut triangles = self.triangles(soup, shell).peekable();
        let origin = triangles.peek().map_or(DVec3::ZERO, |corners| corners[0]);
        let parts = triangles.map(|corners| {
            let [a, b, c] = corners.map(|corner| corner - origin);
            a.dot(b.cross(c))
        });
        parts.sum()
    }

    /// Whether its volume is less than that of a plate half as thick as the tolerance \[m].
    fn is_flat(&self, soup: &Soup, shell: usize, tolerance: f64) -> bool {
        let areas = self
            .triangles(soup, shell)
            .map(|[a, b, c]| 0.5 * (b - a).cross(c - a).length());
        let plate = 0.5 * tolerance * 0.5 * areas.sum::<f64>();
        self.volume(soup, shell).abs() / 6.0 < plate
    }

    fn middle(&self, soup: &Soup, shell: usize) -> DVec3 {
        let [a, b, c] = self.triangles(soup, shell).next().unwrap_or_default();
        (a + b + c) / 3.0
    }

    /// The outermost of the other shells that enclose this one, if any does, and the sum of their winding numbers.
    fn around(
        &self,
        soup: &Soup,
        bvh: &Bvh,
        shell: usize,
        tolerance: f64,
    ) -> Result<(Option<usize>, i32), String> {
        if self.rows.len() == 1 {
            return Ok((None, 0));
        }
        // A point of this shell that lies on no other shell.
        let is_free = |middle: &DVec3| {
            let nearest = bvh.nearest(*middle, |other| {
                (self.shell_of[other] != shell)
                    .then(|| triangle::closest(corners(soup, other), *middle))
            });
            nearest.is_none_or(|(_, closest)| closest.at.distance(*middle) > tolerance)
        };
        let mut middles = self
            .triangles(soup, shell)
            .map(|[a, b, c]| (a + b + c) / 3.0);
        let Some(point) = middles.find(is_free) else {
            return Err(format!(
                "two shells lie in one place at {}; delete one of them",
                place(self.middle(soup, shell))
            ));
        };
        let [a, b, c] = DIRECTIONS.map(|direction| self.passed(soup, bvh, shell, point, direction));
        let same = |a: &[Around], b: &[Around]| {
            a.iter()
                .map(|around| (around.shell, around.winding))
                .eq(b.iter().map(|around| (around.shell, around.winding)))
        };
        // Two of three rays agree, unless two of them meet edges.
        let shells = if !same(&a, &b) && same(&b, &c) { b } else { a };
        let outermost = shells.iter().max_by(|a, b| a.depth.total_cmp(&b.depth));
        let winding = shells.iter().map(|around| around.winding).sum();
        Ok((outermost.map(|around| around.shell), winding))
    }

    /// The other shells that enclose a point, found from the intersections of a ray from it.
    fn passed(
        &self,
        soup: &Soup,
        bvh: &Bvh,
        shell: usize,
        point: DVec3,
        direction: DVec3,
    ) -> Vec<Around> {
        let mut passed: BTreeMap<usize, Around> = BTreeMap::new();
        bvh.visit(point, direction, f64::INFINITY, |other| {
            let shell_of = self.shell_of[other];
            if shell_of == shell {
                return;
            }
            let at = corners(soup, other);
            if let Some(depth) = triangle::hit(at, point, direction) {
                let outwards = (at[1] - at[0]).cross(at[2] - at[0]).dot(direction) > 0.0;
                let entry = passed.entry(shell_of).or_insert(Around {
                    shell: shell_of,
                    winding: 0,
                    depth,
                });
                entry.winding += if outwards { 1 } else { -1 };
                entry.depth = entry.depth.max(depth);
            }
        });
        passed
            .into_values()
            .filter(|around| around.winding != 0)
            .collect()
    }
}

fn corners(soup: &Soup, triangle: usize) -> [DVec3; 3] {
    soup.triangles[triangle].map(|row| soup.vertices[row as usize])
}

fn find(root: &mut [usize], mut index: usize) -> usize {
    while root[index] != index {
        root[index] = root[root[index]];
        index = root[index];
    }
    index
}
