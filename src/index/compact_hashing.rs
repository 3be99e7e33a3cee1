//! Compact hashing (paper 4.5): a hash table of handles and a compact list of the cells that hold points.
//!
//! - The table has 2 N handles (4.4: "two times the number of particles"), placed by equation 3; a handle names a used
//!   cell. N here is the number of points at the last rebuild; the table follows when it grows or falls by half.
//! - A used cell reserves k entries in one pool and moves to twice as many when they are full.
//! - [`update`](SpatialIndex::update) compares every point's cell with the last step's, in parallel, and moves only
//!   those that changed, serially and in the order of the rows (4.5.1). An empty cell leaves the list at once.
//! - A flag says that a used cell holds points of more than one spatial cell (4.5.3); without it the hash indices
//!   around are computed once for all its points.
//! - [`rebuild`](SpatialIndex::rebuild) inserts Z-sorted points, so that used cells that follow each other are near each
//!   other (4.5.4).
//!
//! Deviations. The remainder by the table's size is computed by multiplication (Lemire, Kaser & Kurz 2019), the value
//! is that of equation 3. A used cell keeps its spatial coordinates: candidates are taken from it only where they are
//! the ones that were asked for, so two neighbouring cells that share a hash cell are not seen twice. When more than a
//! quarter of the points changed their cell (a host spawned in the middle of the rows), all are inserted anew.

use glam::{IVec3, Vec4};
use rayon::prelude::*;

use super::{Grid, SpatialIndex, z_curve};
use crate::{
    execution::{CHUNK, Execution},
    simd::Candidates,
};

const EMPTY: u32 = u32::MAX;
/// Cells whose handles are looked up at a time: all 27 of a neighbourhood in 3-D with d = h.
const BATCH: usize = 27;
/// The primes of equation 3.
const PRIMES: [u32; 3] = [73_856_093, 19_349_663, 83_492_791];
/// Handles a point (4.4: "a hash table size of two times the number of particles is appropriate").
const HANDLES_A_POINT: f32 = 2.0;
/// Smallest table, so that a scene of one particle has one too.
const MIN_TABLE: usize = 16;

/// The structure of the paper's Figure 3.
pub struct CompactHashing {
    grid: Grid,
    /// Entries reserved in a new used cell: the paper's k.
    reserved: usize,
    handles_a_point: f32,
    table: Table,
    cells: Vec<UsedCell>,
    entries: Pool,
    /// The spatial cell of every point as of the last update.
    cell_of_row: Vec<IVec3>,
    /// Points that changed their cell, by chunk of rows.
    movers: Vec<Vec<(u32, IVec3)>>,
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

/// Handles by hash (equation 3).
#[derive(Debug, Default)]
struct Table {
    handles: Vec<u32>,
    /// ⌈2⁶⁴ / size⌉: remainders by multiplication.
    reciprocal: u64,
}

impl Table {
    fn reset(&mut self, size: usize) {
        self.handles.clear();
        self.handles.resize(size, EMPTY);
        self.reciprocal = u64::MAX / size as u64 + 1;
    }

    #[inline(always)]
    fn handle(&self, cell: IVec3) -> u32 {
        self.handles[self.hash(cell) as usize]
    }

    #[inline(always)]
    fn hash(&self, cell: IVec3) -> u32 {
        let [x, y, z] = cell.to_array().map(|c| c as u32);
        let mixed =
            x.wrapping_mul(PRIMES[0]) ^ y.wrapping_mul(PRIMES[1]) ^ z.wrapping_mul(PRIMES[2]);
        let fraction = self.reciprocal.wrapping_mul(u64::from(mixed));
        ((u128::from(fraction) * self.handles.len() as u128) >> 64) as u32
    }
}

/// Memory of the used cells' entries: blocks of k, 2 k, 4 k, … rows.
#[derive(Debug, Default)]
struct Pool {
    rows: Vec<u32>,
    /// Blocks given back, by the logarithm of their size in k.
    free: Vec<Vec<u32>>,
}

impl Pool {
    fn clear(&mut self) {
        self.rows.clear();
        self.free.iter_mut().for_each(Vec::clear);
    }

    fn class(capacity: u32, reserved: usize) -> usize {
        (capacity as usize / reserved).ilog2() as usize
    }

    fn allocate(&mut self, capacity: u32, reserved: usize) -> u32 {
        if let Some(start) = self
            .free
            .get_mut(Self::class(capacity, reserved))
            .and_then(Vec::pop)
        {
            return start;
        }
        let start = self.rows.len() as u32;
        self.rows.resize(self.rows.len() + capacity as usize, EMPTY);
        start
    }

