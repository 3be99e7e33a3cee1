//! Rows of the points in a box, found through an index.

use glam::{IVec3, Vec3, Vec4};
use smallvec::{SmallVec, smallvec};

use crate::{
    index::{Run, SpatialIndex},
    scene::{Dimension, Period},
};

/// Points with their index.
#[derive(Clone, Copy)]
pub(super) struct Near<'a> {
    pub(super) index: &'a dyn SpatialIndex,
    /// Points by row.
    pub(super) points: &'a [Vec4],
    /// How far a point may be from where it was indexed \[m].
    pub(super) slack: f32,
}

/// Particles with their current positions and those of their index.
#[derive(Clone, Copy)]
pub(super) struct Crowd<'a> {
    pub(super) near: Near<'a>,
    /// Current positions by row.
    pub(super) places: &'a [Vec4],
    pub(super) dimension: Dimension,
    /// Distance of the particles at rest \[m].
    pub(super) spacing: f32,
    /// The box that repeats.
    pub(super) period: Period,
}

impl Crowd<'_> {
    /// Half extent of the box around a ball or disc.
    pub(super) fn reach(&self, radius: f32) -> Vec3 {
        match self.dimension {
            Dimension::Two => Vec3::new(radius, radius, 0.0),
            Dimension::Three => Vec3::splat(radius),
        }
    }
}

/// Largest number of blocks of cells per query and point: a larger box is compared with every point.
const BLOCKS_A_POINT: f64 = 0.02;
/// Largest number of blocks whatever the number of points.
const FEW_BLOCKS: f64 = 64.0;
/// Coordinates of cells below which no offset overflows.
const LARGEST: i32 = i32::MAX / 4;

impl Near<'_> {
    /// The rows of all points in the box, in ascending order: the same from every structure. With periodic axes those
    /// with an image in it.
    pub(super) fn rows_in(&self, low: Vec3, high: Vec3, rows: &mut Vec<u32>) {
        self.rows_that(low, high, rows, |_| true);
    }

    /// Those of them that count, which is asked first: it spares the comparison of others, and their order.
    pub(super) fn rows_that(
        &self,
        low: Vec3,
        high: Vec3,
        rows: &mut Vec<u32>,
        counts: impl Fn(u32) -> bool,
    ) {
        rows.clear();
        let period = self.index.images().map(|images| images.period);
        for (low, high) in parts(period.unwrap_or_default(), low, high) {
            self.append_rows_in(low, high, rows, &counts);
        }
        rows.sort_unstable();
        // A structure may return more than the requested cells.
        rows.dedup();
    }

    fn append_rows_in(
        &self,
        low: Vec3,
        high: Vec3,
        rows: &mut Vec<u32>,
        counts: &impl Fn(u32) -> bool,
    ) {
        let is_inside = |row: u32| {
            if !counts(row) {
                return false;
            }
            let point = self.points.get(row as usize).map(|point| point.truncate());
            point.is_some_and(|x| x.cmpge(low).all() && x.cmple(high).all())
        };
        let Some(blocks) = self.blocks(low - self.slack, high + self.slack) else {
            rows.extend((0..self.points.len() as u32).filter(|&row| is_inside(row)));
            return;
        };
        let mut runs: Vec<Run> = Vec::new();
        blocks.for_each(|center| self.index.runs(center, &mut runs));
        let entries = self.index.entries();
        for run in runs {
            rows.extend(entries.rows(run).iter().filter(|&&row| is_inside(row)));
        }
    }

    /// Cells whose neighbourhoods cover the box, side by side; `None` if testing every point is as fast.
    fn blocks(&self, low: Vec3, high: Vec3) -> Option<impl Iterator<Item = IVec3> + use<>> {
        let grid = self.index.grid();
        let reach = grid.reach;
        let (first, last) = (
            grid.cell_of(low.extend(0.0)),
            grid.cell_of(high.extend(0.0)),
        );
        let (least, most) = (first.min_element(), last.max_element());
        if least < -LARGEST || most > LARGEST || first.cmpgt(last).any() {
            return None;
        }
        let stride = 2 * reach + 1;
        let counts = (last - first) / stride + 1;
        let count: f64 = counts.to_array().iter().map(|&n| f64::from(n)).product();
        if count > FEW_BLOCKS.max(BLOCKS_A_POINT * self.points.len() as f64) {
            return None;
        }
        // Along an axis where one block suffices it is centred, so that no layer of cells is requested unnecessarily.
        let start = first + reach.min((last - first).max(IVec3::ZERO));
        Some((0..counts.z).flat_map(move |z| {
            (0..counts.y)
                .flat_map(move |y| (0..counts.x).map(move |x| start + stride * IVec3::new(x, y, z)))
        }))
    }
}

