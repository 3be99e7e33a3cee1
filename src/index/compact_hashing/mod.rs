//! Compact hashing (paper 4.5): a hash table of handles and a compact list of the cells that hold points.
//!
//! - The table has 2 N handles (4.4: "two times the number of particles"), placed by equation 3; a handle names a used
//!   cell. N here is the number of points at the last rebuild; the table follows when it grows or falls by half.
//! - A used cell reserves a block of k entries in one pool and moves to twice as many when they are full, and back when
//!   two thirds of half of them would do.
//! - [`update`](SpatialIndex::update) compares every point's cell with the last step's and moves only those that
//!   changed (4.5.1; `comparison.rs`, `moves.rs`). Cells that are empty then leave the list.
//! - A used cell knows whether it holds points of more than one spatial cell (4.5.3).
//! - [`rebuild`](SpatialIndex::rebuild) inserts the points in the order of their rows. Where rows follow the Z-curve, used
//!   cells that follow each other are near each other (4.5.4).
//! - The query goes over the used cells in parallel (4.5.2).
//!
//! Deviations. Entries hold a copy of their positions (see `entries.rs`); one loop over the entries both compares and
//! copies. A used cell keeps its spatial coordinates: candidates are taken from it only where they are the ones that
//! were asked for, so two neighbouring cells that share a hash cell are not seen twice. When more than a quarter of the
//! points changed their cell (a host spawned in the middle of the rows), all are inserted anew.
//!
//! A used cell links to the used cells around it, so that a query computes no hash (see `links.rs`); who comes or goes
//! tells the 26 around. Two used cells of a hundred hold several spatial cells, and to tell their points apart by
//! position for each of 27 queries took a seventh of all: the points of one of the cells come first and are counted,
//! and those of another, which are mostly the rest, are told by the last. Blocks begin with a cache line, and those
//! around the next cell are prefetched: with two threads the query of 131 072 points took a tenth less, of a million a
//! seventh.
//!
//! Tried and dropped: look-ups remembered by each thread for the cells nearby (a quarter of the query, where links take
//! a tenth; for cells of h/2, which have no links, 9.7 µs a point for 8.6 without), links that are looked up and set by
//! the query that needs them (a quarter), a bit for every place of the table that is in use (no difference), unknown
//! cells looked up together, so that their loads overlap (slower), what is around every cell near walls kept with the
//! walls (12 % of their search, 3 % of the whole, for 50 bytes a wall particle).

mod comparison;
mod links;
mod moves;
mod pool;

use std::sync::atomic::{AtomicU32, Ordering};

use glam::{IVec3, Vec4};

use self::{
    comparison::{Mover, Moves},
    links::{ABSENT, Links},
    pool::Pool,
};
use super::{
    Grid, SpatialIndex,
    entries::{Entries, Run},
    hash::{self, CellHash, MIN_TABLE},
};
use crate::state::DomainTooLarge;
use crate::state::Execution;

const EMPTY: u32 = u32::MAX;
/// Handles a point (4.4: "a hash table size of two times the number of particles is appropriate").
const HANDLES_A_POINT: f32 = 2.0;

/// Bits of [`CompactHashing::reached`] a point: about 64 a used cell of edge h.
const BITS_A_POINT: usize = 8;

/// The structure of the paper's Figure 3.
pub struct CompactHashing {
    grid: Grid,
    handles_a_point: f32,
    hash: CellHash,
    /// For every hash its used cell, or `EMPTY`.
    table: Vec<u32>,
    /// Cells that may have a point within reach, a bit each by a hash of its own: most cells of a fluid are far from
    /// any wall, and this is one question for 27. Bits stay when points go, until the next rebuild.
    reached: Vec<u64>,
    cells: Vec<UsedCell>,
    links: Links,
    pool: Pool,
    /// Number of points.
    len: usize,
    /// What points did since the last step, by chunk of blocks.
    moves: Vec<Moves>,
    /// Points that come to a block of another chunk than they left, by chunk.
    arrivals: Vec<Vec<Mover>>,
    /// Used cells that lost a point and need another look.
    reduced: Vec<u32>,
    /// Used cells that lost their last point.
    emptied: Vec<u32>,
    /// Spatial cells that appeared, vanished or are in another used cell.
    changed: Vec<IVec3>,
    /// The used cells around those.
    around: Vec<u32>,
}

