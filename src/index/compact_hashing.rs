//! Compact hashing (paper 4.5): a hash table of handles and a compact list of the cells that hold points.
//!
//! - The table has 2 N handles (4.4: "two times the number of particles"), placed by equation 3; a handle names a used
//!   cell. N here is the number of points at the last rebuild; the table follows when it grows or falls by half.
//! - A used cell reserves k entries in one pool and moves to twice as many when they are full.
//! - [`update`](SpatialIndex::update) compares every point's cell with the last step's, in parallel, and moves only
//!   those that changed, serially and in a fixed order (4.5.1). An empty cell leaves the list at once.
//! - A flag says that a used cell holds points of more than one spatial cell (4.5.3); without it the hash indices
//!   around are computed once for all its points.
//! - [`rebuild`](SpatialIndex::rebuild) inserts Z-sorted points, so that used cells that follow each other are near each
//!   other (4.5.4).
//!
//! Deviations. Entries hold a copy of their positions (see `entries.rs`); the copy is of the last step until a point is
//! compared, so the old cell need not be stored, and one loop over the entries both compares and copies. A used cell
//! keeps its spatial coordinates: candidates are taken from it only where they are the ones that were asked for, so
//! two neighbouring cells that share a hash cell are not seen twice. When more than a quarter of the points changed
//! their cell (a host spawned in the middle of the rows), all are inserted anew.

use glam::{IVec3, Vec4};
use rayon::prelude::*;

use super::{
    DomainTooLarge, Grid, SpatialIndex,
    entries::{Entries, NOBODY, PADDING, Run},
    hash::{CellHash, MIN_TABLE},
    lookups::{self, State},
    z_curve,
};
use crate::{
    execution::{CHUNK, Execution},
    simd::{Simd, Vectorised},
};

const EMPTY: u32 = u32::MAX;
/// Handles a point (4.4: "a hash table size of two times the number of particles is appropriate").
const HANDLES_A_POINT: f32 = 2.0;

/// The structure of the paper's Figure 3.
pub struct CompactHashing {
    grid: Grid,
    handles_a_point: f32,
    hash: CellHash,
    /// For every hash its used cell, or `EMPTY`.
    table: Vec<u32>,
    cells: Vec<UsedCell>,
    pool: Pool,
    /// What look-ups were remembered of.
    state: State,
    /// Number of points.
    len: usize,
    /// Points that changed their cell, by chunk of entries.
    movers: Vec<Vec<Mover>>,
    handles: Vec<z_curve::Handle>,
}

/// A non-empty hash cell.
#[derive(Debug, Clone, Copy)]
struct UsedCell {
    /// Spatial cell of all its points, or of one of them if `collision`.
    cell: IVec3,
    /// Its place in the table.
    hash: u32,
    /// Its entries in the pool.
    start: u32,
    len: u32,
    capacity: u32,
    /// Whether it holds points of several spatial cells.
    collision: bool,
}

impl UsedCell {
    fn range(&self) -> std::ops::Range<usize> {
        self.start as usize..(self.start + self.len) as usize
    }
}

/// A point that changed its cell, or is gone.
#[derive(Debug, Clone, Copy)]
struct Mover {
    /// Its entry.
    entry: u32,
    row: u32,
    from: IVec3,
}

/// Entries that are compared at a time.
const LANES: usize = 16;

/// The comparison of one chunk of entries.
struct Compare<'a> {
    grid: &'a Grid,
    points: &'a [Vec4],
    first: u32,
    rows: &'a [u32],
    positions: [&'a mut [f32]; 3],
    movers: &'a mut Vec<Mover>,
}

