//! Eight lanes of `f32`, chosen at run time: the only module with `unsafe`.
//!
//! A neighbour loop is written once, generic over [`Simd`], and [`InstructionSet::dispatch`] compiles it for every
//! instruction set. Eight lanes in every path, IEEE division and square root, sums folded in one fixed tree: paths
//! with fused multiply-add give the same bits. AVX-512 changes no arithmetic; it tests sixteen candidates at once
//! and compacts the hits, which gives the same lists.
//!
//! Tried and dropped: sixteen lanes, one vector of AVX-512 or two of AVX2, which gives the same bits on all machines,
//! too. With AVX-512 a density pass took 15 % less, but a step 0 to 5 %, since most passes wait for loads; and compact
//! hashing, whose cells have eight points, compared them 1.4 times as long with AVX-512 and three times with AVX2.

mod portable;
#[cfg(target_arch = "x86_64")]
mod wide;
#[cfg(target_arch = "x86_64")]
mod x86;

use glam::Vec4;

pub use portable::Portable;

/// Lanes of a vector.
pub const LANES: usize = 8;

/// Eight numbers in memory, where one load takes them.
#[derive(Debug, Clone, Copy, Default)]
#[repr(C, align(32))]
pub struct Lanes(pub [f32; LANES]);

/// Candidates are padded to a multiple of this with points that nothing reaches.
pub const CANDIDATE_ALIGNMENT: usize = 16;

/// Hints that `place` is about to be used, so that many places far from each other are fetched at a time.
#[inline(always)]
pub(crate) fn prefetch<T>(place: &T) {
    #[cfg(target_arch = "x86_64")]
    x86::prefetch(place);
    #[cfg(not(target_arch = "x86_64"))]
    let _ = place;
}

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
    /// Appends the entries of `runs` that are near, in their order. `blocks` are words and a pitch: columns of
    /// that many entries, x, y, z as
    /// bits and rows, block after block, and [`CANDIDATE_ALIGNMENT`] words more: whole vectors are read. A run
    /// that is not in a block panics.
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

/// An open cube.
#[derive(Debug, Clone, Copy)]
pub struct Cube {
    /// Its centre [m].
    pub center: [f32; 3],
    /// Half its edge [m].
    pub half: f32,
}

/// A stretch of entries within a block.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Run {
    /// The place of the first one's x; y, z and the row stand a pitch further each.
    pub start: u32,
    /// How many.
    pub len: u32,
}

/// What points must be near to become candidates: a box around the centres of several probes.
#[derive(Debug, Clone, Copy)]
pub struct Near {
    /// Lowest coordinates [m].
    pub low: [f32; 3],
    /// Highest coordinates [m].
    pub high: [f32; 3],
    /// Square of the largest distance from the box [m²].
    pub radius_squared: f32,
}

impl Near {
    /// Everything is near.
    pub const ALL: Self = Self {
        low: [f32::NEG_INFINITY; 3],
        high: [f32::INFINITY; 3],
        radius_squared: 0.0,
    };
}

/// Candidate neighbours as a structure of arrays, padded to whole vectors. The columns only grow, so that a candidate
/// is written once and nothing is cleared before it.
#[derive(Debug, Default, Clone)]
pub struct Candidates {
    x: Vec<f32>,
    y: Vec<f32>,
    z: Vec<f32>,
    rows: Vec<u32>,
    len: usize,
}

/// Candidates that there is room for at once: more than the cells around a point hold in most scenes, so that the
/// buffers of a thread do not grow step by step, whenever it finds its first work.
pub(crate) const FIRST_ROOM: usize = 1024;

impl Candidates {
    /// Forgets all candidates, keeps the memory.
    pub fn clear(&mut self) {
        self.len = 0;
    }

    /// Appends the points at `rows`.
    #[inline]
    pub fn extend(&mut self, rows: &[u32], points: &[Vec4]) {
        let end = self.len + rows.len();
        if self.rows.len() < end {
            self.grow(end);
        }
        let place = self.len..end;
        let columns = self.x[place.clone()]
            .iter_mut()
            .zip(&mut self.y[place.clone()]);
        let columns = columns
            .zip(&mut self.z[place.clone()])
            .zip(&mut self.rows[place]);
        for ((((x, y), z), slot), &row) in columns.zip(rows) {
            let point = points[row as usize];
            (*x, *y, *z, *slot) = (point.x, point.y, point.z, row);
        }
        self.len = end;
    }

    /// Room for all entries of `runs`, and a vector, behind the candidates it has.
    #[inline(always)]
    fn room(&mut self, runs: &[Run]) -> ([&mut [f32]; 3], &mut [u32]) {
        let more: usize = runs.iter().map(|run| run.len as usize).sum();
        let end = self.len + more + CANDIDATE_ALIGNMENT;
        if self.rows.len() < end {
            self.grow(end);
        }
        let place = self.len..end;
        let Self { x, y, z, rows, .. } = self;
        let columns = [x, y, z].map(|column| &mut column[place.clone()]);
        (columns, &mut rows[place])
    }

    /// Pads to whole vectors with points at infinity, which no ball reaches.
    pub fn pad(&mut self) {
        let padded = self.padded_len();
        if self.rows.len() < padded {
            self.grow(padded);
        }
        let place = self.len..padded;
        for column in [&mut self.x, &mut self.y, &mut self.z] {
            column[place.clone()].fill(f32::INFINITY);
        }
        self.rows[place].fill(u32::MAX);
    }

    /// Number of candidates.
    pub fn len(&self) -> usize {
        self.len
    }

    /// Length with the padding.
    pub fn padded_len(&self) -> usize {
        self.len.next_multiple_of(CANDIDATE_ALIGNMENT)
    }

    /// Whether there is no candidate.
    pub fn is_empty(&self) -> bool {
        self.len == 0
    }

    #[cold]
    fn grow(&mut self, len: usize) {
        let len = len.next_power_of_two().max(FIRST_ROOM);
        self.x.resize(len, 0.0);
        self.y.resize(len, 0.0);
        self.z.resize(len, 0.0);
        self.rows.resize(len, 0);
    }

    /// The padded columns x, y, z [m] and rows, all of one length.
    #[inline(always)]
    fn columns(&self) -> ([&[f32]; 3], &[u32]) {
        let len = self.padded_len();
        (
            [&self.x[..len], &self.y[..len], &self.z[..len]],
            &self.rows[..len],
        )
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

    /// The set for arithmetic. With AVX-512 enabled the compiler takes 512-bit detours in loops of eight lanes.
    pub fn arithmetic(self) -> Self {
        self.min(Self::Avx2)
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
