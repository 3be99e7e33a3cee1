//! What a loop is written with: the operations on eight lanes.

use glam::Vec4;

use super::candidates::{Candidates, Near, Probe, Run};

/// Lanes of a vector.
pub const LANES: usize = 8;

/// Eight numbers in memory, where one load takes them.
#[derive(Debug, Clone, Copy, Default)]
#[repr(C, align(32))]
pub struct Lanes(pub [f32; LANES]);

/// Operations on eight lanes. A value of an implementing type proves that the machine has its instructions.
pub trait Simd: Copy {
    /// Eight numbers.
    type F: Copy;
    /// Eight rows.
    type Rows: Copy;

    /// The same number in every lane.
    fn splat(self, x: f32) -> Self::F;
    /// Eight numbers from memory.
    fn load(self, lanes: &Lanes) -> Self::F;
    /// Eight numbers to memory.
    fn store(self, a: Self::F, lanes: &mut Lanes);
    /// The bits of eight numbers.
    fn bits(self, a: Self::F) -> [u32; LANES];
    /// `a + b`
    fn add(self, a: Self::F, b: Self::F) -> Self::F;
    /// `a − b`
    fn sub(self, a: Self::F, b: Self::F) -> Self::F;
    /// `a b`
    fn mul(self, a: Self::F, b: Self::F) -> Self::F;
    /// `a / b`
    fn div(self, a: Self::F, b: Self::F) -> Self::F;
    /// `a b + c`, rounded once where the machine can.
    fn mul_add(self, a: Self::F, b: Self::F, c: Self::F) -> Self::F;
    /// The larger of two.
    fn max(self, a: Self::F, b: Self::F) -> Self::F;
    /// The smaller of two.
    fn min(self, a: Self::F, b: Self::F) -> Self::F;
    /// Square root.
    fn sqrt(self, a: Self::F) -> Self::F;
    /// Sum of the lanes, in the order `((0+4)+(2+6)) + ((1+5)+(3+7))`.
    fn sum(self, a: Self::F) -> f32;

    /// The first eight rows of a list; where it has fewer, the other lanes hold `u32::MAX`.
    fn rows(self, list: &[u32]) -> Self::Rows;
    /// The lanes whose row is less than `limit`, a bit each.
    fn below(self, rows: Self::Rows, limit: u32) -> u32;
    /// The lanes whose point is inside a cube, a bit each. Coordinates that are not a number are outside.
    fn inside(self, point: [Self::F; 3], cube: Cube) -> u32;
    /// The lanes of `mask` first and in their order; what the others hold is open.
    fn compress(self, a: Self::F, mask: u32) -> Self::F;
    /// The same of rows, into memory.
    fn compress_rows(self, rows: Self::Rows, mask: u32) -> [u32; LANES];
    /// Moves the entries of a block of four columns from `place` on up by one, the last out, and puts one there. The
    /// length of a column is a multiple of four.
    fn insert(self, block: &mut [u32], place: usize, entry: [u32; 4]);
    /// Four columns at eight rows. A row beyond the table reads its last entry.
    fn gather(self, table: &[Vec4], rows: Self::Rows) -> [Self::F; 4];
    /// A vector in both halves.
    fn splat_vector(self, x: Vec4) -> Self::F;
    /// `sum + Σ_k factor_k (a − a_k) (b − b_k)` with `own` a and b, over eight rows of two tables, component by
    /// component: the first four rows in the lower half, the others in the upper. A row beyond the shorter table reads
    /// its last row in both.
    fn add_products(
        self,
        tables: [&[Vec4]; 2],
        own: [Self::F; 2],
        rows: Self::Rows,
        factor: Self::F,
        sum: Self::F,
    ) -> Self::F;
    /// Sum of the first three components of both halves, `((0+4)+(1+5)) + (2+6)`.
    fn sum_vectors(self, a: Self::F) -> f32;
    /// Appends the entries of `runs` that are near, in their order. `blocks` are words and a pitch: columns of that
    /// many entries, x, y, z as bits and rows, block after block, and
    /// [`CANDIDATE_ALIGNMENT`](super::CANDIDATE_ALIGNMENT) words more: whole vectors are read. A run that is not in a
    /// block panics.
    fn take_near(
        self,
        candidates: &mut Candidates,
        near: Near,
        blocks: (&[u32], usize),
        runs: &[Run],
    );
    /// Appends the rows of `candidates` within `radius_squared` of `center`, without `own_row`, to `hits` in their
    /// order, and says how many. `hits` must have room for `candidates.padded_len() + CANDIDATE_ALIGNMENT`.
    fn collect_hits(self, candidates: &Candidates, probe: Probe, hits: &mut [u32]) -> usize;
}

/// An open cube.
#[derive(Debug, Clone, Copy)]
pub struct Cube {
    /// Its centre \[m].
    pub center: [f32; 3],
    /// Half its edge \[m].
    pub half: f32,
}

/// A loop body that is compiled for every instruction set. Mark `run` and all it calls `#[inline(always)]`.
pub trait Vectorised {
    /// What it gives.
    type Output;
    /// The body.
    fn run<S: Simd>(self, simd: S) -> Self::Output;
}
