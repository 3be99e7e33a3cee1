use glam::Vec4;

use super::*;

/// A small random number generator with the same numbers on every machine.
fn numbers(seed: u64) -> impl FnMut() -> f32 {
    let mut state = seed;
    move || {
        state = state
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        (state >> 40) as f32 / (1u64 << 24) as f32
    }
}

/// `count` vectors of such numbers.
fn vectors(seed: u64, count: usize) -> Vec<Vec4> {
    let mut next = numbers(seed);
    let vector = |_| Vec4::new(next(), next(), next(), next());
    (0..count).map(vector).collect()
}

struct Insert(Vec<u32>, usize);

impl Vectorised for Insert {
    type Output = Vec<u32>;

    #[inline(always)]
    fn run<S: Simd>(mut self, simd: S) -> Vec<u32> {
        simd.insert(&mut self.0, self.1, [1000, 1001, 1002, 1003]);
        self.0
    }
}

#[test]
fn every_instruction_set_inserts_an_entry_into_each_column() {
    for pitch in [4, 8, 12, 16] {
        let block: Vec<u32> = (0..4 * pitch as u32).collect();
        for place in 0..pitch {
            let mut expected: Vec<u32> = Vec::new();
            for (column, words) in block.chunks(pitch).enumerate() {
                let mut words = words.to_vec();
                words.insert(place, 1000 + column as u32);
                expected.extend(&words[..pitch]);
            }
            for set in InstructionSet::available() {
                let inserted = set.dispatch(Insert(block.clone(), place));
                assert_eq!(inserted, expected, "{set:?} at {place} of {pitch}");
            }
        }
    }
}

struct Collect<'a>(&'a Candidates, Probe);

impl Vectorised for Collect<'_> {
    type Output = Vec<u32>;

    #[inline(always)]
    fn run<S: Simd>(self, simd: S) -> Vec<u32> {
        let mut hits = vec![0; self.0.padded_len() + CANDIDATE_ALIGNMENT];
        let count = simd.collect_hits(self.0, self.1, &mut hits);
        hits.truncate(count);
        hits
    }
}

#[test]
fn every_instruction_set_collects_the_same_hits() {
    let mut next = numbers(3);
    for len in [0, 1, 7, 8, 9, 16, 31, 216] {
        let points: Vec<Vec4> = (0..len)
            .map(|_| Vec4::new(next(), next(), next(), 0.0))
            .collect();
        let rows: Vec<u32> = (0..len as u32).collect();
        let mut candidates = Candidates::default();
        candidates.extend(&rows, &points);
        candidates.pad();
        let probe = Probe {
            center: [0.5; 3],
            radius_squared: 0.2,
            own_row: 3,
        };
        let expected: Vec<u32> = rows
            .iter()
            .copied()
            .filter(|&row| {
                let d = points[row as usize] - Vec4::new(0.5, 0.5, 0.5, 0.0);
                row != 3 && d.x * d.x + d.y * d.y + d.z * d.z <= 0.2
            })
            .collect();
        for set in InstructionSet::available() {
            assert_eq!(
                set.dispatch(Collect(&candidates, probe)),
                expected,
                "{set:?} of {len}"
            );
        }
    }
}

struct Take<'a>(Near, (&'a [u32], usize), &'a [Run]);

impl Vectorised for Take<'_> {
    type Output = Vec<u32>;

    #[inline(always)]
    fn run<S: Simd>(self, simd: S) -> Vec<u32> {
        let mut candidates = Candidates::default();
        // Called twice: existing candidates must be kept.
        simd.take_near(&mut candidates, self.0, self.1, &self.2[..1]);
        simd.take_near(&mut candidates, self.0, self.1, &self.2[1..]);
        let len = candidates.len();
        candidates.pad();
        let ([x, y, z], rows) = candidates.columns();
        assert!(x[len..].iter().all(|x| *x == f32::INFINITY));
        for (k, &row) in rows[..len].iter().enumerate() {
            let [px, py, pz] = [0, 1, 2].map(|axis| self.1.0[row as usize + axis * self.1.1]);
            assert_eq!([x[k], y[k], z[k]].map(f32::to_bits), [px, py, pz]);
        }
        rows[..len].to_vec()
    }
}