impl Vectorised for Compare<'_> {
    type Output = ();

    #[inline(always)]
    fn run<S: Simd>(self, _: S) {
        let [x, y, z] = self.positions;
        let columns = x.chunks_mut(LANES).zip(y.chunks_mut(LANES));
        let columns = columns.zip(z.chunks_mut(LANES));
        let Some(last) = self.points.len().checked_sub(1) else {
            return;
        };
        for ((entries, rows), ((x, y), z)) in (self.first..)
            .step_by(LANES)
            .zip(self.rows.chunks(LANES))
            .zip(columns)
        {
            let mut new = [[0.0; LANES]; 3];
            for (k, &row) in rows.iter().enumerate() {
                let point = self.points[(row as usize).min(last)];
                (new[0][k], new[1][k], new[2][k]) = (point.x, point.y, point.z);
            }
            let mut old = [[0.0; LANES]; 3];
            for (old, column) in old.iter_mut().zip([&*x, &*y, &*z]) {
                old[..column.len()].copy_from_slice(column);
            }
            let mut unsure = 0u32;
            for k in 0..LANES {
                let same = (0..3).fold(true, |same, axis| {
                    same & self.grid.surely_alike(old[axis][k], new[axis][k])
                });
                unsure |= u32::from(!same) << k;
            }
            for (column, new) in [x, y, z].into_iter().zip(&new) {
                let len = column.len();
                column.copy_from_slice(&new[..len]);
            }
            for (k, &row) in rows.iter().enumerate() {
                let gone = row as usize > last;
                if row == NOBODY || !(gone || unsure >> k & 1 == 1) {
                    continue;
                }
                let cell = |x: &[[f32; LANES]; 3]| {
                    self.grid.cell_of(Vec4::new(x[0][k], x[1][k], x[2][k], 0.0))
                };
                let from = cell(&old);
                if gone || cell(&new) != from {
                    let entry = entries + k as u32;
                    self.movers.push(Mover { entry, row, from });
                }
            }
        }
    }
}

/// Memory of the used cells' entries: blocks of k, 2 k, 4 k, … entries.
#[derive(Debug, Default)]
struct Pool {
    entries: Entries,
    /// Entries of a new used cell: the paper's k.
    reserved: usize,
    /// Blocks given back, by the logarithm of their size in k.
    free: Vec<Vec<u32>>,
}

impl Pool {
    fn clear(&mut self) {
        self.entries.rows.clear();
        self.entries.resize(0);
        self.free.iter_mut().for_each(Vec::clear);
    }

    fn class(&self, capacity: u32) -> usize {
        (capacity as usize / self.reserved).ilog2() as usize
    }

    fn allocate(&mut self, capacity: u32) -> u32 {
        let class = self.class(capacity);
        if let Some(start) = self.free.get_mut(class).and_then(Vec::pop) {
            return start;
        }
        let start = self.entries.rows.len() - PADDING;
        self.entries.resize(start + capacity as usize);
        start as u32
    }

    fn release(&mut self, start: u32, capacity: u32) {
        let class = self.class(capacity);
        if self.free.len() <= class {
            self.free.resize_with(class + 1, Vec::new);
        }
        self.free[class].push(start);
    }

    /// Moves entries to `place`.
    fn shift(&mut self, entries: std::ops::Range<usize>, place: usize) {
        self.entries.rows.copy_within(entries.clone(), place);
        for column in &mut self.entries.positions {
            column.copy_within(entries.clone(), place);
        }
    }

    fn set(&mut self, entry: usize, row: u32, point: Vec4) {
        self.entries.rows[entry] = row;
        for (column, x) in self.entries.positions.iter_mut().zip(point.to_array()) {
            column[entry] = x;
        }
    }

    /// The cell of the position that an entry holds.
    fn cell(&self, grid: &Grid, entry: usize) -> IVec3 {
        let [x, y, z] = self
            .entries
            .positions
            .each_ref()
            .map(|column| column[entry]);
        grid.cell_of(Vec4::new(x, y, z, 0.0))
    }
}

impl CompactHashing {
    /// An empty index that expects `particles_a_cell` where there is fluid.
    pub fn new(grid: Grid, particles_a_cell: f32) -> Self {
        let pool = Pool {
            // Half as many again: a compressed or unlucky cell need not move.
            reserved: (1.5 * particles_a_cell).ceil().clamp(2.0, 1024.0) as usize,
            ..Pool::default()
        };
        Self {
            grid,
            handles_a_point: HANDLES_A_POINT,
            hash: CellHash::new(MIN_TABLE),
            table: Vec::new(),
            cells: Vec::new(),
            pool,
            state: State::new(),
            len: 0,
            movers: Vec::new(),
            handles: Vec::new(),
        }
    }

    /// As [`new`](Self::new), with the smallest table whatever the number of points: nearly every cell collides.
    #[cfg(test)]
    pub(crate) fn with_smallest_table(grid: Grid, particles_a_cell: f32) -> Self {
        let mut index = Self::new(grid, particles_a_cell);
        index.handles_a_point = 0.0;
        index
    }

    /// Share of the used cells that hold points of several spatial cells [-].
    pub fn collision_share(&self) -> f32 {
        self.cells.iter().filter(|cell| cell.collision).count() as f32
            / self.cells.len().max(1) as f32
    }

