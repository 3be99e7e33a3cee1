//! Ground: heights over a rectangle, as a function and as a surface of triangles.

use glam::{DVec2, DVec3};

use super::{ground::Ground, place::Place, soup::Soup};

/// Heights over a rectangle about the origin of its own axes, and where it is put.
///
/// Each cell of the grid is two triangles, that of its lowest x and z and that of its highest.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct HeightField {
    ground: Ground,
    /// Edges of the rectangle \[m].
    pub(crate) size: DVec2,
    /// Edges of a cell \[m].
    cell: DVec2,
    /// Upward normals at the points of the grid, not of unit length.
    normals: Vec<DVec3>,
    /// Largest slope of a triangle \[-].
    steepest: f64,
    pub(crate) place: Place,
}

impl HeightField {
    pub(crate) fn new(ground: Ground, size: [f32; 2], place: Place) -> Self {
        let size = DVec2::new(size[0].into(), size[1].into());
        let cells = DVec2::new((ground.counts[0] - 1) as f64, (ground.counts[1] - 1) as f64);
        let mut field = Self {
            ground,
            size,
            cell: size / cells,
            normals: Vec::new(),
            steepest: 0.0,
            place,
        };
        field.normals = field.normals_of_points();
        field.steepest = field.steepest_slope();
        field
    }

    fn height_of(&self, i: usize, j: usize) -> f64 {
        self.ground.heights[j * self.ground.counts[0] + i]
    }

    fn normals_of_points(&self) -> Vec<DVec3> {
        let [columns, rows] = self.ground.counts;
        let slope = |k: usize, count: usize, edge: f64, height: &dyn Fn(usize) -> f64| {
            let (before, after) = (k.saturating_sub(1), (k + 1).min(count - 1));
            (height(after) - height(before)) / ((after - before) as f64 * edge)
        };
        let normal = |k: usize| {
            let (i, j) = (k % columns, k / columns);
            let along = slope(i, columns, self.cell.x, &|i| self.height_of(i, j));
            let across = slope(j, rows, self.cell.y, &|j| self.height_of(i, j));
            DVec3::new(-along, 1.0, -across)
        };
        (0..columns * rows).map(normal).collect()
    }

    fn steepest_slope(&self) -> f64 {
        let [columns, rows] = self.ground.counts;
        let slope = |k: usize| {
            let (i, j) = (k % (columns - 1), k / (columns - 1));
            let [a, b, c, d] =
                [(0, 0), (1, 0), (0, 1), (1, 1)].map(|(di, dj)| self.height_of(i + di, j + dj));
            let lower = DVec2::new(b - a, c - a) / self.cell;
            let upper = DVec2::new(d - c, d - b) / self.cell;
            lower.length().max(upper.length())
        };
        (0..(columns - 1) * (rows - 1))
            .map(slope)
            .fold(0.0, f64::max)
    }

    /// The cell of a place in the rectangle, and where in it, from 0 to 1.
    fn cell_of(&self, at: DVec2) -> (usize, usize, DVec2) {
        let part = (at + 0.5 * self.size) / self.cell;
        let last = |part: f64, count: usize| (part.max(0.0) as usize).min(count - 2);
        let (i, j) = (
            last(part.x, self.ground.counts[0]),
            last(part.y, self.ground.counts[1]),
        );
        (i, j, part - DVec2::new(i as f64, j as f64))
    }

    /// Height and slopes along x and z at a place of the rectangle, in its own axes \[m; -].
    pub(crate) fn at(&self, at: DVec2) -> (f64, DVec2) {
        let (i, j, part) = self.cell_of(at);
        let row = self.ground.counts[0];
        let first = j * row + i;
        let heights = &self.ground.heights;
        let (b, c) = (heights[first + 1], heights[first + row]);
        if part.x + part.y <= 1.0 {
            let a = heights[first];
            let rise = DVec2::new(b - a, c - a);
            (a + rise.dot(part), rise / self.cell)
        } else {
            let d = heights[first + row + 1];
            let rise = DVec2::new(d - c, d - b);
            (d - rise.dot(DVec2::ONE - part), rise / self.cell)
        }
    }

