use super::*;

/// A small generator: the same numbers everywhere.
fn numbers(seed: u64) -> impl FnMut() -> f32 {
    let mut state = seed;
    move || {
        state = state
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        (state >> 40) as f32 / (1u64 << 24) as f32
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

struct Arithmetic<'a>(&'a [Vec4], &'a [u32]);

impl Vectorised for Arithmetic<'_> {
    type Output = [f32; 8];

    #[inline(always)]
    fn run<S: Simd>(self, simd: S) -> [f32; 8] {
        let (whole, rest) = self.1.split_at(LANES);
        let [x, y, z, w] = simd.gather(self.0, simd.rows(whole));
        let [tail, ..] = simd.gather(self.0, simd.rows(rest));
        [
            simd.sum(simd.add(x, y)),
            simd.sum(simd.sub(x, z)),
            simd.sum(simd.mul(y, w)),
            simd.sum(simd.div(x, simd.max(w, simd.splat(0.1)))),
            simd.sum(simd.min(x, y)),
            simd.sum(simd.sqrt(z)),
            simd.sum(tail),
            simd.sum(simd.mul_add(x, y, z)),
        ]
    }
}

#[test]
fn every_instruction_set_calculates_alike() {
    let mut next = numbers(5);
    let table: Vec<Vec4> = (0..40)
        .map(|_| Vec4::new(next(), next(), next(), next()))
        .collect();
    let rows = [3, 39, 7, 0, 12, 12, 31, 5, 9, 2, 77];
    let portable = InstructionSet::Portable.dispatch(Arithmetic(&table, &rows));
    let last = table[39].x;
    assert!(
        (portable[6] - (table[9].x + table[2].x + 6.0 * last)).abs() < 1e-5,
        "lanes without a row read the last entry"
    );
    for set in InstructionSet::available() {
        let other = set.dispatch(Arithmetic(&table, &rows));
        assert_eq!(other[..7], portable[..7], "{set:?}");
        assert!(
            (other[7] - portable[7]).abs() < 1e-5,
            "{set:?}: fused or not differs by rounding only"
        );
    }
}