/// The parts of a box within the faces of periodic axes, as seen from the other side where it reaches beyond one.
fn parts(period: Period, low: Vec3, high: Vec3) -> SmallVec<[(Vec3, Vec3); 1]> {
    let mut parts: SmallVec<[(Vec3, Vec3); 1]> = smallvec![(low, high)];
    for axis in 0..3 {
        let Some([first, last]) = period.faces(axis) else {
            continue;
        };
        let length = period.length[axis];
        let (low, high) = (low[axis], high[axis]);
        let periods = ((low - first) / length).floor();
        let (low, high) = (low - periods * length, high - periods * length);
        // Rounding may leave a point a little outside.
        let (least, most) = (first - 1e-3 * length, last + 1e-3 * length);
        let spans: SmallVec<[(f32, f32); 2]> = if high - low >= length || !high.is_finite() {
            smallvec![(least, most)]
        } else if high >= last {
            smallvec![(low, most), (least, high - length)]
        } else {
            smallvec![(low, high)]
        };
        let with = |&(from, to): &(Vec3, Vec3)| {
            let (mut from, mut to) = (from, to);
            let spans = spans.clone();
            spans.into_iter().map(move |(low, high)| {
                (from[axis], to[axis]) = (low, high);
                (from, to)
            })
        };
        parts = parts.iter().flat_map(with).collect();
    }
    parts
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{
        index,
        scene::{IndexStructure, Scene, shapes::split_mix},
        state::Execution,
    };

    #[test]
    fn every_structure_finds_who_is_in_a_box() {
        let execution = Execution::new(1).expect("a thread");
        let mut random = 7;
        let mut number = |low: f32, high: f32| {
            let part = split_mix(&mut random) as f64 / u64::MAX as f64;
            low + (high - low) * part as f32
        };
        for (dimension, depth) in [(2, 0.0), (3, 1.0)] {
            let points: Vec<Vec4> = (0..600)
                .map(|_| {
                    Vec4::new(
                        number(-2.0, 2.0),
                        number(-1.0, 1.0),
                        depth * number(0.0, 1.0),
                        0.0,
                    )
                })
                .collect();
            for (structure, cell_size) in IndexStructure::ALL
                .iter()
                .flat_map(|s| [(*s, 1.0), (*s, 0.4)])
            {
                let mut scene: Scene = ron::from_str(&format!(
                    "(name: \"n\", dimension: {dimension}, spacing: 0.1, bodies: [])"
                ))
                .expect("a scene");
                (scene.index.structure, scene.index.cell_size) = (structure, cell_size);
                let mut index = index::build(&scene);
                index.rebuild(&points, &execution).expect("room");
                let near = Near {
                    index: &*index,
                    points: &points,
                    slack: 0.0,
                };
                // From less than a cell to more than the whole domain.
                for reach in [0.01, 0.1, 0.2, 0.3, 0.7, 1.5, 9.0, 1e12] {
                    let center = Vec3::new(
                        number(-2.5, 2.5),
                        number(-1.5, 1.5),
                        depth * number(0.0, 1.0),
                    );
                    let reach = Vec3::new(reach, 0.7 * reach, depth * reach);
                    let (low, high) = (center - reach, center + reach);
                    let mut found = Vec::new();
                    near.rows_in(low, high, &mut found);
                    let is_inside = |x: &Vec4| {
                        let x = x.truncate();
                        x.cmpge(low).all() && x.cmple(high).all()
                    };
                    let rows = (0..).zip(&points).filter(|(_, x)| is_inside(x));
                    let expected: Vec<u32> = rows.map(|(row, _)| row).collect();
                    assert_eq!(
                        found, expected,
                        "{structure:?}, {dimension}-D, {center} ± {reach}"
                    );
                }
            }
        }
    }
}
