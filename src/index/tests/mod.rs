//! Compares every structure with the reference, through the search that the engine uses.

mod cases;
mod periodic;
mod properties;

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
