//! Named cases: many points, several threads, unusual inputs.

use super::*;
use crate::scene::RowOrder;

/// A few thousand points: many blocks of cells and several chunks of rows.
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

/// Lists after several updates; the regions of the flat array are kept between steps.
fn lists_after_motion(execution: &Execution, kind: Kind) -> Vec<Vec<Vec<u32>>> {
    let mut points = many_points(7);
    let mut numbers = Numbers(11);
    let mut index = structure(&Grid::new(Dimension::Three, H, 1.0), kind);
    let mut lists = NeighbourLists::default();
    let step = |_| {
        for point in &mut points {
            *point += numbers.point(Dimension::Three, 0.2 * H);
        }
        index.update(&points, execution).expect("a box that fits");
        let task = Search::among_themselves(&*index, &points);
        search(&task, &mut lists, execution).expect("short lists");
        let found: Vec<_> = (0..points.len()).map(|row| lists.of(row).into()).collect();
        assert_eq!(lists.pairs(), found.iter().map(Vec::len).sum::<usize>());
        found
    };
    (0..6).map(step).collect()
}

#[test]
fn lists_do_not_depend_on_the_number_of_threads() {
    for kind in KINDS {
        let expected = lists_after_motion(&THREADS[0], kind);
        for execution in &THREADS[1..] {
            let found = lists_after_motion(execution, kind);
            assert!(
                found == expected,
                "{kind:?}, {} threads",
                execution.threads()
            );
        }
    }
}

#[test]
fn lists_do_not_depend_on_the_instruction_set() {
    for kind in [Kind::SpatialHashing, Kind::CompactHashing] {
        let with = |instruction_set: InstructionSet| {
            let mut execution = two_threads().clone();
            execution.instruction_set = instruction_set;
            lists_after_motion(&execution, kind)
        };
        let expected = with(InstructionSet::Portable);
        for set in InstructionSet::available() {
            assert!(with(set) == expected, "{kind:?}, {set:?}");
        }
    }
}

#[test]
fn regions_kept_from_the_last_search_do_not_change_the_lists() {
    let grid = Grid::new(Dimension::Three, H, 1.0);
    for kind in KINDS {
        let mut lists = NeighbourLists::default();
        // Sparse, then denser than every region, then fewer points, none, and many again.
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
            let index = built(&grid, kind, &points);
            let expected = own_lists(&*index, &points);
            for time in 0..3 {
                let task = Search::among_themselves(&*index, &points);
                search(&task, &mut lists, two_threads()).expect("short lists");
                let found: Vec<_> = (0..count).map(|row| lists.of(row).to_vec()).collect();
                assert!(found == expected, "{kind:?}, {layout:?} of {count}, {time}");
                assert_eq!(lists.pairs(), expected.iter().map(Vec::len).sum::<usize>());
                lists.expect_order((0..count).rev());
            }
        }
    }
}

#[test]
fn lists_in_motion_take_four_bytes_a_neighbour_and_eight_a_row() {
    let execution = two_threads();
    let mut numbers = Numbers(11);
    for kind in [Kind::IndexSort, Kind::CompactHashing] {
        // Like fluid: a perturbed lattice of spacing h/2.
        let mut points: Vec<Vec4> = (0..30_000)
            .map(|k| {
                let place = IVec3::new(k % 30, k / 30 % 30, k / 900)
                    .as_vec3()
                    .extend(0.0);
                0.5 * H * place + numbers.point(Dimension::Three, 0.2 * H)
            })
            .collect();
        let mut index = structure(&Grid::new(Dimension::Three, H, 1.0), kind);
        let mut lists = NeighbourLists::default();
        for step in 0..4 {
            for point in &mut points {
                *point += numbers.point(Dimension::Three, 0.02 * H);
            }
            index.update(&points, execution).expect("a box that fits");
            let task = Search::among_themselves(&*index, &points);
            search(&task, &mut lists, execution).expect("short lists");
            let limit = 4 * lists.pairs() + 8 * points.len();
            // The first search does not know the lengths of the lists; the second has overflow from the first.
            assert!(
                step < 2 || lists.bytes() <= limit,
                "{kind:?}: {} of {limit}",
                lists.bytes()
            );
        }
    }
}

#[test]
fn a_list_that_is_too_long_is_refused_and_none_is_left() {
    let grid = Grid::new(Dimension::Three, H, 1.0);
    let many = vec![Vec4::ZERO; usize::from(u16::MAX) + 1];
    let mut lists = NeighbourLists::default();
    for (count, result) in [
        (many.len() - 1, Ok(())),
        (
            many.len(),
            Err(ListsTooLong::OfRow {
                row: 0,
                count: many.len(),
            }),
        ),
    ] {
        let among_points = &many[..count];
        let among = built(&grid, Kind::CompactHashing, among_points);
        let task = Search {
            of: &*built(&grid, Kind::CompactHashing, &many[..1]),
            points: &many[..1],
            among: &*among,
            among_points,
            same: false,
        };
        assert_eq!(search(&task, &mut lists, two_threads()), result);
        assert_eq!(lists.of(0).len(), if result.is_ok() { count } else { 0 });
    }
}

#[test]
fn the_ball_is_closed_and_a_row_is_not_its_own_neighbour() {
    // 0.25 and its multiples are exact: the pair is exactly at the support radius.
    let h = 0.25;
    for (kind, cell_size) in KINDS.into_iter().zip(CELL_SIZES.into_iter().cycle()) {
        let grid = Grid::new(Dimension::Three, h, cell_size);
        for origin in [0.0, -0.25, 3.0, -1024.0] {
            let points = [0.0, h, 2.0 * h, h + 1e-4].map(|x| Vec4::new(origin + x, 0.0, 0.0, 0.0));
            let index = built(&grid, kind, &points);
            let lists = sorted(own_lists(&*index, &points));
            assert_eq!(lists, [vec![1], vec![0, 2, 3], vec![1, 3], vec![1, 2]]);
        }
    }
}