    /// Adds points of spatial cell `cell` to the used cell of its hash, which it creates if there is none.
    fn insert(&mut self, cell: IVec3, rows: impl ExactSizeIterator<Item = u32>, points: &[Vec4]) {
        let hash = self.hash.of(cell);
        let used = match self.table[hash as usize] {
            EMPTY => {
                let blocks = rows.len().div_ceil(self.pool.reserved).next_power_of_two();
                let capacity = (blocks * self.pool.reserved) as u32;
                self.table[hash as usize] = self.cells.len() as u32;
                self.cells.push(UsedCell {
                    cell,
                    hash,
                    start: self.pool.allocate(capacity),
                    len: 0,
                    capacity,
                    collision: false,
                });
                self.cells.len() - 1
            }
            handle => handle as usize,
        };
        let needed = self.cells[used].len + rows.len() as u32;
        if needed > self.cells[used].capacity {
            self.grow(used, needed);
        }
        let used = &mut self.cells[used];
        used.collision |= used.cell != cell;
        let old = used.range();
        used.len = needed;
        // Points of one spatial cell stay side by side, so that they can be handed out as a slice, and in the order of
        // their rows, so that neighbours come in one order however the points got there.
        let mut rows = rows.peekable();
        let mut place = old.end;
        let is_kin = |entry: usize| self.pool.cell(&self.grid, entry) == cell;
        if used.collision
            && let Some(kin) = old.clone().rfind(|&entry| is_kin(entry))
        {
            place = kin + 1;
        }
        if let Some(&first) = rows.peek() {
            while place > old.start
                && self.pool.entries.rows[place - 1] > first
                && (!used.collision || is_kin(place - 1))
            {
                place -= 1;
            }
        }
        self.pool.shift(place..old.end, place + rows.len());
        for (entry, row) in (place..).zip(rows) {
            self.pool.set(entry, row, points[row as usize]);
        }
    }

    /// The entries of a spatial cell, which are side by side.
    fn look_up(&self, cell: IVec3) -> Run {
        let nothing = Run { start: 0, len: 0 };
        let handle = self.table[self.hash.of(cell) as usize];
        match self.cells.get(handle as usize) {
            Some(used) if used.collision => {
                let alike = |entry: &usize| self.pool.cell(&self.grid, *entry) == cell;
                used.range().find(alike).map_or(nothing, |start| Run {
                    start: start as u32,
                    len: (start..used.range().end).take_while(alike).count() as u32,
                })
            }
            Some(used) if used.cell == cell => Run {
                start: used.start,
                len: used.len,
            },
            _ => nothing,
        }
    }

    /// Moves a used cell to a block of at least `needed` entries.
    fn grow(&mut self, used: usize, needed: u32) {
        let UsedCell {
            start, capacity, ..
        } = self.cells[used];
        let mut larger = capacity;
        while larger < needed {
            larger *= 2;
        }
        let old = self.cells[used].range();
        let new_start = self.pool.allocate(larger);
        self.pool.shift(old.clone(), new_start as usize);
        self.pool.entries.rows[old].fill(NOBODY);
        self.pool.release(start, capacity);
        self.cells[used].start = new_start;
        self.cells[used].capacity = larger;
    }

    /// Takes an entry out of its cell, and the cell out of the list if nothing is left in it.
    fn remove(&mut self, mover: &Mover) {
        let hash = self.hash.of(mover.from);
        let handle = self.table[hash as usize] as usize;
        let used = &mut self.cells[handle];
        let (entry, end) = (mover.entry as usize, used.range().end);
        self.pool.shift(entry + 1..end, entry);
        self.pool.entries.rows[end - 1] = NOBODY;
        used.len -= 1;
        if used.len == 0 {
            self.pool.release(used.start, used.capacity);
            self.table[hash as usize] = EMPTY;
            self.cells.swap_remove(handle);
            if let Some(moved) = self.cells.get(handle) {
                self.table[moved.hash as usize] = handle as u32;
            }
        } else if used.collision {
            let mut cells = used.range().map(|entry| self.pool.cell(&self.grid, entry));
            used.cell = cells.next().unwrap_or(used.cell);
            used.collision = cells.any(|cell| cell != used.cell);
        }
    }

