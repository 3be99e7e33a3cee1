//! Compact hashing against the reference, through the search that the engine uses.

use std::sync::LazyLock;

use proptest::prelude::*;

use super::*;
use crate::{
    neighbours::{NeighbourLists, Search, search},
    scene::Dimension,
    simd::InstructionSet,
};

/// Support radius of all tests [m].
const H: f32 = 0.1;
const CELL_SIZES: [f32; 4] = [1.0, 0.5, 1.0 / 3.0, 0.7];
const DIMENSIONS: [Dimension; 2] = [Dimension::Two, Dimension::Three];

static THREADS: LazyLock<[Execution; 3]> =
    LazyLock::new(|| [1, 2, 3].map(|threads| Execution::new(threads).expect("threads")));

fn two_threads() -> &'static Execution {
    &THREADS[1]
}

/// The same cases in every run, and no files written where one fails.
fn cases(cases: u32) -> ProptestConfig {
    ProptestConfig {
        cases,
        failure_persistence: None,
        rng_seed: proptest::test_runner::RngSeed::Fixed(2011),
        ..ProptestConfig::default()
    }
}

/// A small generator: the same numbers everywhere.
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

/// How the points of a test lie.
#[derive(Debug, Clone, Copy)]
enum Layout {
    /// Like fluid: about thirty neighbours each.
    Even,
    /// A few dense clusters far apart.
    Clusters,
    /// All in one cell.
    OneCell,
    /// All in one place.
    OnePlace,
    /// On the lattice of the cells' corners, and pairs at exactly the support radius.
    CellCorners,
    /// As `Even`, 10 km away, where neighbouring floats are a hundredth of h apart.
    FarAway,
    /// Spray: hardly a neighbour, and cells that collide in the table.
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
            let cluster = [-40.0f32, 3.7, 55.1][numbers.below(3)];
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
    search(&task, &mut lists, false, execution);
    (0..task.points.len())
        .map(|row| lists.of(row).to_vec())
        .collect()
}

fn own_lists(index: &dyn SpatialIndex, points: &[Vec4]) -> Vec<Vec<u32>> {
    lists(among_themselves(index, points), two_threads())
}

fn among_themselves<'a>(index: &'a dyn SpatialIndex, points: &'a [Vec4]) -> Search<'a> {
    Search {
        of: index,
        points,
        among: index,
        among_points: points,
        same: true,
    }
}

fn sorted(mut lists: Vec<Vec<u32>>) -> Vec<Vec<u32>> {
    lists.iter_mut().for_each(|list| list.sort_unstable());
    lists
}

fn reference(grid: &Grid, points: &[Vec4]) -> Vec<Vec<u32>> {
    let mut brute = BruteForce::new(grid.clone());
    brute.rebuild(points, two_threads());
    own_lists(&brute, points)
}

/// Every row is in one place, no place is empty, groups cover a place and agree with the points, and the collision flag
/// is up exactly where a place holds several spatial cells.
fn assert_sound(index: &CompactHashing, points: &[Vec4]) {
    let mut seen = vec![0; points.len()];
    let mut collisions = 0;
    for cell in 0..index.cells() {
        assert!(index.cell_len(cell) > 0, "place {cell} is empty");
        let (mut done, mut groups) = (0, 0);
        while let Some((coordinates, members)) = index.group(cell, done) {
            assert!(!members.is_empty());
            groups += 1;
            for &row in members {
                seen[row as usize] += 1;
                assert_eq!(index.grid().cell_of(points[row as usize]), coordinates);
            }
            done += members.len();
        }
        assert_eq!(done, index.cell_len(cell));
        collisions += usize::from(groups > 1);
    }
    let share = collisions as f32 / index.cells().max(1) as f32;
    assert_eq!(index.collision_share(), share);
    assert!(
        seen.iter().all(|&count| count == 1),
        "rows by place: {seen:?}"
    );
    let total: usize = (0..index.cells()).map(|cell| index.cell_len(cell)).sum();
    assert_eq!(total, points.len());
}