    /// The point of the surface above a place of the rectangle, in its own axes \[m].
    pub(crate) fn point(&self, at: DVec2) -> DVec3 {
        DVec3::new(at.x, self.at(at).0, at.y)
    }

    /// Unit normal at a place, upwards, in the field's own axes. It changes smoothly from point to point of the grid.
    pub(crate) fn normal(&self, at: DVec2) -> DVec3 {
        let (i, j, part) = self.cell_of(at);
        let row = self.ground.counts[0];
        let first = j * row + i;
        let along = |first: usize| self.normals[first].lerp(self.normals[first + 1], part.x);
        along(first).lerp(along(first + row), part.y).normalize()
    }

    /// A bound on the distance of a point of the scene from the ground \[m], negative below it: not more than the
    /// distance, if above, and not less, if below. None beyond the rectangle.
    pub(crate) fn bound(&self, point: DVec3) -> Option<f64> {
        let local = self.place.local(point);
        let at = DVec2::new(local.x, local.z);
        let inside = at.abs().cmple(0.5 * self.size).all();
        inside.then(|| (local.y - self.at(at).0) / self.steepest.hypot(1.0))
    }

    /// Its triangles in the scene.
    pub(super) fn soup(&self) -> Soup {
        let [columns, rows] = self.ground.counts;
        let mut soup = Soup::default();
        for j in 0..rows {
            for i in 0..columns {
                let at = DVec2::new(i as f64, j as f64) * self.cell - 0.5 * self.size;
                let point = DVec3::new(at.x, self.height_of(i, j), at.y);
                soup.vertices.push(self.place.point(point));
            }
        }
        for j in 0..rows - 1 {
            for i in 0..columns - 1 {
                let a = (j * columns + i) as u32;
                let (b, c) = (a + 1, a + columns as u32);
                soup.triangles.extend([[a, c, b], [b, c, c + 1]]);
            }
        }
        soup
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::{Mesh, ground::Rolling};

    fn field(turn: f64) -> HeightField {
        let rolling = Rolling {
            seed: 3,
            cell: 0.25,
            amplitude: 0.8,
            wavelength: 4.0,
            octaves: 3,
            channel: None,
        };
        let ground = Ground::generated(&rolling, [7.0, 5.0]).expect("a ground");
        let turn = glam::DMat3::from_rotation_z(turn);
        HeightField::new(
            ground,
            [7.0, 5.0],
            Place::turned(turn, DVec3::new(3.0, -1.0, 2.0)),
        )
    }

    /// The function and the triangles are one surface, and the bound of the distance is one.
    #[test]
    fn heights_and_triangles_agree() {
        for turn in [0.0, 0.2] {
            let heights = field(turn);
            let mesh = Mesh::of_ground(heights.clone(), 0.1).expect("a surface");
            for k in 0..500 {
                let k = f64::from(k);
                let at = DVec2::new(3.5 * (1.1 * k).sin(), 2.5 * (0.7 * k).cos()) * 0.99;
                let on = heights.place.point(heights.point(at));
                assert!(mesh.nearest(on).distance.abs() < 1e-9);
                let up = heights.place.direction(DVec3::Y);
                for height in [0.3, 0.05, -0.05, -0.3] {
                    let point = on + height * up;
                    let distance = mesh.nearest(point).distance;
                    let bound = heights.bound(point).expect("over the rectangle");
                    assert!(bound.abs() <= distance.abs() + 1e-9);
                    assert!(bound * height > 0.0);
                }
                let normal = heights.normal(at);
                let face = DVec3::new(-heights.at(at).1.x, 1.0, -heights.at(at).1.y).normalize();
                assert!(normal.dot(face) > 0.9, "{normal} {face}");
            }
            assert_eq!(heights.bound(DVec3::new(30.0, 0.0, 0.0)), None);
        }
    }
}
