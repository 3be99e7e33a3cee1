//! The data structure, and the operations on one of its cells: insert a point, allocate more blocks, mark the
//! neighbourhood.

use super::super::structure::Structure;
use std::sync::atomic::AtomicU32;

use glam::{IVec3, Vec4};

use super::{
    super::{
        entries::Run,
        grid::Grid,
        hash::{self, CellHash, MIN_TABLE},
    },
    departed::{Departed, Moves},
    links::Links,
    pool::Pool,
    used_cell::{Count, UsedCell},
};

/// Hash cells per point (4.4: "a hash table size of two times the number of particles is appropriate").
const HANDLES_PER_POINT: f32 = 2.0;

/// The structure of the paper's Figure 3.
pub struct CompactHashing {
    pub(super) grid: Grid,
    pub(super) handles_per_point: f32,
    pub(super) hash: CellHash,
    /// The used cell of every hash value, or `NONE`.
    pub(super) table: Vec<u32>,
    /// A Bloom filter with one hash: a bit is set if a cell may have a point within reach. Most fluid cells are far
    /// from walls, and one test of this filter replaces 27 look-ups in the walls' index. Bits stay set until the next
    /// rebuild.
    pub(super) cell_filter: Vec<u64>,
    pub(super) cells: Vec<UsedCell>,
    pub(super) links: Links,
    pub(super) pool: Pool,
    /// Number of points.
    pub(super) len: usize,
    /// Movements of points since the last step, per chunk of blocks.
    pub(super) moves: Vec<Moves>,
    /// Points whose new block belongs to another chunk than the old one, per destination chunk.
    pub(super) arrivals: Vec<Vec<Departed>>,
    /// Used cells that lost a point and must be compacted.
    pub(super) reduced: Vec<u32>,
    /// Used cells that lost their last point.
    pub(super) emptied: Vec<u32>,
    /// Spatial cells that appeared, disappeared or changed their used cell.
    pub(super) changed: Vec<IVec3>,
    /// The used cells around these.
    pub(super) around: Vec<u32>,
}

/// The structure's row.
pub(in crate::index) const ROW: Structure = Structure {
    build: |grid, expected| Box::new(CompactHashing::new(grid, expected)),
    table: None,
    bytes_per_particle: 77.0,
};

impl CompactHashing {
    /// An empty index for `particles_per_cell` particles in a cell filled with fluid.
    pub fn new(grid: Grid, particles_per_cell: f32) -> Self {
        // Twice that number, so that a compressed cell rarely needs several blocks: blocks are searched one by one.
        // Reserving 1.5 times the number made the search of a jittered lattice 6 % slower.
        let reserved = (2.0 * particles_per_cell).ceil().clamp(2.0, 1024.0) as usize;
        Self {
            links: Links::new(&grid),
            grid,
            handles_per_point: HANDLES_PER_POINT,
            hash: CellHash::new(MIN_TABLE),
            table: Vec::new(),
            cell_filter: Vec::new(),
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

    /// As [`new`](Self::new), but always with the smallest table, so that nearly every cell collides.
    #[cfg(test)]
    pub(crate) fn with_smallest_table(grid: Grid, particles_per_cell: f32) -> Self {
        let mut index = Self::new(grid, particles_per_cell);
        index.handles_per_point = 0.0;
        index
    }

    /// Share of the used cells that hold points of several spatial cells \[-].
    pub fn collision_share(&self) -> f32 {
        self.cells.iter().filter(|cell| cell.collision()).count() as f32
            / self.cells.len().max(1) as f32
    }

    /// The used cell at the hash value of `cell`.
    #[inline(always)]
    pub(super) fn used(&self, cell: IVec3) -> Option<(u32, &UsedCell)> {
        let handle = self.table[self.hash.of(cell) as usize];
        Some((handle, self.cells.get(handle as usize)?))
    }

    /// End of the run of entries that starts at `from` and belongs to `cell`. The stretch has `len` entries from block
    /// `first` on; entries of one spatial cell are contiguous.
    #[inline]
    pub(super) fn end_of_alike(&self, (first, len): (u32, u32), from: u32, cell: IVec3) -> u32 {
        let alike = |k: &u32| self.pool.cell(&self.grid, first, *k) == cell;
        // There are rarely more than two spatial cells: if the last entry matches, all entries in between do.
        if alike(&(len - 1)) {
            return len;
        }
        from + (from..len).take_while(alike).count() as u32
    }

    /// Appends the runs of spatial cell `cell` within a used cell.
    #[inline(never)]
    pub(super) fn find_in(&self, used: &UsedCell, cell: IVec3, out: &mut Vec<Run>) {
        let mut from = 0;
        let mut end = used.primary_len.get();
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

    /// Adds a point to the used cell of its hash, or to a new one. Returns whether the point is the first of its
    /// spatial cell.
    pub(super) fn insert(&mut self, handle: u32, cell: IVec3, row: u32, point: Vec4) -> bool {
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
                primary_len: Count(AtomicU32::new(1)),
            });
            return true;
        };
        let (len, primary_len) = (used.len.get(), used.primary_len.get());
        if len == 0 && used.cell != cell {
            self.changed.push(used.cell);
            used.cell = cell;
        }
        let is_of_the_first = used.cell == cell;
        used.len.set(len + 1);
        used.primary_len
            .set(primary_len + u32::from(is_of_the_first));
        let first = if len < used.blocks * self.pool.reserved() as u32 {
            used.first
        } else {
            let blocks = 2 * used.blocks;
            self.move_to_blocks(blocks, handle, len)
        };
        // Points of one spatial cell are contiguous, so that a query returns them as runs. They are ordered by row, so
        // that the order of neighbours does not depend on how the points arrived.
        let (mut begin, mut place) = (0, primary_len);
        if !is_of_the_first {
            let is_same_cell = |k: &u32| self.pool.cell(&self.grid, first, *k) == cell;
            begin = (primary_len..len).find(is_same_cell).unwrap_or(len);
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

    /// Moves the first `len` entries of a used cell to a stretch of `blocks` blocks. Returns the first block.
    pub(super) fn move_to_blocks(&mut self, blocks: u32, handle: u32, len: u32) -> u32 {
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

    /// Word and bit of a cell in [`cell_filter`](Self::cell_filter), whose size is a power of two.
    #[inline(always)]
    pub(super) fn filter_bit(&self, cell: IVec3) -> (usize, u64) {
        let bit = hash::mix(cell) as usize & (64 * self.cell_filter.len() - 1);
        (bit / 64, 1 << (bit % 64))
    }

    /// Marks all cells within reach of `cell`.
    pub(super) fn add_to_filter(&mut self, cell: IVec3) {
        for k in 0..self.grid.neighbourhood.len() {
            let around = cell.wrapping_add(self.grid.neighbourhood[k]);
            let (word, bit) = self.filter_bit(around);
            self.cell_filter[word] |= bit;
        }
    }
}
