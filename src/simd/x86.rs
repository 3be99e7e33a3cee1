//! AVX2 with FMA.
#![allow(unsafe_code, reason = "intrinsics; every block says why it may")]

use std::arch::x86_64::*;

use glam::Vec4;

use super::{
    candidates::{Candidates, Near, Probe, Run},
    vector::{Cube, LANES, Lanes, Simd, Vectorised},
    wide::{collect_hits, compress, take_near},
};

/// Largest row whose byte offset fits 32 bits.
const MAX_ROW: usize = (1 << 28) - 1;

/// See [`prefetch`](super::cache::prefetch).
#[inline(always)]
pub(super) fn prefetch<T>(place: &T) {
    // SAFETY: every x86-64 processor has the instruction, and it changes no memory.
    unsafe { _mm_prefetch::<_MM_HINT_T0>(std::ptr::from_ref(place).cast()) }
}

/// The k-th offset and the fourth after it. The read is volatile so that they come from memory (see `gather`).
#[inline(always)]
fn reload(offsets: &[u32; LANES], k: usize) -> [usize; 2] {
    // SAFETY: reads of a reference.
    [k, k + 4].map(|k| unsafe { std::ptr::read_volatile(&offsets[k]) } as usize)
}

/// Proof that the machine has AVX2 and FMA: only `detect` creates it.
#[derive(Debug, Clone, Copy)]
pub(super) struct Avx2(());

impl Avx2 {
    #[inline]
    pub(super) fn detect() -> Option<Self> {
        (is_x86_feature_detected!("avx2")
            && is_x86_feature_detected!("fma")
            && is_x86_feature_detected!("popcnt"))
        .then_some(Self(()))
    }

    /// Byte offsets of eight rows in a table of `entries` rows. A row beyond the table gets the offset of the last
    /// entry.
    #[inline(always)]
    fn offsets(self, rows: __m256i, entries: usize) -> [u32; LANES] {
        assert!(entries > 0, "a table ends with a sentinel");
        let last = (entries - 1).min(MAX_ROW) as i32;
        let mut offsets = [0; LANES];
        // SAFETY: `self` proves that the machine has AVX2; there is room for eight words. The offset of a row up to
        // `MAX_ROW` fits one word.
        unsafe {
            let rows = _mm256_min_epu32(rows, _mm256_set1_epi32(last));
            _mm256_storeu_si256(offsets.as_mut_ptr().cast(), _mm256_slli_epi32::<4>(rows));
        }
        offsets
    }

    /// The entries at two offsets \[bytes].
    ///
    /// # Safety
    ///
    /// Sixteen bytes must be readable at both offsets from `base`.
    #[inline(always)]
    unsafe fn two(self, base: *const u8, [low, high]: [usize; 2]) -> __m256 {
        // SAFETY: `self` proves that the machine has AVX2; the caller guarantees the offsets. Loads are unaligned.
        unsafe {
            let low = _mm256_castps128_ps256(_mm_loadu_ps(base.add(low).cast()));
            _mm256_insertf128_ps::<1>(low, _mm_loadu_ps(base.add(high).cast()))
        }
    }

    #[inline]
    pub(super) fn dispatch<V: Vectorised>(self, body: V) -> V::Output {
        #[target_feature(enable = "avx2,fma,popcnt")]
        fn compiled<V: Vectorised>(simd: Avx2, body: V) -> V::Output {
            body.run(simd)
        }
        // SAFETY: `self` proves that the machine has the features.
        unsafe { compiled(self, body) }
    }
}

/// An operation that is one intrinsic.
macro_rules! intrinsic {
    ($(fn $name:ident($($argument:ident),*) = $intrinsic:ident;)*) => { $(
        #[inline(always)]
        fn $name(self, $($argument: __m256),*) -> __m256 {
            // SAFETY: `self` proves that the machine has AVX2 and FMA.
            unsafe { $intrinsic($($argument),*) }
        }
    )* };
}

impl Simd for Avx2 {
    type F = __m256;
    type Rows = __m256i;

    intrinsic! {
        fn add(a, b) = _mm256_add_ps;
        fn sub(a, b) = _mm256_sub_ps;
        fn mul(a, b) = _mm256_mul_ps;
        fn div(a, b) = _mm256_div_ps;
        fn mul_add(a, b, c) = _mm256_fmadd_ps;
        fn max(a, b) = _mm256_max_ps;
        fn min(a, b) = _mm256_min_ps;
        fn sqrt(a) = _mm256_sqrt_ps;
    }

    #[inline(always)]
    fn splat(self, x: f32) -> __m256 {
        // SAFETY: `self` proves that the machine has AVX2.
        unsafe { _mm256_set1_ps(x) }
    }