    /// Copies the positions of all points and finds those that changed their cell or are gone, in parallel (paper
    /// 4.5.1, first loop); says how many.
    fn copy_and_compare(&mut self, points: &[Vec4], execution: &Execution) -> usize {
        let grid = &self.grid;
        let Entries { rows, positions } = &mut self.pool.entries;
        let [x, y, z] = positions;
        self.movers
            .resize_with(rows.len().div_ceil(CHUNK), Vec::new);
        execution.install(|| {
            self.movers
                .par_iter_mut()
                .zip(rows.par_chunks(CHUNK))
                .zip(x.par_chunks_mut(CHUNK))
                .zip(y.par_chunks_mut(CHUNK))
                .zip(z.par_chunks_mut(CHUNK))
                .enumerate()
                .for_each(|(chunk, ((((movers, rows), x), y), z))| {
                    movers.clear();
                    execution.instruction_set.dispatch(Compare {
                        grid,
                        points,
                        first: (chunk * CHUNK) as u32,
                        rows,
                        positions: [x, y, z],
                        movers,
                    });
                });
        });
        self.movers.iter().map(Vec::len).sum()
    }
}

impl SpatialIndex for CompactHashing {
    fn update(&mut self, points: &[Vec4], execution: &Execution) -> Result<(), DomainTooLarge> {
        self.state = State::new();
        let hash = self.hash.resized(points.len(), self.handles_a_point);
        if self.len == 0 || points.is_empty() || hash.size != self.hash.size {
            return self.rebuild(points, execution);
        }
        if self.copy_and_compare(points, execution) > points.len() / 4 {
            return self.rebuild(points, execution);
        }
        let movers = std::mem::take(&mut self.movers);
        // The last first: what follows a removed entry moves up.
        for mover in movers.iter().rev().flat_map(|chunk| chunk.iter().rev()) {
            self.remove(mover);
        }
        let moved = movers.iter().flatten().map(|mover| mover.row);
        let moved = moved.filter(|&row| (row as usize) < points.len());
        let spawned = self.len as u32..points.len() as u32;
        for row in moved.chain(spawned) {
            let cell = self.grid.cell_of(points[row as usize]);
            self.insert(cell, std::iter::once(row), points);
        }
        self.movers = movers;
        self.len = points.len();
        Ok(())
    }

    fn rebuild(&mut self, points: &[Vec4], execution: &Execution) -> Result<(), DomainTooLarge> {
        self.state = State::new();
        self.hash = self.hash.resized(points.len(), self.handles_a_point);
        self.table.clear();
        self.table.resize(self.hash.size, EMPTY);
        self.cells.clear();
        self.pool.clear();
        let mut handles = std::mem::take(&mut self.handles);
        z_curve::sort_handles(points, &self.grid, execution, &mut handles);
        // Runs of one key are one spatial cell, but for cells so far apart that they share a key.
        let grid = self.grid.clone();
        let cell = |handle: &z_curve::Handle| grid.cell_of(points[handle.1 as usize]);
        for run in handles.chunk_by(|a, b| a.0 == b.0 && cell(a) == cell(b)) {
            self.insert(cell(&run[0]), run.iter().map(|handle| handle.1), points);
        }
        self.handles = handles;
        self.len = points.len();
        Ok(())
    }

    fn grid(&self) -> &Grid {
        &self.grid
    }

    fn places(&self) -> usize {
        self.cells.len()
    }

    fn place_len(&self, place: usize) -> usize {
        self.cells[place].len as usize
    }

    fn group(&self, place: usize, from: usize) -> Option<(IVec3, &[u32])> {
        let used = &self.cells[place];
        let range = used.start as usize + from..used.range().end;
        if range.is_empty() {
            return None;
        }
        let rows = &self.pool.entries.rows[range.clone()];
        if !used.collision {
            return Some((used.cell, rows));
        }
        let mut cells = range.map(|entry| self.pool.cell(&self.grid, entry));
        let cell = cells.next()?;
        let len = 1 + cells.take_while(|&other| other == cell).count();
        Some((cell, &rows[..len]))
    }

    fn entries(&self) -> &Entries {
        &self.pool.entries
    }

    fn runs(&self, center: IVec3, out: &mut Vec<Run>) {
        if self.cells.is_empty() {
            return;
        }
        let around = self.grid.neighbourhood.iter();
        let cells = around.map(|&offset| center.wrapping_add(offset));
        let look_up = |cell| self.look_up(cell);
        lookups::each(self.state, cells, look_up, |run| {
            if run.len > 0 {
                out.push(run);
            }
        });
    }

    fn bytes(&self) -> usize {
        let movers: usize = self.movers.iter().map(Vec::capacity).sum();
        let free: usize = self.pool.free.iter().map(Vec::capacity).sum();
        (self.table.capacity() + free) * size_of::<u32>()
            + self.cells.capacity() * size_of::<UsedCell>()
            + self.pool.entries.bytes()
            + self.handles.capacity() * size_of::<z_curve::Handle>()
            + movers * size_of::<Mover>()
    }
}