/// A non-empty hash cell.
#[derive(Debug)]
struct UsedCell {
    /// Spatial cell of all its points, or of the first.
    cell: IVec3,
    /// Its place in the table.
    hash: u32,
    /// Its first block in the pool.
    first: u32,
    /// Blocks reserved, a power of two.
    blocks: u32,
    /// Number of points.
    len: Count,
    /// How many of them, the first, are in spatial cell `cell`.
    kin: Count,
}

/// A number of points. In parallel loops a thread counts in the simple used cells of the blocks that are its own, and
/// looks at no others: what it reads does not depend on the other threads.
#[derive(Debug)]
struct Count(AtomicU32);

impl Count {
    #[inline(always)]
    fn get(&self) -> u32 {
        self.0.load(Ordering::Relaxed)
    }

    #[inline(always)]
    fn set(&self, count: u32) {
        self.0.store(count, Ordering::Relaxed);
    }
}

impl UsedCell {
    /// The paper's collision flag: whether it holds points of several spatial cells.
    fn collision(&self) -> bool {
        self.kin.get() < self.len.get()
    }

    /// Whether it holds points of one spatial cell in one block, as nearly all do.
    fn is_simple(&self) -> bool {
        !self.collision() && self.blocks == 1
    }

    /// Counts the points of a simple used cell.
    #[inline(always)]
    fn set_len(&self, len: u32) {
        self.len.set(len);
        self.kin.set(len);
    }
}

