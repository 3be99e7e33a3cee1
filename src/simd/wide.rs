//! The two loops of the search over candidates, written once for eight and for sixteen lanes.
#![allow(unsafe_code, reason = "intrinsics; every block says why it may")]

use std::arch::x86_64::*;

use super::candidates::{Candidates, Near, Probe, Run};

/// A vector of the search, for two widths. Its lanes are numbers, or rows as bits.
pub(super) trait Wide: Copy {
    const LANES: usize;
    /// `x` in every lane.
    unsafe fn splat(x: f32) -> Self;
    /// [`LANES`](Self::LANES) words starting at `from`.
    unsafe fn load(from: *const u32) -> Self;
    unsafe fn add(a: Self, b: Self) -> Self;
    unsafe fn sub(a: Self, b: Self) -> Self;
    unsafe fn mul(a: Self, b: Self) -> Self;
    unsafe fn max(a: Self, b: Self) -> Self;
    /// The lanes in which a ≤ b, one bit each.
    unsafe fn at_most(a: Self, b: Self) -> u32;
    /// The lanes that do not hold `row`, one bit each.
    unsafe fn differs(a: Self, row: u32) -> u32;
    /// Writes [`LANES`](Self::LANES) words: the lanes of `mask` first, in their order.
    unsafe fn compress(a: Self, mask: u32, to: *mut u32);
}

/// The operations of [`Wide`] that are one intrinsic.
macro_rules! wide_intrinsic {
    ($(fn $name:ident = $intrinsic:ident;)*) => { $(
        #[inline(always)]
        unsafe fn $name(a: Self, b: Self) -> Self {
            // SAFETY: the caller has the instructions.
            unsafe { $intrinsic(a, b) }
        }
    )* };
}

impl Wide for __m256 {
    const LANES: usize = 8;

    wide_intrinsic! {
        fn add = _mm256_add_ps;
        fn sub = _mm256_sub_ps;
        fn mul = _mm256_mul_ps;
        fn max = _mm256_max_ps;
    }

    #[inline(always)]
    unsafe fn splat(x: f32) -> Self {
        // SAFETY: the caller has AVX2.
        unsafe { _mm256_set1_ps(x) }
    }

    #[inline(always)]
    unsafe fn load(from: *const u32) -> Self {
        // SAFETY: the caller has AVX2 and eight words there.
        unsafe { _mm256_loadu_ps(from.cast()) }
    }

    #[inline(always)]
    unsafe fn at_most(a: Self, b: Self) -> u32 {
        // SAFETY: the caller has AVX2.
        unsafe { _mm256_movemask_ps(_mm256_cmp_ps::<_CMP_LE_OQ>(a, b)) as u32 }
    }

    #[inline(always)]
    unsafe fn differs(a: Self, row: u32) -> u32 {
        // SAFETY: the caller has AVX2.
        unsafe {
            let same = _mm256_cmpeq_epi32(_mm256_castps_si256(a), _mm256_set1_epi32(row as i32));
            !_mm256_movemask_ps(_mm256_castsi256_ps(same)) as u32
        }
    }

    #[inline(always)]
    unsafe fn compress(a: Self, mask: u32, to: *mut u32) {
        // SAFETY: the caller has AVX2 and room for eight words.
        unsafe { _mm256_storeu_ps(to.cast(), compress(a, mask)) }
    }
}

impl Wide for __m512 {
    const LANES: usize = 16;

    wide_intrinsic! {
        fn add = _mm512_add_ps;
        fn sub = _mm512_sub_ps;
        fn mul = _mm512_mul_ps;
        fn max = _mm512_max_ps;
    }

    #[inline(always)]
    unsafe fn splat(x: f32) -> Self {
        // SAFETY: the caller has AVX-512 F.
        unsafe { _mm512_set1_ps(x) }
    }

    #[inline(always)]
    unsafe fn load(from: *const u32) -> Self {
        // SAFETY: the caller has AVX-512 F and sixteen words there.
        unsafe { _mm512_loadu_ps(from.cast()) }
    }

    #[inline(always)]
    unsafe fn at_most(a: Self, b: Self) -> u32 {
        // SAFETY: the caller has AVX-512 F.
        unsafe { _mm512_cmp_ps_mask::<_CMP_LE_OQ>(a, b).into() }
    }

    #[inline(always)]
    unsafe fn differs(a: Self, row: u32) -> u32 {
        // SAFETY: the caller has AVX-512 F.
        unsafe {
            let row = _mm512_set1_epi32(row as i32);
            _mm512_cmpneq_epi32_mask(_mm512_castps_si512(a), row).into()
        }
    }

    #[inline(always)]
    unsafe fn compress(a: Self, mask: u32, to: *mut u32) {
        // SAFETY: the caller has AVX-512 F and room for sixteen words. Compressed in a register first: a compressing
        // store to memory is slow on some processors.
        unsafe { _mm512_storeu_ps(to.cast(), _mm512_maskz_compress_ps(mask as u16, a)) }
    }
}

