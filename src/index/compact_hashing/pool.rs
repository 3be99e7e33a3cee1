//! Memory for the entries of used cells: contiguous stretches of 1, 2, 4, … blocks of k entries.

use glam::{IVec3, Vec4};

use super::super::{
    Grid,
    entries::{Entries, NONE, PADDING, Run, Words, prefetch_block},
};

/// Blocks of k entries, in use and free.
#[derive(Debug)]
pub(super) struct Pool {
    pub(super) entries: Entries,
    /// The handle of the used cell that owns a block, or `NONE`.
    pub(super) owners: Vec<u32>,
    /// Free stretches, by the binary logarithm of their number of blocks.
    free: Vec<Vec<u32>>,
}

/// The number of entries of a block is a multiple of this, so that quarter vectors cover a block exactly.
pub(super) const QUARTER: usize = 4;

impl Pool {
    /// An empty pool with blocks of at least `reserved` entries: the paper's k.
    pub(super) fn new(reserved: usize) -> Self {
        let mut entries = Entries {
            words: Words::default(),
            pitch: reserved.next_multiple_of(QUARTER),
        };
        entries.words.resize(PADDING);
        Self {
            entries,
            owners: Vec::new(),
            free: Vec::new(),
        }
    }

    /// Entries per block: the paper's k.
    pub(super) fn reserved(&self) -> usize {
        self.entries.pitch
    }

    /// Frees all blocks.
    pub(super) fn clear(&mut self) {
        self.entries.words.resize(0);
        self.entries.words.resize(PADDING);
        self.owners.clear();
        self.free.iter_mut().for_each(Vec::clear);
    }

    /// Allocates a stretch of `blocks` blocks, a power of two, to used cell `owner`. Returns the first block.
    pub(super) fn allocate(&mut self, blocks: u32, owner: u32) -> u32 {
        let class = blocks.ilog2() as usize;
        let free = self.free.get_mut(class).and_then(Vec::pop);
        let first = free.unwrap_or_else(|| {
            let first = self.owners.len();
            let len = (first + blocks as usize) * 4 * self.reserved() + PADDING;
            self.entries.words.resize(len);
            self.owners.resize(first + blocks as usize, NONE);
            first as u32
        });
        self.give(first, blocks, owner);
        first
    }

    /// Changes the owner of a stretch.
    pub(super) fn give(&mut self, first: u32, blocks: u32, owner: u32) {
        self.owners[first as usize..(first + blocks) as usize].fill(owner);
    }

    /// Frees a stretch that holds no points.
    pub(super) fn release(&mut self, first: u32, blocks: u32) {
        let class = blocks.ilog2() as usize;
        if self.free.len() <= class {
            self.free.resize_with(class + 1, Vec::new);
        }
        self.free[class].push(first);
        self.give(first, blocks, NONE);
    }

    /// Index of the x coordinate of the `k`-th entry of the stretch that begins with block `first`.
    #[inline(always)]
    fn place(&self, first: u32, k: u32) -> usize {
        let pitch = self.reserved();
        let (first, k) = (first as usize, k as usize);
        if k < pitch {
            return 4 * first * pitch + k;
        }
        4 * (first + k / pitch) * pitch + k % pitch
    }

    /// The part of the entries `from..end` of a stretch that lies in one block, as a run.
    #[inline(always)]
    pub(super) fn run(&self, first: u32, from: u32, end: u32) -> Run {
        let pitch = self.reserved() as u32;
        let block = if from < pitch { 0 } else { from / pitch };
        Run {
            start: self.place(first, from) as u32,
            len: end.min((block + 1) * pitch) - from,
        }
    }

    /// Prefetches the entries of a block.
    #[inline(always)]
    pub(super) fn prefetch(&self, block: u32) {
        let start = self.place(block, 0);
        let words = self.entries.words.get(start..start + 4 * self.reserved());
        words.into_iter().for_each(prefetch_block);
    }

    /// The row of an entry.
    pub(super) fn row(&self, first: u32, k: u32) -> u32 {
        self.entries.words[self.place(first, k) + 3 * self.reserved()]
    }

    pub(super) fn set(&mut self, first: u32, k: u32, row: u32, point: Vec4) {
        let (place, pitch) = (self.place(first, k), self.reserved());
        let [x, y, z, _] = point.to_array().map(f32::to_bits);
        for (column, word) in [x, y, z, row].into_iter().enumerate() {
            self.entries.words[place + column * pitch] = word;
        }
    }

    /// Marks an entry as empty.
    pub(super) fn clear_entry(&mut self, first: u32, k: u32) {
        let place = self.place(first, k) + 3 * self.reserved();
        self.entries.words[place] = NONE;
    }

    /// Compacts the entries of a stretch to its beginning, in their order.
    pub(super) fn close_gaps(&mut self, first: u32, blocks: u32) {
        let mut end = 0;
        for k in 0..blocks * self.reserved() as u32 {
            if self.row(first, k) != NONE {
                if end < k {
                    self.copy((first, k), (first, end));
                    self.clear_entry(first, k);
                }
                end += 1;
            }
        }
    }

    /// Shifts the entries from the `k`-th of a stretch of `len` on by one.
    pub(super) fn open_gap(&mut self, first: u32, k: u32, len: u32) {
        let pitch = self.reserved();
        if len as usize >= pitch {
            for k in (k..len).rev() {
                self.copy((first, k), (first, k + 1));
            }
            return;
        }
        let (from, end) = (self.place(first, k), self.place(first, len));
        for column in [0, 1, 2, 3].map(|column| column * pitch) {
            let entries = column + from..column + end;
            self.entries.words.copy_within(entries, column + from + 1);
        }
    }

    /// Copies an entry within a stretch or between stretches.
    pub(super) fn copy(&mut self, (first, k): (u32, u32), (to_first, to_k): (u32, u32)) {
        let (from, to) = (self.place(first, k), self.place(to_first, to_k));
        let pitch = self.reserved();
        for column in 0..4 {
            self.entries.words[to + column * pitch] = self.entries.words[from + column * pitch];
        }
    }

    /// The cell of the position that an entry stores.
    pub(super) fn cell(&self, grid: &Grid, first: u32, k: u32) -> IVec3 {
        let (place, pitch) = (self.place(first, k), self.reserved());
        let [x, y, z] =
            [0, 1, 2].map(|axis| f32::from_bits(self.entries.words[place + axis * pitch]));
        grid.cell_of(Vec4::new(x, y, z, 0.0))
    }

    /// Whether a stretch holds points of a cell.
    pub(super) fn holds(&self, grid: &Grid, (first, blocks): (u32, u32), cell: IVec3) -> bool {
        let entries = 0..blocks * self.reserved() as u32;
        // Backwards: mostly the last entries match.
        let mut entries = entries.rev();
        entries.any(|k| self.row(first, k) != NONE && self.cell(grid, first, k) == cell)
    }

    /// Memory held \[bytes].
    pub(super) fn bytes(&self) -> usize {
        let free: usize = self.free.iter().map(Vec::capacity).sum();
        self.entries.bytes() + (free + self.owners.capacity()) * size_of::<u32>()
    }
}