/// Soundness, the same sets as the reference, and no row twice in a list.
fn assert_agrees(index: &CompactHashing, points: &[Vec4]) {
    assert_sound(index, points);
    let found = sorted(own_lists(index, points));
    assert_eq!(found, sorted(reference(index.grid(), points)));
}

fn structure(grid: &Grid, smallest_table: bool) -> CompactHashing {
    if smallest_table {
        CompactHashing::with_smallest_table(grid.clone(), 8.0)
    } else {
        CompactHashing::new(grid.clone(), 8.0)
    }
}

/// A grid of any kind.
fn any_grid() -> impl Strategy<Value = (Grid, Dimension)> {
    (
        prop::sample::select(&CELL_SIZES[..]),
        prop::sample::select(&DIMENSIONS[..]),
    )
        .prop_map(|(cell_size, dimension)| (Grid::new(dimension, H, cell_size), dimension))
}

proptest! {
    #![proptest_config(cases(160))]

    #[test]
    fn compact_hashing_finds_the_neighbours_that_brute_force_finds(
        (grid, dimension) in any_grid(),
        layout in prop::sample::select(&LAYOUTS[..]),
        count in 0usize..400,
        seed: u64,
        smallest_table: bool,
    ) {
        let points = points(layout, &grid, dimension, count, seed);
        let mut index = structure(&grid, smallest_table);
        index.rebuild(&points, two_threads());
        assert_agrees(&index, &points);
    }

    #[test]
    fn any_motion_leaves_the_index_as_a_new_one_would_be(
        (grid, dimension) in any_grid(),
        layout in prop::sample::select(&LAYOUTS[..]),
        seed: u64,
        smallest_table: bool,
        steps in 1usize..12,
    ) {
        let mut points = points(layout, &grid, dimension, 250, seed);
        let mut index = structure(&grid, smallest_table);
        let mut numbers = Numbers(!seed);
        index.update(&points, two_threads());
        for _ in 0..steps {
            // Few enough jumpers that the index is changed, not built anew.
            for point in &mut points {
                *point += match numbers.below(20) {
                    0 => numbers.point(dimension, 100.0),
                    1 => numbers.point(dimension, H),
                    _ => numbers.point(dimension, 0.02 * H),
                };
            }
            index.update(&points, two_threads());
            assert_sound(&index, &points);
        }
        assert_agrees(&index, &points);
    }

    #[test]
    fn points_come_and_go(
        (grid, dimension) in any_grid(),
        seed: u64,
        smallest_table: bool,
        counts in prop::collection::vec(0usize..300, 1..10),
    ) {
        let all = points(Layout::Even, &grid, dimension, 300, seed);
        let mut index = structure(&grid, smallest_table);
        for count in counts {
            index.update(&all[..count], two_threads());
            assert_agrees(&index, &all[..count]);
        }
    }

    #[test]
    fn despawning_by_swapping_with_the_last_row_is_followed(
        (grid, dimension) in any_grid(),
        seed: u64,
        smallest_table: bool,
    ) {
        let mut points = points(Layout::Even, &grid, dimension, 200, seed);
        let mut index = structure(&grid, smallest_table);
        let mut numbers = Numbers(seed);
        index.update(&points, two_threads());
        while !points.is_empty() {
            for _ in 0..30.min(points.len()) {
                points.swap_remove(numbers.below(points.len()));
            }
            index.update(&points, two_threads());
            assert_agrees(&index, &points);
        }
    }

    #[test]
    fn a_rebuild_forgets_the_old_points(
        (grid, dimension) in any_grid(),
        (first, second) in (prop::sample::select(&LAYOUTS[..]), prop::sample::select(&LAYOUTS[..])),
        (before, after) in (0usize..300, 0usize..300),
        seed: u64,
    ) {
        let mut index = structure(&grid, false);
        index.update(&points(first, &grid, dimension, before, seed), two_threads());
        let points = points(second, &grid, dimension, after, !seed);
        index.rebuild(&points, two_threads());
        assert_agrees(&index, &points);
    }

    #[test]
    fn points_that_are_not_finite_have_no_neighbours_and_harm_nobody(
        (grid, dimension) in any_grid(),
        seed: u64,
        smallest_table: bool,
        broken in prop::collection::vec((0usize..150, 0usize..3, 0usize..5), 1..20),
    ) {
        const VALUES: [f32; 5] = [f32::NAN, f32::INFINITY, f32::NEG_INFINITY, f32::MAX, f32::MIN];
        let mut points = points(Layout::Even, &grid, dimension, 150, seed);
        let mut index = structure(&grid, smallest_table);
        index.update(&points, two_threads());
        for &(row, axis, value) in &broken {
            points[row][axis] = VALUES[value];
        }
        index.update(&points, two_threads());
        assert_sound(&index, &points);
        let updated = own_lists(&index, &points);
        index.rebuild(&points, two_threads());
        assert_sound(&index, &points);
        let rebuilt = own_lists(&index, &points);
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
        smallest_table: bool,
    ) {
        let points = points(layout, &grid, dimension, count, seed);
        // Some in the same place, under the same row: no reason to leave them out.
        let mut among_points = self::points(other_layout, &grid, dimension, others, !seed);
        for (other, point) in among_points.iter_mut().zip(&points).step_by(3) {
            *other = *point;
        }
        let mut of = structure(&grid, smallest_table);
        let mut among = structure(&grid, !smallest_table);
        let mut brute = (BruteForce::new(grid.clone()), BruteForce::new(grid.clone()));
        of.rebuild(&points, two_threads());
        among.rebuild(&among_points, two_threads());
        brute.0.rebuild(&points, two_threads());
        brute.1.rebuild(&among_points, two_threads());
        let search = |of: &dyn SpatialIndex, among: &dyn SpatialIndex| {
            let (points, among_points) = (&points, &among_points);
            sorted(lists(Search { of, points, among, among_points, same: false }, two_threads()))
        };
        let found = search(&of, &among);
        for (row, list) in found.iter().enumerate().step_by(3).take_while(|(row, _)| *row < others) {
            prop_assert!(list.contains(&(row as u32)), "row {} of the other points", row);
        }
        prop_assert_eq!(found, search(&brute.0, &brute.1));
    }
}

