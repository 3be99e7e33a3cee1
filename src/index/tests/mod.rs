//! Compares every structure with the reference, through the search that the engine uses.

mod cases;

use std::sync::LazyLock;

use proptest::prelude::*;

use super::*;

use crate::state::Execution;
use crate::{
    neighbours::{NeighbourLists, Search, search},
    scene::Dimension,
    simd::InstructionSet,
    state::ListsTooLong,
};
use glam::{IVec3, Vec4};

/// Support radius of all tests \[m].
const H: f32 = 0.1;
const CELL_SIZES: [f32; 4] = [1.0, 0.5, 1.0 / 3.0, 0.7];
const DIMENSIONS: [Dimension; 2] = [Dimension::Two, Dimension::Three];

static THREADS: LazyLock<[Execution; 3]> =
    LazyLock::new(|| [1, 2, 3].map(|threads| Execution::new(threads).expect("threads")));

fn two_threads() -> &'static Execution {
    &THREADS[1]
}

/// The same cases in every run; failures write no files.
fn cases(cases: u32) -> ProptestConfig {
    ProptestConfig {
        cases,
        failure_persistence: None,
        rng_seed: proptest::test_runner::RngSeed::Fixed(2011),
        ..ProptestConfig::default()
    }
}

/// A small random generator that gives the same numbers on every platform.
struct Numbers(u64);

impl Numbers {
    /// In [0, 1).
    fn next(&mut self) -> f32 {
        self.0 = self
            .0
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 40) as f32 / (1u64 << 24) as f32
    }

    fn below(&mut self, count: usize) -> usize {
        (self.next() * count as f32) as usize
    }

    /// In the box `[-edge/2, edge/2)^d`.
    fn point(&mut self, dimension: Dimension, edge: f32) -> Vec4 {
        let mut coordinate = || edge * (self.next() - 0.5);
        let (x, y, z) = (coordinate(), coordinate(), coordinate());
        flat(Vec4::new(x, y, z, 0.0), dimension)
    }
}

fn flat(mut point: Vec4, dimension: Dimension) -> Vec4 {
    if dimension == Dimension::Two {
        point.z = 0.0;
    }
    point
}

/// Distribution of the points of a test.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Layout {
    /// Like fluid: about thirty neighbours each.
    Even,
    /// A few dense clusters, far apart.
    Clusters,
    /// All in one cell.
    OneCell,
    /// All at one position.
    OnePlace,
    /// On the corners of the cells, and pairs at exactly the support radius.
    CellCorners,
    /// As `Even`, 10 km away, where neighbouring floats differ by a hundredth of h.
    FarAway,
    /// Spray: hardly any neighbours, and colliding cells in the table.
    Spray,
}

const LAYOUTS: [Layout; 7] = [
    Layout::Even,
    Layout::Clusters,
    Layout::OneCell,
    Layout::OnePlace,
    Layout::CellCorners,
    Layout::FarAway,
    Layout::Spray,
];

fn points(layout: Layout, grid: &Grid, dimension: Dimension, count: usize, seed: u64) -> Vec<Vec4> {
    let mut numbers = Numbers(seed);
    let power = match dimension {
        Dimension::Two => 0.5,
        Dimension::Three => 1.0 / 3.0,
    };
    let even_edge = H * (count as f32 / 8.0).powf(power);
    let point = |_| match layout {
        Layout::Even => numbers.point(dimension, even_edge),
        Layout::Clusters => {
            let cluster = [-1.0f32, 0.37, 1.51][numbers.below(3)];
            flat(Vec4::new(cluster, -cluster, 0.5 * cluster, 0.0), dimension)
                + numbers.point(dimension, H)
        }
        Layout::OneCell => {
            let middle = Vec4::splat(-2.5 * grid.cell_size as f32);
            flat(middle, dimension).with_w(0.0)
                + numbers.point(dimension, 0.9 * grid.cell_size as f32)
        }
        Layout::OnePlace => flat(Vec4::new(-0.3, 0.7, 0.1, 0.0), dimension),
        Layout::CellCorners => {
            let size = [grid.cell_size, f64::from(H), f64::from(H) / 3.0][numbers.below(3)];
            let mut coordinate = || (size * f64::from(numbers.below(7) as f32 - 3.0)) as f32;
            let corner = Vec4::new(coordinate(), coordinate(), coordinate(), 0.0);
            flat(corner, dimension)
        }
        Layout::FarAway => {
            let origin = flat(Vec4::new(1e4, -1e4, 1e4, 0.0), dimension);
            origin + numbers.point(dimension, even_edge)
        }
        Layout::Spray => numbers.point(dimension, 8.0 * even_edge),
    };
    (0..count).map(point).collect()
}