impl CompactHashing {
    /// An empty index that expects `particles_a_cell` where there is fluid.
    pub fn new(grid: Grid, particles_a_cell: f32) -> Self {
        // A compressed or unlucky cell need not move, nor be of several blocks, which are looked through one by one:
        // half as many again made the search of a jittered lattice 6 % slower.
        let reserved = (2.0 * particles_a_cell).ceil().clamp(2.0, 1024.0) as usize;
        Self {
            links: Links::new(&grid),
            grid,
            handles_a_point: HANDLES_A_POINT,
            hash: CellHash::new(MIN_TABLE),
            table: Vec::new(),
            reached: Vec::new(),
            cells: Vec::new(),
            pool: Pool::new(reserved),
            len: 0,
            moves: Vec::new(),
            arrivals: Vec::new(),
            reduced: Vec::new(),
            emptied: Vec::new(),
            changed: Vec::new(),
            around: Vec::new(),
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
        self.cells.iter().filter(|cell| cell.collision()).count() as f32
            / self.cells.len().max(1) as f32
    }

    /// The used cell of the hash of `cell`.
    #[inline(always)]
    fn used(&self, cell: IVec3) -> Option<(u32, &UsedCell)> {
        let handle = self.table[self.hash.of(cell) as usize];
        Some((handle, self.cells.get(handle as usize)?))
    }

    /// Of the `len` entries from block `first` on, those of the same spatial cell as the one at `from`, which are side
    /// by side, end here.
    #[inline]
    fn end_of_alike(&self, (first, len): (u32, u32), from: u32, cell: IVec3) -> u32 {
        let alike = |k: &u32| self.pool.cell(&self.grid, first, *k) == cell;
        // Seldom there are more than two spatial cells, and the last entry tells for all between.
        if alike(&(len - 1)) {
            return len;
        }
        from + (from..len).take_while(alike).count() as u32
    }

    /// Appends the entries of spatial cell `cell` among those of a used cell.
    #[inline(never)]
    fn find_in(&self, used: &UsedCell, cell: IVec3, out: &mut Vec<Run>) {
        let mut from = 0;
        let mut end = used.kin.get();
        if used.cell != cell {
            let alike = |k: &u32| self.pool.cell(&self.grid, used.first, *k) == cell;
            let Some(start) = (end..used.len.get()).find(alike) else {
                return;
            };
            from = start;
            end = self.end_of_alike((used.first, used.len.get()), start, cell);
        }
        while from < end {
            let run = self.pool.run(used.first, from, end);
            from += run.len;
            out.push(run);
        }
    }

    /// Adds a point to a used cell of its hash, or to a new one; says whether it is the first of its spatial cell.
    fn insert(&mut self, handle: u32, cell: IVec3, row: u32, point: Vec4) -> bool {
        let Some(used) = self.cells.get_mut(handle as usize) else {
            let handle = self.cells.len() as u32;
            let first = self.pool.allocate(1, handle);
            self.pool.set(first, 0, row, point);
            let hash = self.hash.of(cell);
            self.table[hash as usize] = handle;
            self.cells.push(UsedCell {
                cell,
                hash,
                first,
                blocks: 1,
                len: Count(AtomicU32::new(1)),
                kin: Count(AtomicU32::new(1)),
            });
            return true;
        };
        let (len, kin) = (used.len.get(), used.kin.get());
        if len == 0 && used.cell != cell {
            self.changed.push(used.cell);
            used.cell = cell;
        }
        let is_of_the_first = used.cell == cell;
        used.len.set(len + 1);
        used.kin.set(kin + u32::from(is_of_the_first));
        let first = if len < used.blocks * self.pool.reserved() as u32 {
            used.first
        } else {
            let blocks = 2 * used.blocks;
            self.move_to_blocks(blocks, handle, len)
        };
        // Points of one spatial cell stay side by side, so that they can be handed out as runs, and in the order of
        // their rows, so that neighbours come in one order however the points got there.
        let (mut begin, mut place) = (0, kin);
        if !is_of_the_first {
            let is_kin = |k: &u32| self.pool.cell(&self.grid, first, *k) == cell;
            begin = (kin..len).find(is_kin).unwrap_or(len);
            place = begin;
            if begin < len {
                place = self.end_of_alike((first, len), begin, cell);
            }
        }
        let new = begin == place;
        while place > begin && self.pool.row(first, place - 1) > row {
            place -= 1;
        }
        self.pool.open_gap(first, place, len);
        self.pool.set(first, place, row, point);
        new
    }

    /// Moves the first `len` entries of a used cell to a stretch of so many blocks; says which is the first.
    fn move_to_blocks(&mut self, blocks: u32, handle: u32, len: u32) -> u32 {
        let UsedCell {
            first, blocks: old, ..
        } = self.cells[handle as usize];
        let new = self.pool.allocate(blocks, handle);
        for k in 0..len {
            self.pool.copy((first, k), (new, k));
            self.pool.clear_entry(first, k);
        }
        self.pool.release(first, old);
        let used = &mut self.cells[handle as usize];
        (used.first, used.blocks) = (new, blocks);
        new
    }

    /// Brings the points that changed their cell to the new one.
    fn follow(&mut self, points: &[Vec4], execution: &Execution) -> Result<(), DomainTooLarge> {
        let hash = self.hash.resized(points.len(), self.handles_a_point);
        if self.len == 0 || points.is_empty() || hash.size != self.hash.size {
            return self.rebuild(points, execution);
        }
        self.copy_and_compare(points, execution);
        if self.moved() > points.len() / 4 {
            return self.rebuild(points, execution);
        }
        self.account_for_departures();
        self.put_in(points, execution);
        for (row, &point) in points.iter().enumerate().skip(self.len) {
            let cell = self.grid.cell_of(point);
            let handle = self.table[self.hash.of(cell) as usize];
            if self.insert(handle, cell, row as u32, point) {
                self.reach_from(cell);
                self.changed.push(cell);
            }
        }
        self.relink(execution);
        self.drop_emptied();
        // What drops moved of cells that share a used cell.
        self.relink(execution);
        self.len = points.len();
        Ok(())
    }

    /// The hash of [`reached`](Self::reached), whose size is a power of two.
    #[inline(always)]
    fn reach_bit(&self, cell: IVec3) -> (usize, u64) {
        let bit = hash::mix(cell) as usize & (64 * self.reached.len() - 1);
        (bit / 64, 1 << (bit % 64))
    }

    /// Marks the cells within reach of `cell`.
    fn reach_from(&mut self, cell: IVec3) {
        for k in 0..self.grid.neighbourhood.len() {
            let around = cell.wrapping_add(self.grid.neighbourhood[k]);
            let (word, bit) = self.reach_bit(around);
            self.reached[word] |= bit;
        }
    }

    /// Takes the used cells without a point off the list, the last first, so that none of them takes another's place.
    fn drop_emptied(&mut self) {
        let mut emptied = std::mem::take(&mut self.emptied);
        emptied.sort_unstable_by(|a, b| b.cmp(a));
        emptied.dedup();
        for handle in emptied.drain(..) {
            let used = &self.cells[handle as usize];
            if used.len.get() > 0 {
                continue;
            }
            self.pool.release(used.first, used.blocks);
            self.table[used.hash as usize] = EMPTY;
            self.point_links_at(handle, ABSENT);
            self.cells.swap_remove(handle as usize);
            let last = self.cells.len() as u32;
            if let Some(moved) = self.cells.get(handle as usize) {
                self.table[moved.hash as usize] = handle;
                self.pool.give(moved.first, moved.blocks, handle);
                for k in moved.kin.get()..moved.len.get() {
                    let cell = self.pool.cell(&self.grid, moved.first, k);
                    self.changed.push(cell);
                }
                self.links.copy(last, handle);
                self.point_links_at(handle, handle);
            }
            self.links.resize(self.cells.len());
        }
        self.emptied = emptied;
    }
}

impl SpatialIndex for CompactHashing {
    fn update(&mut self, points: &[Vec4], execution: &Execution) -> Result<(), DomainTooLarge> {
        // The threads are entered once for all loops: the serial parts between them go along.
        execution.install(|| self.follow(points, execution))
    }