#[test]
fn runs_beyond_their_block_are_never_read() {
    let words = [1.0_f32.to_bits(); 64];
    let run = |start, len| [Run { start, len }, Run { start: 0, len: 0 }];
    for (pitch, runs) in [
        (8, run(64, 8)),
        (8, run(u32::MAX, 8)),
        (8, run(u32::MAX - 3, 4)),
        (64, run(0, 1)),
        (usize::MAX / 3, run(0, 8)),
        (usize::MAX / 3 + 1, run(0, 8)),
        (usize::MAX / 2 + 1, run(8, 8)),
        (usize::MAX, run(3, 8)),
    ] {
        for set in InstructionSet::available() {
            let take = || set.dispatch(Take(Near::ALL, (&words, pitch), &runs));
            assert!(
                std::panic::catch_unwind(take).is_err(),
                "{set:?}: {pitch}, {runs:?}"
            );
        }
    }
}

#[test]
fn every_instruction_set_takes_the_same_candidates() {
    const PITCH: usize = 100;
    let mut next = numbers(7);
    let mut words: Vec<u32> = (0..3 * PITCH).map(|_| next().to_bits()).collect();
    words[11] = f32::NAN.to_bits();
    words.extend(0..PITCH as u32);
    words.extend([u32::MAX; CANDIDATE_ALIGNMENT]);
    let runs = [(0, 1), (3, 8), (11, 17), (40, 0), (41, 16), (60, 40)];
    let runs = runs.map(|(start, len)| Run { start, len });
    let near = Near {
        low: [0.4, 0.2, 0.5],
        high: [0.6, 0.5, 0.5],
        radius_squared: 0.09,
    };
    let outside = |row: u32, axis: usize| {
        let x = f32::from_bits(words[row as usize + axis * PITCH]);
        (near.low[axis] - x).max(x - near.high[axis]).max(0.0)
    };
    let rows = runs.iter().flat_map(|run| run.start..run.start + run.len);
    let expected: Vec<u32> = rows
        .clone()
        .filter(|&row| (0..3).map(|axis| outside(row, axis).powi(2)).sum::<f32>() <= 0.09)
        .collect();
    assert!(expected.len() > 10 && expected.len() < 60);
    for set in InstructionSet::available() {
        let found = set.dispatch(Take(near, (&words, PITCH), &runs));
        assert_eq!(found, expected, "{set:?}");
        let all = set.dispatch(Take(Near::ALL, (&words, PITCH), &runs));
        assert_eq!(all, rows.clone().collect::<Vec<_>>(), "{set:?}");
    }
}

struct Arithmetic<'a>(&'a [Vec4], &'a [u32]);

impl Vectorised for Arithmetic<'_> {
    type Output = [f32; 10];

    #[inline(always)]
    fn run<S: Simd>(self, simd: S) -> [f32; 10] {
        let (whole, rest) = self.1.split_at(LANES);
        let [x, y, z, w] = simd.gather(self.0, simd.rows(whole));
        let [tail, ..] = simd.gather(self.0, simd.rows(rest));
        let mut memory = Lanes::default();
        simd.store(simd.mul(x, z), &mut memory);
        [
            simd.sum(simd.add(x, y)),
            simd.sum(simd.sub(x, z)),
            simd.sum(simd.mul(y, w)),
            simd.sum(simd.div(x, simd.max(w, simd.splat(0.1)))),
            simd.sum(simd.min(x, y)),
            simd.sum(simd.sqrt(z)),
            simd.sum(tail),
            simd.sum(simd.add(y, simd.load(&memory))),
            simd.sum_vectors(simd.sub(y, simd.splat_vector(self.0[0]))),
            simd.sum(simd.mul_add(x, y, z)),
        ]
    }
}

#[test]
fn every_instruction_set_calculates_alike() {
    let table = vectors(5, 40);
    let rows = [3, 39, 7, 0, 12, 12, 31, 5, 9, 2, 77];
    let portable = InstructionSet::Portable.dispatch(Arithmetic(&table, &rows));
    let last = table[39].x;
    assert!(
        (portable[6] - (table[9].x + table[2].x + 6.0 * last)).abs() < 1e-5,
        "lanes without a row read the last entry"
    );
    for set in InstructionSet::available() {
        let other = set.dispatch(Arithmetic(&table, &rows));
        assert_eq!(other[..9], portable[..9], "{set:?}");
        assert!(
            (other[9] - portable[9]).abs() < 1e-5,
            "{set:?}: fused or not differs by rounding only"
        );
    }
}

struct Products<'a>([&'a [Vec4]; 2], &'a [u32]);

impl Vectorised for Products<'_> {
    type Output = f32;

    #[inline(always)]
    fn run<S: Simd>(self, simd: S) -> f32 {
        let Self(tables, list) = self;
        let own = tables.map(|table| simd.splat_vector(table[0]));
        let [factor, ..] = simd.gather(tables[0], simd.rows(list));
        let sum = simd.splat_vector(Vec4::new(1.0, 2.0, 3.0, f32::NAN));
        simd.sum_vectors(simd.add_products(tables, own, simd.rows(list), factor, sum))
    }
}

