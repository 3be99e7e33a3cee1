//! The greedy packing of one tile.

use glam::{DVec2, DVec3};
use smallvec::SmallVec;

use crate::mesh::HeightField;

/// What a distance may miss \[least distances].
const ROUNDING: f64 = 2e-3;

/// A sample on the surface, in the axes of the ground.
#[derive(Debug, Clone, Copy)]
pub(super) struct Point {
    /// x and z \[m].
    pub(super) at: DVec2,
    /// \[m]
    pub(super) place: DVec3,
}

/// The packing of one tile, and of a margin around it that is as wide as the least distance.
pub(super) struct Packing<'a> {
    heights: &'a HeightField,
    distance: f64,
    /// Where samples may be put \[m].
    low: DVec2,
    high: DVec2,
    points: Vec<Point>,
    /// Number of the first sample that is this tile's.
    first: usize,
    /// Rows of `points` in cells as large as the least distance, which begin `MARGIN` before `low`.
    cells: Vec<SmallVec<[u32; 2]>>,
    columns: usize,
}

/// Cells around those in which samples may be put.
const MARGIN: f64 = 3.0;

impl<'a> Packing<'a> {
    /// A packing of the rectangle from `low` to `high` \[m], at a least distance \[m].
    pub(super) fn new(
        heights: &'a HeightField,
        distance: f64,
        (low, high): (DVec2, DVec2),
    ) -> Self {
        let half = 0.5 * heights.size;
        let (low, high) = ((low - distance).max(-half), (high + distance).min(half));
        let cells = ((high - low) / distance).floor() + 1.0 + 2.0 * MARGIN;
        Self {
            heights,
            distance,
            low,
            high,
            points: Vec::new(),
            first: 0,
            cells: vec![SmallVec::new(); cells.element_product() as usize],
            columns: cells.x as usize,
        }
    }

    /// Column and row of the cell of a place; none too far from the tile.
    fn cell(&self, at: DVec2) -> Option<(usize, usize)> {
        let part = (at - self.low) / self.distance + MARGIN;
        let (column, row) = (part.x.floor(), part.y.floor());
        let rows = self.cells.len() / self.columns;
        let inside =
            (0.0..self.columns as f64).contains(&column) && (0.0..rows as f64).contains(&row);
        inside.then_some((column as usize, row as usize))
    }

    /// Takes a sample that is there already.
    pub(super) fn know(&mut self, point: Point) {
        if let Some((column, row)) = self.cell(point.at) {
            self.cells[column + self.columns * row].push(self.points.len() as u32);
            self.points.push(point);
        }
    }

    /// Calls `visit` with all samples in the cells up to `reach` from a place.
    fn near(&self, at: DVec2, reach: usize, mut visit: impl FnMut(usize)) {
        let Some((column, row)) = self.cell(at) else {
            return;
        };
        let rows = self.cells.len() / self.columns;
        for row in row.saturating_sub(reach)..(row + reach + 1).min(rows) {
            for column in column.saturating_sub(reach)..(column + reach + 1).min(self.columns) {
                let cell = &self.cells[column + self.columns * row];
                cell.iter().for_each(|&k| visit(k as usize));
            }
        }
    }

    /// Whether no sample is nearer to a place than a part of the least distance.
    fn is_free(&self, point: &Point, part: f64) -> bool {
        let least = (part * self.distance).powi(2);
        let mut free = true;
        self.near(point.at, 1, |k| {
            free &= self.points[k].place.distance_squared(point.place) >= least;
        });
        free
    }

    pub(super) fn fill(mut self) -> Vec<Point> {
        self.first = self.points.len();
        if self.points.is_empty() {
            let at = 0.5 * (self.low + self.high);
            self.know(Point {
                at,
                place: self.heights.point(at),
            });
        }
        let mut from = 0;
        let mut others: Vec<(f64, usize)> = Vec::new();
        while from < self.points.len() {
            let here = self.points[from];
            others.clear();
            // Of every two, when the second has its turn.
            self.near(here.at, 2, |k| {
                let apart = self.points[k].place.distance(here.place);
                if k < from && apart < 2.0 * self.distance {
                    others.push((apart, k));
                }
            });
            others.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
            for &(_, k) in &others {
                for side in [1.0, -1.0] {
                    self.put_between(here, self.points[k], side);
                }
            }
            if others.is_empty() {
                self.put_beside(here);
            }
            from += 1;
        }
        self.points.split_off(self.first)
    }

    /// A first neighbour of a sample that has none.
    fn put_beside(&mut self, here: Point) {
        for direction in [DVec2::X, DVec2::Y, -DVec2::X, -DVec2::Y] {
            let (_, slope) = self.heights.at(here.at);
            let along = self.distance / slope.dot(direction).hypot(1.0);
            let at = here.at + 1.01 * along * direction;
            let point = Point {
                at,
                place: self.heights.point(at),
            };
            if self.may_be_at(at) && self.is_free(&point, 1.0) {
                self.know(point);
                return;
            }
        }
    }

    fn may_be_at(&self, at: DVec2) -> bool {
        at.cmpge(self.low).all() && at.cmple(self.high).all()
    }

    /// Puts a sample at the least distance from two others, on one side of the line between them, if it is free.
    fn put_between(&mut self, a: Point, b: Point, side: f64) {
        let middle = 0.5 * (a.at + b.at);
        let way = b.place - a.place;
        let height = (self.distance.powi(2) - 0.25 * way.length_squared())
            .max(0.0)
            .sqrt();
        let across = self.heights.normal(middle).cross(way).normalize_or_zero();
        let guess = 0.5 * (a.place + b.place) + side * height * across;
        let mut at = DVec2::new(guess.x, guess.z);
        if !self.may_be_at(at) && !self.may_be_at(at.clamp(self.low, self.high)) {
            return;
        }
        let (mut place, mut slope) = self.on_surface(at);
        if !self.is_free(&Point { at, place }, 0.8) {
            return;
        }
        // Newton's method for both distances.
        let square = self.distance.powi(2);
        for _ in 0..8 {
            let (to_a, to_b) = (place - a.place, place - b.place);
            let miss = DVec2::new(
                to_a.length_squared() - square,
                to_b.length_squared() - square,
            );
            if miss.abs().max_element() < 0.5 * ROUNDING * square {
                let point = Point { at, place };
                if self.may_be_at(at) && self.is_free(&point, 1.0 - ROUNDING) {
                    self.know(point);
                }
                return;
            }
            let of = |to: DVec3| 2.0 * DVec2::new(to.x + to.y * slope.x, to.z + to.y * slope.y);
            let (first, second) = (of(to_a), of(to_b));
            let determinant = first.perp_dot(second);
            if determinant.abs() < 1e-9 * square {
                return;
            }
            let step = DVec2::new(
                miss.x * second.y - miss.y * first.y,
                miss.y * first.x - miss.x * second.x,
            ) / determinant;
            at -= step.clamp_length_max(0.5 * self.distance);
            (place, slope) = self.on_surface(at);
        }
    }

    fn on_surface(&self, at: DVec2) -> (DVec3, DVec2) {
        let half = 0.5 * self.heights.size;
        let (height, slope) = self.heights.at(at.clamp(-half, half));
        (DVec3::new(at.x, height, at.y), slope)
    }
}