    #[inline(always)]
    fn load(self, lanes: &Lanes) -> __m256 {
        // SAFETY: `self` proves that the machine has AVX2; `Lanes` are eight numbers, aligned to 32 bytes.
        unsafe { _mm256_load_ps(lanes.0.as_ptr()) }
    }

    #[inline(always)]
    fn store(self, a: __m256, lanes: &mut Lanes) {
        // SAFETY: as in `load`.
        unsafe { _mm256_store_ps(lanes.0.as_mut_ptr(), a) }
    }

    #[inline(always)]
    fn bits(self, a: __m256) -> [u32; LANES] {
        let mut words = [0; LANES];
        // SAFETY: `self` proves that the machine has AVX2; there is room for eight words.
        unsafe { _mm256_storeu_ps(words.as_mut_ptr().cast(), a) }
        words
    }

    #[inline(always)]
    fn sum(self, a: __m256) -> f32 {
        // SAFETY: `self` proves that the machine has AVX2.
        unsafe {
            let four = _mm_add_ps(_mm256_castps256_ps128(a), _mm256_extractf128_ps::<1>(a));
            let two = _mm_add_ps(four, _mm_movehl_ps(four, four));
            _mm_cvtss_f32(_mm_add_ss(two, _mm_shuffle_ps::<1>(two, two)))
        }
    }

    #[inline(always)]
    fn rows(self, list: &[u32]) -> __m256i {
        if let Some(whole) = list.first_chunk::<LANES>() {
            // SAFETY: `self` proves that the machine has AVX2; the chunk has eight entries.
            return unsafe { _mm256_loadu_si256(whole.as_ptr().cast()) };
        }
        let len = list.len() as i32;
        // SAFETY: `self` proves that the machine has AVX2. The masked load touches only lanes below `list.len()`.
        unsafe {
            let lane = _mm256_setr_epi32(0, 1, 2, 3, 4, 5, 6, 7);
            let absent = _mm256_cmpgt_epi32(lane, _mm256_set1_epi32(len - 1));
            let present = _mm256_cmpgt_epi32(_mm256_set1_epi32(len), lane);
            _mm256_or_si256(_mm256_maskload_epi32(list.as_ptr().cast(), present), absent)
        }
    }

    #[inline(always)]
    fn below(self, rows: __m256i, limit: u32) -> u32 {
        // AVX2 cannot compare unsigned numbers: a row is below the limit if it equals the minimum of itself and `limit
        // − 1`.
        let Some(last) = limit.checked_sub(1) else {
            return 0;
        };
        // SAFETY: `self` proves that the machine has AVX2.
        unsafe {
            let smaller = _mm256_min_epu32(rows, _mm256_set1_epi32(last as i32));
            let below = _mm256_cmpeq_epi32(rows, smaller);
            _mm256_movemask_ps(_mm256_castsi256_ps(below)) as u32
        }
    }

    #[inline(always)]
    fn inside(self, point: [__m256; 3], cube: Cube) -> u32 {
        // SAFETY: `self` proves that the machine has AVX2.
        unsafe {
            let sign = _mm256_set1_ps(-0.0);
            let half = _mm256_set1_ps(cube.half);
            let along = |axis: usize| {
                let distance = _mm256_sub_ps(point[axis], _mm256_set1_ps(cube.center[axis]));
                _mm256_cmp_ps::<_CMP_LT_OQ>(_mm256_andnot_ps(sign, distance), half)
            };
            let inside = _mm256_and_ps(_mm256_and_ps(along(0), along(1)), along(2));
            _mm256_movemask_ps(inside) as u32
        }
    }

    #[inline(always)]
    fn compress(self, a: __m256, mask: u32) -> __m256 {
        // SAFETY: `self` proves that the machine has AVX2.
        unsafe { compress(a, mask) }
    }

    #[inline(always)]
    fn compress_rows(self, rows: __m256i, mask: u32) -> [u32; LANES] {
        // SAFETY: `self` proves that the machine has AVX2.
        self.bits(unsafe { compress(_mm256_castsi256_ps(rows), mask) })
    }

    #[inline(always)]
    fn insert(self, block: &mut [u32], place: usize, entry: [u32; 4]) {
        /// Words of a vector.
        const FOUR: usize = 4;
        let pitch = block.len() / 4;
        assert!(pitch.is_multiple_of(FOUR));
        let words: *mut __m128i = block.as_mut_ptr().cast();
        // SAFETY: `self` proves that the machine has AVX2. Columns consist of whole vectors of four words. A load of
        // the preceding words begins one word earlier, except for the first vector of each column.
        unsafe {
            let place = _mm_set1_epi32(place as i32);
            for four in (0..pitch / FOUR).rev() {
                let first = _mm_set1_epi32((FOUR * four) as i32);
                let entries = _mm_add_epi32(first, _mm_setr_epi32(0, 1, 2, 3));
                let moves = _mm_cmpgt_epi32(entries, place);
                let comes = _mm_cmpeq_epi32(entries, place);
                for (column, &word) in entry.iter().enumerate() {
                    let word = _mm_set1_epi32(word as i32);
                    let to = words.add(column * (pitch / FOUR) + four);
                    let old = _mm_loadu_si128(to);
                    let before = if four == 0 {
                        _mm_slli_si128::<4>(old)
                    } else {
                        _mm_loadu_si128(to.cast::<u32>().sub(1).cast())
                    };
                    let moved = _mm_blendv_epi8(old, before, moves);
                    _mm_storeu_si128(to, _mm_blendv_epi8(moved, word, comes));
                }
            }
        }
    }