#[test]
fn every_instruction_set_sums_products_of_vectors() {
    let table = vectors(13, 80);
    let tables = [&table[..40], &table[40..79]];
    for list in [
        &[3, 38, 7, 0, 12, 12, 31, 5][..],
        &[9, 2, 77],
        &[0, 0, 0, 0, 8],
    ] {
        // For rows beyond the shorter table both tables read its last entry.
        let rows = (0..LANES).map(|lane| list.get(lane).map_or(38, |&row| (row as usize).min(38)));
        let factors =
            (0..LANES).map(|lane| list.get(lane).map_or(39, |&row| (row as usize).min(39)));
        let expected = 12.0
            + rows
                .zip(factors)
                .map(|(row, factor)| {
                    let [x, y] = tables.map(|table| (table[0] - table[row]).truncate().as_dvec3());
                    f64::from(tables[0][factor].x) * x.dot(y)
                })
                .sum::<f64>();
        let sums = InstructionSet::available()
            .into_iter()
            .map(|set| (set, set.dispatch(Products(tables, list))));
        let sums: Vec<_> = sums.collect();
        for &(set, sum) in &sums {
            assert!(
                (f64::from(sum) - expected).abs() < 1e-5,
                "{set:?}: {sum}, {expected}"
            );
        }
        let portable_fuses = cfg!(any(target_feature = "fma", target_arch = "aarch64"));
        let fused = sums
            .iter()
            .filter(|(set, _)| portable_fuses || *set != InstructionSet::Portable);
        let bits: Vec<u32> = fused.map(|(_, sum)| sum.to_bits()).collect();
        assert!(bits.windows(2).all(|pair| pair[0] == pair[1]), "{sums:?}");
    }
}

struct Masks<'a>(&'a [Vec4], &'a [u32], Cube);

impl Vectorised for Masks<'_> {
    type Output = (u32, u32, u32, Vec<f32>, Vec<u32>);

    #[inline(always)]
    fn run<S: Simd>(self, simd: S) -> Self::Output {
        let Self(table, list, cube) = self;
        let rows = simd.rows(list);
        let [x, y, z, _] = simd.gather(table, rows);
        let inside = simd.inside([x, y, z], cube);
        let mut compressed = Lanes::default();
        simd.store(simd.compress(x, inside), &mut compressed);
        let count = inside.count_ones() as usize;
        (
            inside,
            simd.below(rows, 5),
            simd.below(rows, u32::MAX) | simd.below(rows, 0) << LANES,
            compressed.0[..count].to_vec(),
            simd.compress_rows(rows, inside)[..count].to_vec(),
        )
    }
}

#[test]
fn every_instruction_set_masks_and_compresses_alike() {
    let mut next = numbers(11);
    let mut table: Vec<Vec4> = (0..64)
        .map(|_| Vec4::new(next(), next(), next(), 0.0))
        .collect();
    table[3].y = f32::NAN;
    // On the face of the cube, which is open: not inside.
    table[4] = Vec4::new(0.9, 0.5, 0.5, 0.0);
    let cube = Cube {
        center: [0.5; 3],
        half: 0.4,
    };
    let is_inside = |row: u32| {
        let point = table.get(row as usize).unwrap_or(&table[63]);
        (point.truncate() - 0.5)
            .abs()
            .cmplt(glam::Vec3::splat(0.4))
            .all()
    };
    let mask = |list: &[u32], holds: &dyn Fn(u32) -> bool| {
        let lane = |lane: usize| u32::from(holds(*list.get(lane).unwrap_or(&u32::MAX))) << lane;
        (0..LANES).map(lane).sum::<u32>()
    };
    for list in [
        &[0, 1, 2, 3, 4, 5, 6, 7][..],
        &[9, 4, 3],
        &[60, 61, u32::MAX, 2],
        &[40, 41, 42, 43, 44, 45, 46, 47],
    ] {
        let inside = mask(list, &is_inside);
        let rows: Vec<u32> = (0..LANES)
            .map(|lane| *list.get(lane).unwrap_or(&u32::MAX))
            .filter(|&row| is_inside(row))
            .collect();
        let xs: Vec<f32> = rows
            .iter()
            .map(|&row| table.get(row as usize).unwrap_or(&table[63]).x)
            .collect();
        let expected = (
            inside,
            mask(list, &|row| row < 5),
            mask(list, &|row| row != u32::MAX),
            xs,
            rows,
        );
        for set in InstructionSet::available() {
            assert_eq!(set.dispatch(Masks(&table, list, cube)), expected, "{set:?}");
        }
    }
}