fn lists(task: Search, execution: &Execution) -> Vec<Vec<u32>> {
    let mut lists = NeighbourLists::default();
    search(&task, &mut lists, execution).expect("short lists");
    (0..task.points.len())
        .map(|row| lists.of(row).to_vec())
        .collect()
}

fn own_lists(index: &dyn SpatialIndex, points: &[Vec4]) -> Vec<Vec<u32>> {
    lists(Search::among_themselves(index, points), two_threads())
}

fn sorted(mut lists: Vec<Vec<u32>>) -> Vec<Vec<u32>> {
    lists.iter_mut().for_each(|list| list.sort_unstable());
    lists
}

fn reference(grid: &Grid, points: &[Vec4]) -> Vec<Vec<u32>> {
    let mut brute = BruteForce::new(grid.clone());
    brute.rebuild(points, two_threads()).expect("no box");
    own_lists(&brute, points)
}

/// A structure under test.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Kind {
    Uniform,
    IndexSort,
    ZIndexSort,
    SpatialHashing,
    /// With the smallest table: nearly every cell collides.
    SpatialHashingSmall,
    CompactHashing,
    /// With the smallest table: nearly every cell collides.
    CompactHashingSmall,
}

const KINDS: [Kind; 7] = [
    Kind::Uniform,
    Kind::IndexSort,
    Kind::ZIndexSort,
    Kind::SpatialHashing,
    Kind::SpatialHashingSmall,
    Kind::CompactHashing,
    Kind::CompactHashingSmall,
];

fn structure(grid: &Grid, kind: Kind) -> Box<dyn SpatialIndex> {
    let grid = grid.clone();
    match kind {
        Kind::Uniform => Box::new(UniformGrid::new(grid)),
        Kind::IndexSort => Box::new(IndexSort::new(grid)),
        Kind::ZIndexSort => Box::new(ZIndexSort::new(grid)),
        Kind::SpatialHashing => Box::new(SpatialHashing::new(grid, 8.0)),
        Kind::SpatialHashingSmall => Box::new(SpatialHashing::with_smallest_table(grid, 8.0)),
        Kind::CompactHashing => Box::new(CompactHashing::new(grid, 8.0)),
        Kind::CompactHashingSmall => Box::new(CompactHashing::with_smallest_table(grid, 8.0)),
    }
}

fn built(grid: &Grid, kind: Kind, points: &[Vec4]) -> Box<dyn SpatialIndex> {
    let mut index = structure(grid, kind);
    index
        .rebuild(points, two_threads())
        .expect("a box that fits");
    index
}

fn update(index: &mut dyn SpatialIndex, points: &[Vec4]) {
    index
        .update(points, two_threads())
        .expect("a box that fits");
}

/// Every row is in exactly one partition, cells agree with the points, and every entry around a cell is returned once.
fn assert_sound(index: &dyn SpatialIndex, points: &[Vec4]) {
    let mut seen = vec![0; points.len()];
    for partition in 0..index.partitions() {
        let mut done = 0;
        while let Some((cell, members)) = index.next_cell(partition, done) {
            assert!(!members.is_empty());
            for &row in members {
                seen[row as usize] += 1;
                let point = points[row as usize];
                assert!(!point.is_finite() || index.grid().cell_of(point) == cell);
            }
            done += members.len();
            let (mut runs, mut all) = (Vec::new(), Vec::new());
            index.runs_around(partition, cell, &mut runs);
            index.runs(cell, &mut all);
            assert_eq!(runs, all);
            let rows = runs.iter().flat_map(|&run| index.entries().rows(run));
            let mut rows: Vec<u32> = rows.copied().collect();
            rows.sort_unstable();
            assert!(rows.windows(2).all(|pair| pair[0] < pair[1]), "{rows:?}");
            assert!(rows.iter().all(|&row| (row as usize) < points.len()));
        }
        assert_eq!(done, index.partition_len(partition));
    }
    assert!(
        seen.iter().all(|&count| count == 1),
        "rows by partition: {seen:?}"
    );
}