    /// Eight loads of 16 bytes and a transposition. Option 1 is four hardware gathers, which occupy the load ports for
    /// 20 cycles per eight rows; option 2 is this, about 10. We use 2. The offsets are stored and reloaded through the
    /// two load ports: extracting them from the vector would compete with the transposition for the only shuffle port
    /// (a density pass took 142 ns per particle that way, 115 through memory).
    #[inline(always)]
    fn gather(self, table: &[Vec4], rows: __m256i) -> [__m256; 4] {
        let base = table.as_ptr().cast();
        let offsets = self.offsets(rows, table.len());
        // SAFETY: `self` proves that the machine has AVX2. The offsets are those of entries of the table, sixteen bytes
        // each.
        unsafe {
            let two = |k| self.two(base, reload(&offsets, k));
            let (a, b, c, d) = (two(0), two(1), two(2), two(3));
            let (ab_low, ab_high) = (_mm256_unpacklo_ps(a, b), _mm256_unpackhi_ps(a, b));
            let (cd_low, cd_high) = (_mm256_unpacklo_ps(c, d), _mm256_unpackhi_ps(c, d));
            [
                _mm256_shuffle_ps::<0b01_00_01_00>(ab_low, cd_low),
                _mm256_shuffle_ps::<0b11_10_11_10>(ab_low, cd_low),
                _mm256_shuffle_ps::<0b01_00_01_00>(ab_high, cd_high),
                _mm256_shuffle_ps::<0b11_10_11_10>(ab_high, cd_high),
            ]
        }
    }

    #[inline(always)]
    fn splat_vector(self, x: Vec4) -> __m256 {
        // SAFETY: `self` proves that the machine has AVX2; a `Vec4` is four numbers.
        unsafe {
            let x = _mm_loadu_ps(std::ptr::from_ref(&x).cast());
            _mm256_set_m128(x, x)
        }
    }

    #[inline(always)]
    fn add_products(
        self,
        [a, b]: [&[Vec4]; 2],
        own: [__m256; 2],
        rows: __m256i,
        factor: __m256,
        sum: __m256,
    ) -> __m256 {
        let offsets = self.offsets(rows, a.len().min(b.len()));
        let [a, b] = [a, b].map(|table| table.as_ptr().cast());
        // SAFETY: `self` proves that the machine has AVX2 and FMA. The offsets are those of entries of both tables,
        // sixteen bytes each.
        unsafe {
            let product = |k| {
                let places = reload(&offsets, k);
                let x = _mm256_sub_ps(own[0], self.two(a, places));
                _mm256_mul_ps(x, _mm256_sub_ps(own[1], self.two(b, places)))
            };
            let sum = _mm256_fmadd_ps(_mm256_permute_ps::<0x00>(factor), product(0), sum);
            let sum = _mm256_fmadd_ps(_mm256_permute_ps::<0x55>(factor), product(1), sum);
            let sum = _mm256_fmadd_ps(_mm256_permute_ps::<0xAA>(factor), product(2), sum);
            _mm256_fmadd_ps(_mm256_permute_ps::<0xFF>(factor), product(3), sum)
        }
    }

    #[inline(always)]
    fn sum_vectors(self, a: __m256) -> f32 {
        // SAFETY: `self` proves that the machine has AVX2.
        unsafe {
            let four = _mm_add_ps(_mm256_castps256_ps128(a), _mm256_extractf128_ps::<1>(a));
            let two = _mm_add_ss(four, _mm_movehdup_ps(four));
            _mm_cvtss_f32(_mm_add_ss(two, _mm_movehl_ps(four, four)))
        }
    }

    #[inline(always)]
    fn take_near(
        self,
        candidates: &mut Candidates,
        near: Near,
        blocks: (&[u32], usize),
        runs: &[Run],
    ) {
        // SAFETY: `self` proves that the machine has AVX2.
        unsafe { take_near::<__m256>(candidates, near, blocks, runs) }
    }

    #[inline(always)]
    fn collect_hits(self, candidates: &Candidates, probe: Probe, hits: &mut [u32]) -> usize {
        // SAFETY: `self` proves that the machine has AVX2.
        unsafe { collect_hits::<__m256>(candidates, probe, hits) }
    }
}
