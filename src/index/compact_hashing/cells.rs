//! The structure, and what is done to one of its cells: a point put in, more blocks, marks within reach.

use super::super::structure::Structure;
use std::sync::atomic::AtomicU32;

use glam::{IVec3, Vec4};

use super::{
    super::{
        entries::Run,
        grid::Grid,
        hash::{self, CellHash, MIN_TABLE},
    },
    links::Links,
    movers::{Mover, Moves},
    pool::Pool,
    used_cell::{Count, UsedCell},
};

pub(super) const EMPTY: u32 = u32::MAX;
/// Handles a point (4.4: "a hash table size of two times the number of particles is appropriate").
const HANDLES_A_POINT: f32 = 2.0;

/// The structure of the paper's Figure 3.
pub struct CompactHashing {
    pub(super) grid: Grid,
    pub(super) handles_a_point: f32,
    pub(super) hash: CellHash,
    /// For every hash its used cell, or `EMPTY`.
    pub(super) table: Vec<u32>,
    /// Cells that may have a point within reach, a bit each by a hash of its own: most cells of a fluid are far from
    /// any wall, and this is one question for 27. Bits stay when points go, until the next rebuild.
    pub(super) reached: Vec<u64>,
    pub(super) cells: Vec<UsedCell>,
    pub(super) links: Links,
    pub(super) pool: Pool,
    /// Number of points.
    pub(super) len: usize,
    /// What points did since the last step, by chunk of blocks.
    pub(super) moves: Vec<Moves>,
    /// Points that come to a block of another chunk than they left, by chunk.
    pub(super) arrivals: Vec<Vec<Mover>>,
    /// Used cells that lost a point and need another look.
    pub(super) reduced: Vec<u32>,
    /// Used cells that lost their last point.
    pub(super) emptied: Vec<u32>,
    /// Spatial cells that appeared, vanished or are in another used cell.
    pub(super) changed: Vec<IVec3>,
    /// The used cells around those.
    pub(super) around: Vec<u32>,
}

/// The structure's row.
pub(in crate::index) const ROW: Structure = Structure {
    build: |grid, expected| Box::new(CompactHashing::new(grid, expected)),
    table: None,
    bytes_per_particle: 77.0,
};

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
    pub(super) fn used(&self, cell: IVec3) -> Option<(u32, &UsedCell)> {
        let handle = self.table[self.hash.of(cell) as usize];
        Some((handle, self.cells.get(handle as usize)?))
    }

    /// Of the `len` entries from block `first` on, those of the same spatial cell as the one at `from`, which are side
    /// by side, end here.
    #[inline]
    pub(super) fn end_of_alike(&self, (first, len): (u32, u32), from: u32, cell: IVec3) -> u32 {
        let alike = |k: &u32| self.pool.cell(&self.grid, first, *k) == cell;
        // Seldom there are more than two spatial cells, and the last entry tells for all between.
        if alike(&(len - 1)) {
            return len;
        }
        from + (from..len).take_while(alike).count() as u32
    }

    /// Appends the entries of spatial cell `cell` among those of a used cell.
    #[inline(never)]
    pub(super) fn find_in(&self, used: &UsedCell, cell: IVec3, out: &mut Vec<Run>) {
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

    /// The hash of [`reached`](Self::reached), whose size is a power of two.
    #[inline(always)]
    pub(super) fn reach_bit(&self, cell: IVec3) -> (usize, u64) {
        let bit = hash::mix(cell) as usize & (64 * self.reached.len() - 1);
        (bit / 64, 1 << (bit % 64))
    }

    /// Marks the cells within reach of `cell`.
    pub(super) fn reach_from(&mut self, cell: IVec3) {
        for k in 0..self.grid.neighbourhood.len() {
            let around = cell.wrapping_add(self.grid.neighbourhood[k]);
            let (word, bit) = self.reach_bit(around);
            self.reached[word] |= bit;
        }
    }
}