/// The index returns exactly the points of the neighbourhood.
fn assert_exact(index: &dyn SpatialIndex, points: &[Vec4]) {
    let grid = index.grid();
    for partition in 0..index.partitions() {
        let mut done = 0;
        while let Some((center, members)) = index.next_cell(partition, done) {
            done += members.len();
            let mut runs = Vec::new();
            index.runs(center, &mut runs);
            let rows = runs.iter().flat_map(|&run| index.entries().rows(run));
            let mut found: Vec<u32> = rows.copied().collect();
            found.sort_unstable();
            let around = |point: Vec4| {
                let offset = grid.cell_of(point).wrapping_sub(center);
                grid.neighbourhood.contains(&offset)
            };
            let rows = (0u32..).zip(points).filter(|(_, point)| around(**point));
            let expected: Vec<u32> = rows.map(|(row, _)| row).collect();
            assert_eq!(found, expected, "around {center}");
        }
    }
}

/// Soundness, the same neighbours as the reference, and no row twice in a list.
fn assert_agrees(index: &dyn SpatialIndex, points: &[Vec4]) {
    assert_sound(index, points);
    let found = sorted(own_lists(index, points));
    assert_eq!(found, sorted(reference(index.grid(), points)));
}

/// No used cell is empty, links lead to the right used cells, and the collision flag is set exactly for used cells
/// with several spatial cells.
fn assert_flags(index: &CompactHashing) {
    assert!(index.links_are_exact());
    let mut collisions = 0;
    for partition in 0..index.partitions() {
        assert!(
            index.partition_len(partition) > 0,
            "used cell {partition} is empty"
        );
        let (mut done, mut cells) = (0, Vec::new());
        while let Some((cell, members)) = index.next_cell(partition, done) {
            done += members.len();
            cells.push(cell);
        }
        cells.dedup();
        collisions += usize::from(cells.len() > 1);
    }
    let share = collisions as f32 / index.partitions().max(1) as f32;
    assert_eq!(index.collision_share(), share);
}

/// A grid of arbitrary dimension and cell size.
fn any_grid() -> impl Strategy<Value = (Grid, Dimension)> {
    (
        prop::sample::select(&CELL_SIZES[..]),
        prop::sample::select(&DIMENSIONS[..]),
    )
        .prop_map(|(cell_size, dimension)| (Grid::new(dimension, H, cell_size), dimension))
}