#[test]
fn an_index_without_points_is_empty_and_usable() {
    for kind in KINDS {
        let mut index = structure(&Grid::new(Dimension::Three, H, 1.0), kind);
        assert_agrees(&*index, &[]);
        for points in [&[][..], &[Vec4::ZERO], &[], &[], &[Vec4::splat(1e4)]] {
            update(&mut *index, points);
            assert_eq!(index.partitions(), points.len());
            assert_agrees(&*index, points);
        }
    }
}

#[test]
fn the_smallest_table_makes_cells_collide_and_the_flags_follow() {
    let grid = Grid::new(Dimension::Three, H, 1.0);
    let mut points = points(Layout::Spray, &grid, Dimension::Three, 500, 1);
    let mut large = CompactHashing::new(grid.clone(), 8.0);
    let mut small = CompactHashing::with_smallest_table(grid, 8.0);
    let mut numbers = Numbers(2);
    // First fast motion (the index is rebuilt), then slow motion (points leave and enter, also both in one used cell).
    for step in 0..200 {
        for index in [&mut large, &mut small] {
            update(index, &points);
            assert_flags(index);
        }
        if step == 0 {
            assert_eq!(small.collision_share(), 1.0);
            assert!((0.0..0.5).contains(&large.collision_share()));
        }
        for point in &mut points {
            let motion = if step < 10 { 0.5 } else { 0.1 };
            *point += numbers.point(Dimension::Three, motion * H);
        }
    }
}

#[test]
fn points_that_come_from_afar_find_cells_that_change_hands() {
    // Thousands of cells with one or two points: in one step some share a used cell, lose their last point, change
    // their primary cell and receive a point from another chunk of blocks.
    let grid = Grid::new(Dimension::Three, H, 1.0);
    let mut numbers = Numbers(11);
    let point = |numbers: &mut Numbers| numbers.point(Dimension::Three, 16.0 * H);
    let mut points: Vec<Vec4> = (0..6000).map(|_| point(&mut numbers)).collect();
    let mut index = structure(&grid, Kind::CompactHashing);
    update(&mut *index, &points);
    for _ in 0..20 {
        // Few enough that the index is updated, not rebuilt.
        for place in &mut points {
            if numbers.below(5) == 0 {
                *place = point(&mut numbers);
            }
        }
        update(&mut *index, &points);
        assert_sound(&*index, &points);
    }
    assert_agrees(&*index, &points);
}

#[test]
fn a_rebuild_from_rows_along_the_z_curve_lists_its_cells_along_it() {
    let grid = Grid::new(Dimension::Three, H, 1.0);
    let points = many_points(3);
    let mut handles = Vec::new();
    z_curve::sort_handles(
        &points,
        (&grid, RowOrder::ZCurve),
        two_threads(),
        &mut handles,
    );
    let points: Vec<Vec4> = handles
        .iter()
        .map(|&(_, row)| points[row as usize])
        .collect();
    let index = built(&grid, Kind::CompactHashing, &points);
    let origin = points
        .iter()
        .map(|&point| grid.cell_of(point))
        .reduce(IVec3::min)
        .expect("points");
    // The first point of each partition created it.
    let keys: Vec<u64> = (0..index.partitions())
        .filter_map(|partition| index.next_cell(partition, 0))
        .map(|(cell, _)| z_curve::key(cell, origin))
        .collect();
    assert!(keys.is_sorted());
}

#[test]
fn repeated_motion_does_not_leak_memory() {
    for kind in KINDS {
        let grid = Grid::new(Dimension::Three, H, 1.0);
        let mut index = structure(&grid, kind);
        let mut points = points(Layout::Even, &grid, Dimension::Three, 2000, 1);
        let mut step = |count: usize| {
            for _ in 0..count {
                for point in &mut points {
                    point.x += 0.15 * H;
                }
                update(&mut *index, &points);
            }
            index.bytes()
        };
        let early = step(50);
        let late = step(200);
        assert!(late <= 2 * early, "{kind:?}: {early} bytes, then {late}");
    }
}

#[test]
fn a_box_that_would_not_fit_in_memory_is_refused_and_a_smaller_one_taken_again() {
    let grid = Grid::new(Dimension::Three, H, 1.0);
    let near = points(Layout::Even, &grid, Dimension::Three, 300, 1);
    let mut far = near.clone();
    // About 600 cells along every axis fit, 6 million do not.
    far[17] = Vec4::new(6e5, -6e5, 6e5, 0.0);
    for kind in [Kind::Uniform, Kind::IndexSort, Kind::ZIndexSort] {
        let mut index = built(&grid, kind, &near);
        let before = index.bytes();
        let error = index.update(&far, two_threads()).expect_err("too large");
        assert_eq!(error.row, 17);
        assert!(
            error.cells.iter().all(|&cells| cells > 5_000_000),
            "{error}"
        );
        assert!(error.to_string().contains("CompactHashing"), "{error}");
        assert_eq!(index.bytes(), before);
        index.update(&near, two_threads()).expect("as before");
        assert_agrees(&*index, &near);
        let mut large = near.clone();
        large[3] = Vec4::new(15.0, 12.0, 18.0, 0.0);
        index.update(&large, two_threads()).expect("it fits");
        assert_agrees(&*index, &large);
    }
}