/// See [`Simd::take_near`]. The machine must have the instructions of `V`.
#[inline(always)]
pub(super) unsafe fn take_near<V: Wide>(
    candidates: &mut Candidates,
    near: Near,
    (words, pitch): (&[u32], usize),
    runs: &[Run],
) {
    let ([to_x, to_y, to_z], to_rows) = candidates.room(runs);
    let room = to_rows.len();
    assert!(to_x.len() == room && to_y.len() == room && to_z.len() == room);
    let to = [to_x, to_y, to_z].map(|column| column.as_mut_ptr().cast::<u32>());
    let to = [to[0], to[1], to[2], to_rows.as_mut_ptr()];
    let mut count = 0;
    // Words after the start of the last column, less one vector: every run must end by this entry. 0 if the last column
    // starts beyond all words.
    let last_column = pitch
        .checked_mul(3)
        .and_then(|start| words.len().checked_sub(start));
    let ends_by = last_column
        .and_then(|words| words.checked_sub(V::LANES))
        .unwrap_or(0);
    // SAFETY: the caller has the instructions. A load starts within a run, in one of four columns, and reads one
    // vector: the assertion in the loop ensures that one more vector of words follows the run in the last column. A
    // store starts at `count`, which is at most the number of entries seen, and every column has room for one vector
    // more than the entries of all runs.
    unsafe {
        let low = near.low.map(|x| V::splat(x));
        let high = near.high.map(|x| V::splat(x));
        let (zero, limit) = (V::splat(0.0), V::splat(near.radius_squared));
        for run in runs {
            let start = run.start as usize;
            let end = start + run.len as usize;
            assert!(end <= ends_by, "a run beyond its block");
            for k in (start..end).step_by(V::LANES) {
                let entry =
                    [0, 1, 2, 3].map(|column| V::load(words.as_ptr().add(k + column * pitch)));
                let square = |axis: usize| {
                    let outside = V::max(
                        V::sub(low[axis], entry[axis]),
                        V::sub(entry[axis], high[axis]),
                    );
                    let outside = V::max(outside, zero);
                    V::mul(outside, outside)
                };
                let distance = V::add(V::add(square(0), square(1)), square(2));
                let present = (1 << (end - k).min(V::LANES)) - 1;
                let mask = V::at_most(distance, limit) & present;
                for (to, column) in to.iter().zip(entry) {
                    V::compress(column, mask, to.add(count));
                }
                count += mask.count_ones() as usize;
            }
        }
    }
    candidates.len += count;
}

/// See [`Simd::collect_hits`]. The machine must have the instructions of `V`.
#[inline(always)]
pub(super) unsafe fn collect_hits<V: Wide>(
    candidates: &Candidates,
    probe: Probe,
    hits: &mut [u32],
) -> usize {
    let ([x, y, z], rows) = candidates.columns();
    let len = rows.len();
    assert!(x.len() == len && y.len() == len && z.len() == len);
    assert!(len.is_multiple_of(V::LANES) && hits.len() >= len + V::LANES);
    let mut count = 0;
    // SAFETY: the caller has the instructions. Loads end at `len`, a multiple of the number of lanes; stores start at
    // `count ≤ len`, and `hits` has room for one more vector after that.
    unsafe {
        let center = probe.center.map(|x| V::splat(x));
        let limit = V::splat(probe.radius_squared);
        for k in (0..len).step_by(V::LANES) {
            let square = |axis: usize, column: &[f32]| {
                let d = V::sub(V::load(column.as_ptr().add(k).cast()), center[axis]);
                V::mul(d, d)
            };
            let distance = V::add(V::add(square(0, x), square(1, y)), square(2, z));
            let row = V::load(rows.as_ptr().add(k));
            let hit = V::at_most(distance, limit) & V::differs(row, probe.own_row);
            V::compress(row, hit, hits.as_mut_ptr().add(count));
            count += hit.count_ones() as usize;
        }
    }
    count
}

/// Moves the lanes of `mask` to the front, in their order. The machine must have AVX2.
#[inline(always)]
pub(super) unsafe fn compress(a: __m256, mask: u32) -> __m256 {
    // SAFETY: the caller has AVX2; an entry of the table has eight words.
    unsafe {
        let order = _mm256_loadu_si256(COMPACTION[mask as usize].as_ptr().cast());
        _mm256_permutevar8x32_ps(a, order)
    }
}

/// For every mask of eight lanes: the indices of its set lanes, in order.
static COMPACTION: [[u32; 8]; 256] = {
    let mut table = [[0; 8]; 256];
    let mut mask = 0;
    while mask < 256 {
        let (mut lane, mut count) = (0, 0);
        while lane < 8 {
            if mask >> lane & 1 == 1 {
                table[mask][count] = lane as u32;
                count += 1;
            }
            lane += 1;
        }
        mask += 1;
    }
    table
};
