//! The operations on eight lanes in which a loop is written.

use glam::Vec4;

use super::candidates::{Candidates, Near, Probe, Run};

/// Lanes of a vector.
pub const LANES: usize = 8;

/// Eight numbers in memory, aligned for one load.
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
    /// `a b + c`, rounded once if the machine can.
    fn mul_add(self, a: Self::F, b: Self::F, c: Self::F) -> Self::F;
    /// The larger of two.
    fn max(self, a: Self::F, b: Self::F) -> Self::F;
    /// The smaller of two.
    fn min(self, a: Self::F, b: Self::F) -> Self::F;
    /// Square root.
    fn sqrt(self, a: Self::F) -> Self::F;
    /// Sum of the lanes, in the order `((0+4)+(2+6)) + ((1+5)+(3+7))`.
    fn sum(self, a: Self::F) -> f32;

    /// The first eight rows of a list; missing rows are `u32::MAX`.
    fn rows(self, list: &[u32]) -> Self::Rows;
    /// The lanes whose row is less than `limit`, one bit each.
    fn below(self, rows: Self::Rows, limit: u32) -> u32;
    /// The lanes whose point is inside a cube, one bit each. NaN coordinates are outside.
    fn inside(self, point: [Self::F; 3], cube: Cube) -> u32;
    /// Moves the lanes of `mask` to the front, in their order; the remaining lanes are unspecified.
    fn compress(self, a: Self::F, mask: u32) -> Self::F;
    /// As `compress`, for rows, into memory.
    fn compress_rows(self, rows: Self::Rows, mask: u32) -> [u32; LANES];
    /// Inserts `entry` at `place` into a block of four columns: entries from `place` on move up by one, the last is
    /// dropped. The length of a column is a multiple of four.
    fn insert(self, block: &mut [u32], place: usize, entry: [u32; 4]);
    /// Reads four columns at eight rows. A row beyond the table reads its last entry.
    fn gather(self, table: &[Vec4], rows: Self::Rows) -> [Self::F; 4];
    /// A vector in both halves.
    fn splat_vector(self, x: Vec4) -> Self::F;
    /// `sum + Σ_k factor_k (a − a_k) (b − b_k)` with `own` a and b, over eight rows of two tables, component by
    /// component: the first four rows in the lower half, the others in the upper half. A row beyond the shorter table
    /// reads the entry at the shorter table's last row in both.
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
    /// Appends the entries of `runs` that are near, in their order. `blocks` holds blocks of four columns with `pitch`
    /// entries each (bits of x, y, z; rows), block after block, followed by
    /// [`CANDIDATE_ALIGNMENT`](super::CANDIDATE_ALIGNMENT) more words, because whole vectors are read. A run that is
    /// not inside a block panics.
    fn take_near(
        self,
        candidates: &mut Candidates,
        near: Near,
        blocks: (&[u32], usize),
        runs: &[Run],
    );
    /// Appends the rows of `candidates` within `radius_squared` of `center`, except `own_row`, to `hits` in their
    /// order, and returns their number. `hits` must have room for `candidates.padded_len() + CANDIDATE_ALIGNMENT`.
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

/// A loop body that is compiled for every instruction set. Mark `run` and everything it calls `#[inline(always)]`.
pub trait Vectorised {
    /// Result of the body.
    type Output;
    /// The body.
    fn run<S: Simd>(self, simd: S) -> Self::Output;
}