proptest! {
    #![proptest_config(cases(96))]

    #[test]
    fn every_structure_finds_the_neighbours_that_brute_force_finds(
        (grid, dimension) in any_grid(),
        layout in prop::sample::select(&LAYOUTS[..]),
        count in 0usize..400,
        seed: u64,
        kind in prop::sample::select(&KINDS[..]),
    ) {
        let points = points(layout, &grid, dimension, count, seed);
        assert_agrees(&*built(&grid, kind, &points), &points);
    }

    #[test]
    fn any_motion_leaves_the_index_as_a_new_one_would_be(
        (grid, dimension) in any_grid(),
        layout in prop::sample::select(&LAYOUTS[..]),
        seed: u64,
        kind in prop::sample::select(&KINDS[..]),
        // With few points, used cells become empty and are reused by other cells of the same hash.
        (steps, count) in (1usize..12, prop::sample::select(&[3, 12, 250][..])),
    ) {
        let mut points = points(layout, &grid, dimension, count, seed);
        let mut index = structure(&grid, kind);
        let mut numbers = Numbers(!seed);
        update(&mut *index, &points);
        for _ in 0..steps {
            // Few enough that the index is updated, not rebuilt.
            for point in &mut points {
                *point += match numbers.below(20) {
                    0 => numbers.point(dimension, 3.0),
                    1 => numbers.point(dimension, H),
                    _ => numbers.point(dimension, 0.02 * H),
                };
            }
            update(&mut *index, &points);
            assert_sound(&*index, &points);
            if let Kind::CompactHashing | Kind::CompactHashingSmall = kind {
                assert_exact(&*index, &points);
            }
        }
        assert_agrees(&*index, &points);
    }

    #[test]
    fn points_come_and_go(
        (grid, dimension) in any_grid(),
        seed: u64,
        kind in prop::sample::select(&KINDS[..]),
        counts in prop::collection::vec(0usize..300, 1..10),
    ) {
        let all = points(Layout::Even, &grid, dimension, 300, seed);
        let mut index = structure(&grid, kind);
        for count in counts {
            update(&mut *index, &all[..count]);
            assert_agrees(&*index, &all[..count]);
        }
    }

    #[test]
    fn despawning_by_swapping_with_the_last_row_is_followed(
        (grid, dimension) in any_grid(),
        seed: u64,
        kind in prop::sample::select(&KINDS[..]),
    ) {
        let mut points = points(Layout::Even, &grid, dimension, 200, seed);
        let mut index = structure(&grid, kind);
        let mut numbers = Numbers(seed);
        update(&mut *index, &points);
        while !points.is_empty() {
            for _ in 0..30.min(points.len()) {
                points.swap_remove(numbers.below(points.len()));
            }
            update(&mut *index, &points);
            assert_agrees(&*index, &points);
        }
    }

    #[test]
    fn a_rebuild_forgets_the_old_points(
        (grid, dimension) in any_grid(),
        (first, second) in (prop::sample::select(&LAYOUTS[..]), prop::sample::select(&LAYOUTS[..])),
        (before, after) in (0usize..300, 0usize..300),
        seed: u64,
        kind in prop::sample::select(&KINDS[..]),
    ) {
        let mut index = built(&grid, kind, &points(first, &grid, dimension, before, seed));
        let points = points(second, &grid, dimension, after, !seed);
        index.rebuild(&points, two_threads()).expect("a box that fits");
        assert_agrees(&*index, &points);
    }

    #[test]
    fn points_that_are_not_finite_have_no_neighbours_and_harm_nobody(
        (grid, dimension) in any_grid(),
        seed: u64,
        kind in prop::sample::select(&KINDS[..]),
        broken in prop::collection::vec((0usize..150, 0usize..3, 0usize..5), 1..20),
    ) {
        const VALUES: [f32; 5] = [f32::NAN, f32::INFINITY, f32::NEG_INFINITY, f32::MAX, f32::MIN];
        let far = [Kind::Uniform, Kind::IndexSort, Kind::ZIndexSort].contains(&kind);
        let mut points = points(Layout::Even, &grid, dimension, 150, seed);
        let mut index = structure(&grid, kind);
        update(&mut *index, &points);
        for &(row, axis, value) in &broken {
            // A box around a finite point near the largest float is refused.
            points[row][axis] = VALUES[if far { value % 3 } else { value }];
        }
        update(&mut *index, &points);
        assert_sound(&*index, &points);
        let updated = own_lists(&*index, &points);
        index.rebuild(&points, two_threads()).expect("a box that fits");
        assert_sound(&*index, &points);
        let rebuilt = own_lists(&*index, &points);
        for (row, point) in points.iter().enumerate() {
            prop_assert!(point.is_finite() || updated[row].is_empty());
        }
        let expected = sorted(reference(&grid, &points));
        prop_assert_eq!(sorted(updated), expected.clone());
        prop_assert_eq!(sorted(rebuilt), expected);
    }

    #[test]
    fn neighbours_among_other_points_are_those_of_brute_force(
        (grid, dimension) in any_grid(),
        (layout, other_layout) in
            (prop::sample::select(&LAYOUTS[..]), prop::sample::select(&LAYOUTS[..])),
        (count, others) in (0usize..200, 0usize..200),
        seed: u64,
        (kind, among_kind) in
            (prop::sample::select(&KINDS[..]), prop::sample::select(&KINDS[..])),
    ) {
        // No box covers both.
        let boxed = [Kind::Uniform, Kind::IndexSort, Kind::ZIndexSort].contains(&among_kind);
        prop_assume!(!boxed || (layout == Layout::FarAway) == (other_layout == Layout::FarAway));
        let points = points(layout, &grid, dimension, count, seed);
        // Some points coincide and have the same row: they must not be excluded.
        let mut among_points = self::points(other_layout, &grid, dimension, others, !seed);
        for (other, point) in among_points.iter_mut().zip(&points).step_by(3) {
            *other = *point;
        }
        let of = built(&grid, kind, &points);
        let among = built(&grid, among_kind, &among_points);
        let mut brute = (BruteForce::new(grid.clone()), BruteForce::new(grid.clone()));
        brute.0.rebuild(&points, two_threads()).expect("no box");
        brute.1.rebuild(&among_points, two_threads()).expect("no box");
        let search = |of: &dyn SpatialIndex, among: &dyn SpatialIndex| {
            let (points, among_points) = (&points, &among_points);
            sorted(lists(Search { of, points, among, among_points, same: false }, two_threads()))
        };
        let found = search(&*of, &*among);
        for (row, list) in found.iter().enumerate().step_by(3).take_while(|(row, _)| *row < others) {
            prop_assert!(list.contains(&(row as u32)), "row {} of the other points", row);
        }
        prop_assert_eq!(found, search(&brute.0, &brute.1));
    }
}
