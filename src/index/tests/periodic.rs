//! Periodic axes: every structure finds the nearest images that a loop over all pairs and images finds.

use super::*;
use crate::{
    index::periodic::PeriodicIndex,
    neighbours::Recomputed,
    scene::{Period, Periodic, Scene},
    simd::{Simd, Vectorised},
};
use glam::{DVec3, Vec3};

/// Lengths of periods \[support radii], the least that a scene may have first.
const LENGTHS: [f32; 4] = [3.0, 3.3, 5.0, 8.7];

fn period(axes: u8, lengths: [f32; 3], low: Vec3, dimension: Dimension) -> Period {
    let used = if dimension == Dimension::Two { 2 } else { 3 };
    let faces = |axis: usize| {
        let is_periodic = axis < used && axes >> axis & 1 == 1;
        is_periodic.then(|| [low[axis], low[axis] + lengths[axis] * H])
    };
    let periodic = Periodic {
        x: faces(0),
        y: faces(1),
        z: faces(2),
    };
    let scene = Scene {
        periodic,
        ..Scene::new("p", 0.05)
    };
    scene.period()
}

/// Rows within the support radius by any image of those up to two periods away, and rows for which rounding decides.
fn by_images(
    period: &Period,
    of: Vec4,
    among: &[Vec4],
    own: Option<usize>,
) -> (Vec<u32>, Vec<u32>) {
    let (mut near, mut unclear) = (Vec::new(), Vec::new());
    let h = f64::from(H);
    for (row, point) in among.iter().enumerate() {
        if own == Some(row) {
            continue;
        }
        let offset = of.truncate().as_dvec3() - point.truncate().as_dvec3();
        let mut nearest = f64::INFINITY;
        for k in 0..125 {
            let images = DVec3::new(f64::from(k % 5), f64::from(k / 5 % 5), f64::from(k / 25));
            let image = offset + (images - 2.0) * period.length.as_dvec3();
            nearest = nearest.min(image.length());
        }
        if (nearest - h).abs() < 1e-5 * h {
            unclear.push(row as u32);
        } else if nearest < h {
            near.push(row as u32);
        }
    }
    (near, unclear)
}

/// Lists that are computed row by row.
struct Fresh<'a>(Search<'a>);

impl Vectorised for Fresh<'_> {
    type Output = Vec<Vec<u32>>;

    #[inline(always)]
    fn run<S: Simd>(self, simd: S) -> Vec<Vec<u32>> {
        let mut near = Recomputed::new(self.0);
        (0..self.0.points.len())
            .map(|row| near.of(simd, row).to_vec())
            .collect()
    }
}

fn assert_finds_images(task: Search, period: &Period) {
    let stored = lists(task, two_threads());
    let fresh = two_threads().instruction_set.dispatch(Fresh(task));
    assert_eq!(stored, fresh, "stored and recomputed");
    for (row, mut list) in stored.into_iter().enumerate() {
        let own = task.same.then_some(row);
        let (near, unclear) = by_images(period, task.points[row], task.among_points, own);
        list.sort_unstable();
        assert!(
            list.windows(2).all(|pair| pair[0] < pair[1]),
            "row {row} has one twice"
        );
        list.retain(|other| !unclear.contains(other));
        assert_eq!(list, near, "row {row}");
    }
}

fn periodic(grid: &Grid, kind: Option<Kind>, period: Period) -> PeriodicIndex {
    let structure = kind.map_or_else(
        || Box::new(BruteForce::new(grid.clone())) as Box<dyn SpatialIndex>,
        |kind| structure(grid, kind),
    );
    PeriodicIndex::new(structure, period)
}

proptest! {
    #![proptest_config(cases(96))]

    #[test]
    fn every_structure_finds_the_images_that_a_loop_over_all_finds(
        (grid, dimension) in any_grid(),
        (axes, lengths) in (1u8..8, prop::array::uniform3(prop::sample::select(&LENGTHS[..]))),
        (count, others, steps) in (0usize..120, 0usize..60, 0usize..4),
        seed: u64,
        kind in prop::option::weighted(0.9, prop::sample::select(&KINDS[..])),
    ) {
        let mut numbers = Numbers(seed);
        let low = numbers.point(dimension, 1.0).truncate();
        let period = period(axes, lengths, low, dimension);
        let mut point = |edge: f32| {
            let point = numbers.point(dimension, edge);
            period.wrap(point.truncate()).extend(point.w)
        };
        let mut points: Vec<Vec4> = (0..count).map(|_| point(5.0 * H)).collect();
        let walls: Vec<Vec4> = (0..others).map(|_| point(5.0 * H)).collect();
        let mut index = periodic(&grid, kind, period);
        let mut of_walls = periodic(&grid, kind, period);
        of_walls.rebuild(&walls, two_threads()).expect("a box that fits");
        index.rebuild(&points, two_threads()).expect("a box that fits");
        for step in 0..=steps {
            if step > 0 {
                // All drift, some come and some go.
                for moved in &mut points {
                    let far = *moved + point(0.2 * H) + Vec4::new(0.3 * H, -0.1 * H, 0.0, 0.0);
                    *moved = period.wrap(far.truncate()).extend(0.0);
                }
                points.truncate(points.len() - points.len() / 10);
                points.push(point(5.0 * H));
                update(&mut index, &points);
            }
            assert_finds_images(Search::among_themselves(&index, &points), &period);
            let among_walls = Search {
                of: &index,
                points: &points,
                among: &of_walls,
                among_points: &walls,
                same: false,
            };
            assert_finds_images(among_walls, &period);
        }
    }
}