    fn rebuild(&mut self, points: &[Vec4], execution: &Execution) -> Result<(), DomainTooLarge> {
        self.hash = self.hash.resized(points.len(), self.handles_a_point);
        self.table.clear();
        self.table.resize(self.hash.size, EMPTY);
        let words = (points.len() * BITS_A_POINT)
            .div_ceil(64)
            .next_power_of_two();
        self.reached.clear();
        self.reached.resize(words, 0);
        self.cells.clear();
        self.pool.clear();
        for (row, &point) in points.iter().enumerate() {
            let cell = self.grid.cell_of(point);
            let handle = self.table[self.hash.of(cell) as usize];
            if self.insert(handle, cell, row as u32, point) {
                self.reach_from(cell);
            }
        }
        self.link_all(execution);
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
        self.cells[place].len.get() as usize
    }

    fn group(&self, place: usize, from: usize) -> Option<(IVec3, &[u32])> {
        let (used, from) = (&self.cells[place], from as u32);
        if from >= used.len.get() {
            return None;
        }
        let kin = used.kin.get();
        if from < kin {
            let run = self.pool.run(used.first, from, kin);
            return Some((used.cell, self.pool.entries.rows(run)));
        }
        let first = self.pool.cell(&self.grid, used.first, from);
        let end = self.end_of_alike((used.first, used.len.get()), from, first);
        let run = self.pool.run(used.first, from, end);
        Some((first, self.pool.entries.rows(run)))
    }

    fn entries(&self) -> &Entries {
        &self.pool.entries
    }

    fn runs(&self, center: IVec3, out: &mut Vec<Run>) {
        if self.cells.is_empty() {
            return;
        }
        let (word, bit) = self.reach_bit(center);
        if self.reached[word] & bit == 0 {
            return;
        }
        if let Some((handle, used)) = self.used(center)
            && used.cell == center
            && self.links.each() > 0
        {
            return self.runs_around(handle as usize, center, out);
        }
        for &offset in &self.grid.neighbourhood {
            let cell = center.wrapping_add(offset);
            if let Some((_, used)) = self.used(cell) {
                self.find_in(used, cell, out);
            }
        }
    }

    fn runs_around(&self, place: usize, center: IVec3, out: &mut Vec<Run>) {
        if self.cells[place].cell != center || self.links.each() == 0 {
            return self.runs(center, out);
        }
        let links = self.links.of(place);
        out.reserve(links.len());
        for (k, &link) in links.iter().enumerate() {
            let Some(used) = self.cells.get(link as usize) else {
                continue;
            };
            if used.is_simple() {
                // Nearly all: one run, of the cell that was asked for.
                out.push(self.pool.run(used.first, 0, used.len.get()));
            } else {
                self.find_in(used, center.wrapping_add(self.grid.neighbourhood[k]), out);
            }
        }
    }

    /// Of the used cells before it most were asked for before. The query of a million points gains a tenth to a fifth,
    /// one of 13 000, which the caches hold, loses up to a tenth.
    fn prefetch_around(&self, place: usize) {
        if place >= self.cells.len() || self.links.each() == 0 {
            return;
        }
        for &link in self.links.of(place) {
            if link as usize >= place
                && let Some(used) = self.cells.get(link as usize)
            {
                self.pool.prefetch(used.first);
            }
        }
    }

    fn bytes(&self) -> usize {
        let moves: usize = self.moves.iter().map(Moves::bytes).sum();
        let arrivals: usize = self.arrivals.iter().map(Vec::capacity).sum();
        let handles = [&self.table, &self.emptied, &self.reduced, &self.around];
        let handles: usize = handles.into_iter().map(Vec::capacity).sum();
        handles * size_of::<u32>()
            + self.changed.capacity() * size_of::<IVec3>()
            + self.cells.capacity() * size_of::<UsedCell>()
            + self.reached.capacity() * size_of::<u64>()
            + self.links.bytes()
            + self.pool.bytes()
            + moves
            + arrivals * size_of::<Mover>()
    }
}
