//! AVX-512 for the neighbour search; arithmetic uses AVX2.
#![allow(unsafe_code, reason = "intrinsics; every block says why it may")]

use std::arch::x86_64::*;

use glam::Vec4;

use super::{
    candidates::{Candidates, Near, Probe, Run},
    vector::{Cube, LANES, Lanes, Simd, Vectorised},
    wide::{collect_hits, take_near},
    x86::Avx2,
};

/// Proof that the machine has AVX2, FMA and AVX-512 F and VL: only `detect` creates it.
#[derive(Debug, Clone, Copy)]
pub(super) struct Avx512(Avx2);

impl Avx512 {
    #[inline]
    pub(super) fn detect() -> Option<Self> {
        let avx2 = Avx2::detect()?;
        (is_x86_feature_detected!("avx512f") && is_x86_feature_detected!("avx512vl"))
            .then_some(Self(avx2))
    }

    #[inline]
    pub(super) fn dispatch<V: Vectorised>(self, body: V) -> V::Output {
        #[target_feature(enable = "avx2,fma,popcnt,avx512f,avx512vl")]
        fn compiled<V: Vectorised>(simd: Avx512, body: V) -> V::Output {
            body.run(simd)
        }
        // SAFETY: `self` proves that the machine has the features.
        unsafe { compiled(self, body) }
    }
}

/// Forwards an operation to AVX2.
macro_rules! as_avx2 {
    ($(fn $name:ident($($argument:ident: $type:ty),*) -> $output:ty;)*) => { $(
        #[inline(always)]
        fn $name(self, $($argument: $type),*) -> $output {
            self.0.$name($($argument),*)
        }
    )* };
}

impl Simd for Avx512 {
    type F = __m256;
    type Rows = __m256i;

    as_avx2! {
        fn splat(x: f32) -> __m256;
        fn load(lanes: &Lanes) -> __m256;
        fn store(a: __m256, lanes: &mut Lanes) -> ();
        fn bits(a: __m256) -> [u32; LANES];
        fn add(a: __m256, b: __m256) -> __m256;
        fn sub(a: __m256, b: __m256) -> __m256;
        fn mul(a: __m256, b: __m256) -> __m256;
        fn div(a: __m256, b: __m256) -> __m256;
        fn mul_add(a: __m256, b: __m256, c: __m256) -> __m256;
        fn max(a: __m256, b: __m256) -> __m256;
        fn min(a: __m256, b: __m256) -> __m256;
        fn sqrt(a: __m256) -> __m256;
        fn sum(a: __m256) -> f32;
        fn rows(list: &[u32]) -> __m256i;
        fn below(rows: __m256i, limit: u32) -> u32;
        fn compress(a: __m256, mask: u32) -> __m256;
        fn compress_rows(rows: __m256i, mask: u32) -> [u32; LANES];
        fn inside(point: [__m256; 3], cube: Cube) -> u32;
        fn insert(block: &mut [u32], place: usize, entry: [u32; 4]) -> ();
        fn gather(table: &[Vec4], rows: __m256i) -> [__m256; 4];
        fn splat_vector(x: Vec4) -> __m256;
        fn add_products(tables: [&[Vec4]; 2], own: [__m256; 2], rows: __m256i, factor: __m256, sum: __m256) -> __m256;
        fn sum_vectors(a: __m256) -> f32;
    }

    #[inline(always)]
    fn take_near(
        self,
        candidates: &mut Candidates,
        near: Near,
        blocks: (&[u32], usize),
        runs: &[Run],
    ) {
        // SAFETY: `self` proves that the machine has AVX-512 F.
        unsafe { take_near::<__m512>(candidates, near, blocks, runs) }
    }

    #[inline(always)]
    fn collect_hits(self, candidates: &Candidates, probe: Probe, hits: &mut [u32]) -> usize {
        // SAFETY: `self` proves that the machine has AVX-512 F.
        unsafe { collect_hits::<__m512>(candidates, probe, hits) }
    }
}
