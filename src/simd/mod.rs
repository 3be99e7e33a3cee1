//! Eight lanes of `f32`, chosen at run time: the only module with `unsafe`.
//!
//! A neighbour loop is written once, generic over [`Simd`], and [`InstructionSet::dispatch`] compiles it for every
//! instruction set. Eight lanes in every path, IEEE division and square root, sums folded in one fixed tree: paths
//! with fused multiply-add give the same bits. AVX-512 changes no arithmetic; it tests sixteen candidates at once
//! and compacts the hits, which gives the same lists (wider sums gained 8 % in a prototype and would cost the
//! equality of bits across machines).

mod portable;
#[cfg(target_arch = "x86_64")]
mod x86;

use glam::Vec4;

pub use portable::Portable;

/// Lanes of a vector.
pub const LANES: usize = 8;

/// Candidates are padded to a multiple of this with points that nothing reaches.
pub const CANDIDATE_ALIGNMENT: usize = 16;

/// Operations on eight lanes. A value of an implementing type proves that the machine has its instructions.
pub trait Simd: Copy {
    /// Eight numbers.
    type F: Copy;
    /// Eight rows.
    type Rows: Copy;

    /// The same number in every lane.
    fn splat(self, x: f32) -> Self::F;
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

    /// Eight rows of a list.
    fn rows(self, list: &[u32; LANES]) -> Self::Rows;
    /// The last, fewer than eight, rows of a list; the other lanes hold `u32::MAX`.
    fn last_rows(self, list: &[u32]) -> Self::Rows;
    /// Four columns at eight rows. A row beyond the table reads its last entry.
    fn gather(self, table: &[Vec4], rows: Self::Rows) -> [Self::F; 4];
    /// Appends the rows of `candidates` within `radius_squared` of `center`, without `own_row`, to `hits` in their
    /// order, and says how many. `hits` must have room for `candidates.padded_len() + CANDIDATE_ALIGNMENT`.
    fn collect_hits(self, candidates: &Candidates, probe: Probe, hits: &mut [u32]) -> usize;
}

/// What candidates are tested against.
#[derive(Debug, Clone, Copy)]
pub struct Probe {
    /// Centre of the ball [m].
    pub center: [f32; 3],
    /// Square of its radius [m²]; the ball is closed.
    pub radius_squared: f32,
    /// The row that is no neighbour of itself; `u32::MAX` if there is none.
    pub own_row: u32,
}

/// Candidate neighbours as a structure of arrays, padded to whole vectors.
#[derive(Debug, Default, Clone)]
pub struct Candidates {
    x: Vec<f32>,
    y: Vec<f32>,
    z: Vec<f32>,
    rows: Vec<u32>,
}

impl Candidates {
    /// Forgets all candidates, keeps the memory.
    pub fn clear(&mut self) {
        self.x.clear();
        self.y.clear();
        self.z.clear();
        self.rows.clear();
    }

    /// Appends the points at `rows`.
    pub fn extend(&mut self, rows: &[u32], points: &[Vec4]) {
        let len = self.rows.len();
        self.rows.extend_from_slice(rows);
        for column in [&mut self.x, &mut self.y, &mut self.z] {
            column.resize(len + rows.len(), 0.0);
        }
        let columns = self.x[len..]
            .iter_mut()
            .zip(&mut self.y[len..])
            .zip(&mut self.z[len..]);
        for (((x, y), z), &row) in columns.zip(rows) {
            let point = points[row as usize];
            (*x, *y, *z) = (point.x, point.y, point.z);
        }
    }

    /// Pads to whole vectors with points at infinity, which no ball reaches.
    pub fn pad(&mut self) {
        let padded = self.rows.len().next_multiple_of(CANDIDATE_ALIGNMENT);
        self.x.resize(padded, f32::INFINITY);
        self.y.resize(padded, f32::INFINITY);
        self.z.resize(padded, f32::INFINITY);
        self.rows.resize(padded, u32::MAX);
    }

    /// Length with the padding.
    pub fn padded_len(&self) -> usize {
        self.rows.len()
    }

    /// Whether there is no candidate.
    pub fn is_empty(&self) -> bool {
        self.rows.is_empty()
    }
}

/// A loop body that is compiled for every instruction set. Mark `run` and all it calls `#[inline(always)]`.
pub trait Vectorised {
    /// What it gives.
    type Output;
    /// The body.
    fn run<S: Simd>(self, simd: S) -> Self::Output;
}

/// Instruction set of the neighbour loops.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum InstructionSet {
    /// What the compiler makes of plain Rust. Fuses multiply-add only where the build target has it.
    Portable,
    /// AVX2 with FMA.
    Avx2,
    /// AVX2 with FMA for arithmetic, AVX-512 (F, VL) for the search.
    Avx512,
}

impl InstructionSet {
    /// Every set that this machine can run, the best last.
    pub fn available() -> Vec<Self> {
        #[allow(unused_mut, reason = "only x86-64 adds to it")]
        let mut sets = vec![Self::Portable];
        #[cfg(target_arch = "x86_64")]
        {
            if x86::Avx2::detect().is_some() {
                sets.push(Self::Avx2);
            }
            if x86::Avx512::detect().is_some() {
                sets.push(Self::Avx512);
            }
        }
        sets
    }

    /// The best set that this machine can run.
    pub fn detect() -> Self {
        Self::available().pop().unwrap_or(Self::Portable)
    }

    /// Name in reports.
    pub fn name(self) -> &'static str {
        match self {
            Self::Portable => "portable",
            Self::Avx2 => "avx2+fma",
            Self::Avx512 => "avx512",
        }
    }

    /// Runs `body` compiled for this set, or the portable one where the machine lacks it.
    #[inline]
    pub fn dispatch<V: Vectorised>(self, body: V) -> V::Output {
        #[cfg(target_arch = "x86_64")]
        match self {
            Self::Avx512 => {
                if let Some(token) = x86::Avx512::detect() {
                    return token.dispatch(body);
                }
            }
            Self::Avx2 => {
                if let Some(token) = x86::Avx2::detect() {
                    return token.dispatch(body);
                }
            }
            Self::Portable => {}
        }
        body.run(Portable)
    }
}

#[cfg(test)]
mod tests;
