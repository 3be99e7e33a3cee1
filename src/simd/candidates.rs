//! Candidate neighbours: the data that the search over candidates reads, and its criteria.

use glam::Vec4;

/// Candidates are padded to a multiple of this with points that lie in no ball.
pub const CANDIDATE_ALIGNMENT: usize = 16;

/// The ball that candidates are tested against.
#[derive(Debug, Clone, Copy)]
pub struct Probe {
    /// Centre of the ball \[m].
    pub center: [f32; 3],
    /// Square of its radius \[m²]; the ball is closed.
    pub radius_squared: f32,
    /// The row that is skipped because it is the probe itself; `u32::MAX` if there is none.
    pub own_row: u32,
}

/// A contiguous range of entries within a block.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Run {
    /// Index of the first entry's x; its y, z and row follow at distances of one pitch.
    pub start: u32,
    /// Number of entries.
    pub len: u32,
}

/// Filter for candidates: points near a box around the centres of several probes.
#[derive(Debug, Clone, Copy)]
pub struct Near {
    /// Lowest coordinates \[m].
    pub low: [f32; 3],
    /// Highest coordinates \[m].
    pub high: [f32; 3],
    /// Square of the largest distance from the box \[m²].
    pub radius_squared: f32,
}

impl Near {
    /// Accepts every point.
    pub const ALL: Self = Self {
        low: [f32::NEG_INFINITY; 3],
        high: [f32::INFINITY; 3],
        radius_squared: 0.0,
    };
}

/// Candidate neighbours as a structure of arrays, padded to whole vectors. The columns only grow, so that each
/// candidate is written once and nothing is cleared before.
#[derive(Debug, Default, Clone)]
pub struct Candidates {
    x: Vec<f32>,
    y: Vec<f32>,
    z: Vec<f32>,
    rows: Vec<u32>,
    pub(super) len: usize,
}

/// Initial capacity: more than the number of points in the cells around a point in most scenes. Otherwise the buffers
/// of a thread would grow step by step when it first gets work.
pub(crate) const FIRST_ROOM: usize = 1024;

impl Candidates {
    /// Removes all candidates and keeps the memory.
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

    /// Space for all entries of `runs`, and one more vector, after the present candidates.
    #[inline(always)]
    pub(super) fn room(&mut self, runs: &[Run]) -> ([&mut [f32]; 3], &mut [u32]) {
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

    /// Pads to whole vectors with points at infinity, which lie in no ball.
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

    /// Number of candidates, without padding.
    pub fn len(&self) -> usize {
        self.len
    }

    /// Number of candidates, with padding.
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

    /// The padded columns x, y, z \[m] and rows, all of one length.
    #[inline(always)]
    pub(super) fn columns(&self) -> ([&[f32]; 3], &[u32]) {
        let len = self.padded_len();
        (
            [&self.x[..len], &self.y[..len], &self.z[..len]],
            &self.rows[..len],
        )
    }
}