/// A few thousand points, so that there are many blocks of cells and several chunks of rows.
fn many_points(seed: u64) -> Vec<Vec4> {
    let grid = Grid::new(Dimension::Three, H, 1.0);
    let mut points = points(Layout::Even, &grid, Dimension::Three, 3000, seed);
    points.extend(self::points(
        Layout::Clusters,
        &grid,
        Dimension::Three,
        1000,
        seed,
    ));
    points
}

/// Lists after motion through updates, with the regions of the flat array kept from step to step.
fn lists_after_motion(execution: &Execution, smallest_table: bool) -> Vec<Vec<Vec<u32>>> {
    let mut points = many_points(7);
    let mut numbers = Numbers(11);
    let mut index = structure(&Grid::new(Dimension::Three, H, 1.0), smallest_table);
    let mut lists = NeighbourLists::default();
    let step = |_| {
        for point in &mut points {
            *point += numbers.point(Dimension::Three, 0.2 * H);
        }
        index.update(&points, execution);
        search(
            &among_themselves(&index, &points),
            &mut lists,
            true,
            execution,
        );
        let found: Vec<_> = (0..points.len()).map(|row| lists.of(row).into()).collect();
        assert_eq!(lists.pairs(), found.iter().map(Vec::len).sum::<usize>());
        found
    };
    (0..6).map(step).collect()
}

#[test]
fn lists_do_not_depend_on_the_number_of_threads() {
    for smallest_table in [false, true] {
        let expected = lists_after_motion(&THREADS[0], smallest_table);
        for execution in &THREADS[1..] {
            let found = lists_after_motion(execution, smallest_table);
            assert!(found == expected, "{} threads", execution.threads());
        }
    }
}

#[test]
fn lists_do_not_depend_on_the_instruction_set() {
    let with = |instruction_set: InstructionSet| {
        let mut execution = two_threads().clone();
        execution.instruction_set = instruction_set;
        lists_after_motion(&execution, false)
    };
    let expected = with(InstructionSet::Portable);
    for set in InstructionSet::available() {
        assert!(with(set) == expected, "{set:?}");
    }
}