    fn release(&mut self, start: u32, capacity: u32, reserved: usize) {
        let class = Self::class(capacity, reserved);
        if self.free.len() <= class {
            self.free.resize_with(class + 1, Vec::new);
        }
        self.free[class].push(start);
    }
}

impl CompactHashing {
    /// An empty index that expects `particles_a_cell` where there is fluid.
    pub fn new(grid: Grid, particles_a_cell: f32) -> Self {
        let mut table = Table::default();
        table.reset(MIN_TABLE);
        Self {
            grid,
            // Half as many again: a compressed or unlucky cell need not move.
            handles_a_point: HANDLES_A_POINT,
            reserved: (1.5 * particles_a_cell).ceil().clamp(2.0, 1024.0) as usize,
            table,
            cells: Vec::new(),
            entries: Pool::default(),
            cell_of_row: Vec::new(),
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

    fn table_size(&self, points: usize) -> usize {
        ((points as f64 * f64::from(self.handles_a_point)) as usize).max(MIN_TABLE)
    }

    /// Share of the used cells that hold points of several spatial cells [-].
    pub fn collision_share(&self) -> f32 {
        self.cells.iter().filter(|cell| cell.collision).count() as f32
            / self.cells.len().max(1) as f32
    }

    /// Adds entries of spatial cell `cell` to the used cell of its hash, which it creates if there is none.
    fn insert(&mut self, cell: IVec3, rows: impl ExactSizeIterator<Item = u32>) {
        let hash = self.table.hash(cell);
        let used = match self.table.handles[hash as usize] {
            EMPTY => {
                let blocks = rows.len().div_ceil(self.reserved).next_power_of_two();
                let capacity = (blocks * self.reserved) as u32;
                self.table.handles[hash as usize] = self.cells.len() as u32;
                self.cells.push(UsedCell {
                    cell,
                    hash,
                    start: self.entries.allocate(capacity, self.reserved),
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
        let entries = &mut self.entries.rows[old.start..old.start + needed as usize];
        // Points of one spatial cell stay side by side, so that they can be handed out as a slice.
        let place = if used.collision {
            let kin = entries[..old.len()]
                .iter()
                .rposition(|&row| self.cell_of_row[row as usize] == cell);
            kin.map_or(old.len(), |kin| kin + 1)
        } else {
            old.len()
        };
        entries.copy_within(place..old.len(), place + rows.len());
        for (entry, row) in entries[place..].iter_mut().zip(rows) {
            *entry = row;
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
        let new_start = self.entries.allocate(larger, self.reserved);
        self.entries
            .rows
            .copy_within(self.cells[used].range(), new_start as usize);
        self.entries.release(start, capacity, self.reserved);
        self.cells[used].start = new_start;
        self.cells[used].capacity = larger;
    }

    /// Takes a point out of its cell, and the cell out of the list if nothing is left in it.
    fn remove(&mut self, cell: IVec3, row: u32) {
        let hash = self.table.hash(cell);
        let handle = self.table.handles[hash as usize] as usize;
        let used = &mut self.cells[handle];
        let entries = &mut self.entries.rows[used.range()];
        if let Some(place) = entries.iter().position(|&entry| entry == row) {
            entries.copy_within(place + 1.., place);
            used.len -= 1;
        }
        if used.len == 0 {
            let UsedCell {
                start, capacity, ..
            } = *used;
            self.entries.release(start, capacity, self.reserved);
            self.table.handles[hash as usize] = EMPTY;
            self.cells.swap_remove(handle);
            if let Some(moved) = self.cells.get(handle) {
                self.table.handles[moved.hash as usize] = handle as u32;
            }
        } else if used.collision {
            let cells = &self.cell_of_row;
            let entries = &self.entries.rows[used.range()];
            used.cell = cells[entries[0] as usize];
            used.collision = entries
                .iter()
                .any(|&entry| cells[entry as usize] != used.cell);
        }
    }

    /// Appends the points of a used cell that lie in spatial cell `cell`.
    #[inline]
    fn append(&self, used: &UsedCell, cell: IVec3, points: &[Vec4], out: &mut Candidates) {
        let rows = &self.entries.rows[used.range()];
        if !used.collision {
            if used.cell == cell {
                out.extend(rows, points);
            }
            return;
        }
        for row in rows {
            if self.cell_of_row[*row as usize] == cell {
                out.extend(std::slice::from_ref(row), points);
            }
        }
    }

    /// Finds the points that changed their cell, in parallel (paper 4.5.1, first loop), and says how many.
    fn find_movers(&mut self, points: &[Vec4], execution: &Execution) -> usize {
        let grid = &self.grid;
        self.movers
            .resize_with(points.len().div_ceil(CHUNK), Vec::new);
        execution.install(|| {
            self.movers
                .par_iter_mut()
                .zip(points.par_chunks(CHUNK))
                .zip(self.cell_of_row.par_chunks(CHUNK))
                .enumerate()
                .for_each(|(chunk, ((movers, points), cells))| {
                    movers.clear();
                    let rows = (chunk * CHUNK) as u32..;
                    movers.extend(rows.zip(points).zip(cells).filter_map(
                        |((row, &point), &old)| {
                            let cell = grid.cell_of(point);
                            (cell != old).then_some((row, cell))
                        },
                    ));
                });
        });
        self.movers.iter().map(Vec::len).sum()
    }
}

impl SpatialIndex for CompactHashing {
    fn update(&mut self, points: &[Vec4], execution: &Execution) {
        let known = self.cell_of_row.len();
        let (size, wanted) = (self.table.handles.len(), self.table_size(points.len()));
        if known == 0 || wanted > 2 * size || 4 * wanted < size {
            return self.rebuild(points, execution);
        }
        for row in points.len()..known {
            self.remove(self.cell_of_row[row], row as u32);
        }
        self.cell_of_row.truncate(points.len());
        for (row, &point) in points.iter().enumerate().skip(known) {
            let cell = self.grid.cell_of(point);
            self.cell_of_row.push(cell);
            self.insert(cell, std::iter::once(row as u32));
        }
        if self.find_movers(points, execution) > points.len() / 4 {
            return self.rebuild(points, execution);
        }
        let movers = std::mem::take(&mut self.movers);
        for &(row, cell) in movers.iter().flatten() {
            let old = std::mem::replace(&mut self.cell_of_row[row as usize], cell);
            self.remove(old, row);
            self.insert(cell, std::iter::once(row));
        }
        self.movers = movers;
    }

    fn rebuild(&mut self, points: &[Vec4], execution: &Execution) {
        self.table.reset(self.table_size(points.len()));
        self.cells.clear();
        self.entries.clear();
        let grid = &self.grid;
        execution.install(|| {
            points
                .par_iter()
                .map(|&point| grid.cell_of(point))
                .collect_into_vec(&mut self.cell_of_row);
        });
        let mut handles = std::mem::take(&mut self.handles);
        z_curve::sort_handles(points, &self.grid, execution, &mut handles);
        // Runs of one key are one spatial cell, but for cells so far apart that they share a key.
        let mut rest = handles.as_slice();
        while let Some(&(_, first)) = rest.first() {
            let cell = self.cell_of_row[first as usize];
            let len = rest
                .iter()
                .take_while(|handle| self.cell_of_row[handle.1 as usize] == cell)
                .count();
            let (run, after) = rest.split_at(len);
            self.insert(cell, run.iter().map(|handle| handle.1));
            rest = after;
        }
        self.handles = handles;
    }

    fn grid(&self) -> &Grid {
        &self.grid
    }

    fn cells(&self) -> usize {
        self.cells.len()
    }

    fn cell_len(&self, cell: usize) -> usize {
        self.cells[cell].len as usize
    }

    fn group(&self, cell: usize, from: usize) -> Option<(IVec3, &[u32])> {
        let used = &self.cells[cell];
        let rows = &self.entries.rows[used.range()][from..];
        let first = *rows.first()?;
        if !used.collision {
            return Some((used.cell, rows));
        }
        let cell = self.cell_of_row[first as usize];
        let len = rows
            .iter()
            .take_while(|&&row| self.cell_of_row[row as usize] == cell)
            .count();
        Some((cell, &rows[..len]))
    }

    fn candidates(&self, center: IVec3, points: &[Vec4], out: &mut Candidates) {
        // Two loops, so that the first's loads, which miss the cache and do not depend on each other, overlap.
        for offsets in self.grid.neighbourhood.chunks(BATCH) {
            let mut handles = [EMPTY; BATCH];
            for (handle, &offset) in handles.iter_mut().zip(offsets) {
                *handle = self.table.handle(center.wrapping_add(offset));
            }
            for (&handle, &offset) in handles.iter().zip(offsets) {
                if let Some(used) = self.cells.get(handle as usize) {
                    self.append(used, center.wrapping_add(offset), points, out);
                }
            }
        }
    }

    fn bytes(&self) -> usize {
        let movers: usize = self
            .movers
            .iter()
            .map(|m| m.capacity() * size_of::<(u32, IVec3)>())
            .sum();
        self.table.handles.capacity() * size_of::<u32>()
            + self.cells.capacity() * size_of::<UsedCell>()
            + self.entries.rows.capacity() * size_of::<u32>()
            + self.cell_of_row.capacity() * size_of::<IVec3>()
            + self.handles.capacity() * size_of::<z_curve::Handle>()
            + movers
    }
}
