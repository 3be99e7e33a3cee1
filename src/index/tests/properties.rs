//! Properties of every structure, with random points, motion and structures.

use std::collections::HashSet;

use super::*;

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

    /// Sums fold their terms in this order. So it is that of a new index of the same points, and what else is indexed
    /// far away does not change it; but with spatial hashing, whose table has as many cells as all points ask for.
    #[test]
    fn the_order_of_a_list_follows_from_the_points_around_it(
        (grid, dimension) in any_grid(),
        seed: u64,
        kind in prop::sample::select(&KINDS[..]),
        (steps, count) in (1usize..8, prop::sample::select(&[12, 250][..])),
    ) {
        let mut points = points(Layout::Even, &grid, dimension, count, seed);
        let mut index = structure(&grid, kind);
        let mut numbers = Numbers(!seed);
        update(&mut *index, &points);
        for step in 0..steps {
            for point in &mut points {
                *point += match numbers.below(20) {
                    0 => numbers.point(dimension, H),
                    _ => numbers.point(dimension, 0.1 * H),
                };
            }
            if step % 3 == 1 {
                let (a, b) = (numbers.below(points.len()), numbers.below(points.len()));
                points.swap(a, b);
                points.truncate(points.len() - 1);
            }
            update(&mut *index, &points);
        }
        let lists = own_lists(&*index, &points);
        prop_assert_eq!(&lists, &own_lists(&*built(&grid, kind, &points), &points));
        if let Kind::SpatialHashing = kind {
            return Ok(());
        }
        // What a rank has: a part of the rows, and the others in the cells around theirs.
        let own = points.len() / 3..2 * points.len() / 3;
        let around: HashSet<IVec3> = points[own.clone()]
            .iter()
            .flat_map(|&x| grid.neighbourhood.iter().map(|&to| grid.cell_of(x) + to).collect::<Vec<_>>())
            .collect();
        let has = |row: &u32| around.contains(&grid.cell_of(points[*row as usize]));
        let rows: Vec<u32> = (0..points.len() as u32).filter(has).collect();
        let part: Vec<Vec4> = rows.iter().map(|&row| points[row as usize]).collect();
        let of_part = own_lists(&*built(&grid, kind, &part), &part);
        for (row, list) in rows.iter().zip(of_part).filter(|(row, _)| own.contains(&(**row as usize))) {
            let list: Vec<u32> = list.iter().map(|&k| rows[k as usize]).collect();
            prop_assert_eq!(&list, &lists[*row as usize], "row {}", row);
        }
    }
}