#[test]
fn regions_kept_from_the_last_search_do_not_change_the_lists() {
    let grid = Grid::new(Dimension::Three, H, 1.0);
    let mut lists = NeighbourLists::default();
    // Sparse, then dense beyond every region, then fewer points, none, and many again.
    for (layout, count) in [
        (Layout::Spray, 1000),
        (Layout::OneCell, 1000),
        (Layout::Even, 300),
        (Layout::Even, 0),
        (Layout::OnePlace, 1),
        (Layout::Clusters, 1500),
        (Layout::Even, 1500),
    ] {
        let points = points(layout, &grid, Dimension::Three, count, 5);
        let mut index = structure(&grid, false);
        index.rebuild(&points, two_threads());
        let expected = own_lists(&index, &points);
        for same_cells in [true, false, true] {
            search(
                &among_themselves(&index, &points),
                &mut lists,
                same_cells,
                two_threads(),
            );
            let found: Vec<_> = (0..count).map(|row| lists.of(row).to_vec()).collect();
            assert!(found == expected, "{layout:?} of {count}, {same_cells}");
            assert_eq!(lists.pairs(), expected.iter().map(Vec::len).sum::<usize>());
        }
    }
}

#[test]
fn the_ball_is_closed_and_a_row_is_not_its_own_neighbour() {
    // 0.25 and its multiples are exact: the pair is at the support radius to the bit.
    let h = 0.25;
    for cell_size in CELL_SIZES {
        let grid = Grid::new(Dimension::Three, h, cell_size);
        for origin in [0.0, -0.25, 3.0, -1024.0] {
            let points = [0.0, h, 2.0 * h, h + 1e-4].map(|x| Vec4::new(origin + x, 0.0, 0.0, 0.0));
            let mut index = structure(&grid, false);
            index.rebuild(&points, two_threads());
            let lists = sorted(own_lists(&index, &points));
            assert_eq!(lists, [vec![1], vec![0, 2, 3], vec![1, 3], vec![1, 2]]);
        }
    }
}

#[test]
fn an_index_without_points_is_empty_and_usable() {
    for smallest_table in [false, true] {
        let mut index = structure(&Grid::new(Dimension::Three, H, 1.0), smallest_table);
        for points in [&[][..], &[Vec4::ZERO], &[], &[]] {
            index.update(points, two_threads());
            assert_eq!(index.cells(), points.len());
            assert_agrees(&index, points);
        }
    }
}

#[test]
fn the_smallest_table_makes_cells_collide() {
    let grid = Grid::new(Dimension::Three, H, 1.0);
    let points = points(Layout::Spray, &grid, Dimension::Three, 500, 1);
    let share = |smallest_table| {
        let mut index = structure(&grid, smallest_table);
        index.rebuild(&points, two_threads());
        index.collision_share()
    };
    assert_eq!(share(true), 1.0);
    assert!(share(false) < 0.5, "{}", share(false));
}

#[test]
fn a_rebuilt_index_lists_its_cells_along_the_z_curve() {
    let grid = Grid::new(Dimension::Three, H, 1.0);
    let points = many_points(3);
    let mut index = structure(&grid, false);
    index.rebuild(&points, two_threads());
    let origin = points
        .iter()
        .map(|&point| grid.cell_of(point))
        .reduce(IVec3::min)
        .expect("points");
    // Each place's first point opened it.
    let keys: Vec<u64> = (0..index.cells())
        .filter_map(|cell| index.group(cell, 0))
        .map(|(cell, _)| z_curve::key(cell, origin))
        .collect();
    assert!(keys.is_sorted());
}

#[test]
fn repeated_motion_does_not_leak_memory() {
    let grid = Grid::new(Dimension::Three, H, 1.0);
    let mut index = structure(&grid, false);
    let mut points = points(Layout::Even, &grid, Dimension::Three, 2000, 1);
    let mut step = |count: usize| {
        for _ in 0..count {
            for point in &mut points {
                point.x += 0.15 * H;
            }
            index.update(&points, two_threads());
        }
        index.bytes()
    };
    let early = step(50);
    let late = step(400);
    assert!(late <= 2 * early, "{early} bytes, then {late}");
}
