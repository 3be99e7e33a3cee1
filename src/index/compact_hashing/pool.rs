//! Memory of the used cells' entries: stretches of one, two, four, … blocks of k.

use glam::{IVec3, Vec4};

use super::super::{
    Grid,
    entries::{Entries, NOBODY, PADDING, Run, Words, prefetch_block},
};

/// Blocks of k entries, in use and free.
#[derive(Debug)]
pub(super) struct Pool {
    pub(super) entries: Entries,
    /// The used cell that a block belongs to, by its handle.
    pub(super) owners: Vec<u32>,
    /// Stretches given back, by the logarithm of their number of blocks.
    free: Vec<Vec<u32>>,
}

/// Entries of a block are whole quarters of a vector, so that a block is copied without a rest.
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

    /// The paper's k.
    pub(super) fn reserved(&self) -> usize {
        self.entries.pitch
    }

    /// Gives all back.
    pub(super) fn clear(&mut self) {
        self.entries.words.resize(0);
        self.entries.words.resize(PADDING);
        self.owners.clear();
        self.free.iter_mut().for_each(Vec::clear);
    }

    /// The first of `blocks` free blocks, a power of two, which are used cell `owner`'s from now on.
    pub(super) fn allocate(&mut self, blocks: u32, owner: u32) -> u32 {
        let class = blocks.ilog2() as usize;
        let free = self.free.get_mut(class).and_then(Vec::pop);
        let first = free.unwrap_or_else(|| {
            let first = self.owners.len();
            let len = (first + blocks as usize) * 4 * self.reserved() + PADDING;
            self.entries.words.resize(len);
            self.owners.resize(first + blocks as usize, NOBODY);
            first as u32
        });
        self.give(first, blocks, owner);
        first
    }

    /// Gives a stretch to another used cell, or to nobody.
    pub(super) fn give(&mut self, first: u32, blocks: u32, owner: u32) {
        self.owners[first as usize..(first + blocks) as usize].fill(owner);
    }

    /// Takes a stretch without points back.
    pub(super) fn release(&mut self, first: u32, blocks: u32) {
        let class = blocks.ilog2() as usize;
        if self.free.len() <= class {
            self.free.resize_with(class + 1, Vec::new);
        }
        self.free[class].push(first);
        self.give(first, blocks, NOBODY);
    }

    /// Where the `k`-th entry of the stretch that begins with block `first` has its x.
    #[inline(always)]
    fn place(&self, first: u32, k: u32) -> usize {
        let pitch = self.reserved();
        let (first, k) = (first as usize, k as usize);
        if k < pitch {
            return 4 * first * pitch + k;
        }
        4 * (first + k / pitch) * pitch + k % pitch
    }

    /// The run of entries `from..end` of a stretch as far as it stays in one block.
    #[inline(always)]
    pub(super) fn run(&self, first: u32, from: u32, end: u32) -> Run {
        let pitch = self.reserved() as u32;
        let block = if from < pitch { 0 } else { from / pitch };
        Run {
            start: self.place(first, from) as u32,
            len: end.min((block + 1) * pitch) - from,
        }
    }

    /// Hints that the entries of a block are about to be read.
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

    /// Makes an entry nobody's.
    pub(super) fn clear_entry(&mut self, first: u32, k: u32) {
        let place = self.place(first, k) + 3 * self.reserved();
        self.entries.words[place] = NOBODY;
    }

    /// Moves the entries of a stretch up to its begin, in their order, over those that are nobody's.
    pub(super) fn close_gaps(&mut self, first: u32, blocks: u32) {
        let mut end = 0;
        for k in 0..blocks * self.reserved() as u32 {
            if self.row(first, k) != NOBODY {
                if end < k {
                    self.copy((first, k), (first, end));
                    self.clear_entry(first, k);
                }
                end += 1;
            }
        }
    }

    /// Moves the entries from the `k`-th of a stretch of `len` on up by one.
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

    /// Copies an entry, of one stretch or from one to another.
    pub(super) fn copy(&mut self, (first, k): (u32, u32), (to_first, to_k): (u32, u32)) {
        let (from, to) = (self.place(first, k), self.place(to_first, to_k));
        let pitch = self.reserved();
        for column in 0..4 {
            self.entries.words[to + column * pitch] = self.entries.words[from + column * pitch];
        }
    }

    /// The cell of the position that an entry holds.
    pub(super) fn cell(&self, grid: &Grid, first: u32, k: u32) -> IVec3 {
        let (place, pitch) = (self.place(first, k), self.reserved());
        let [x, y, z] =
            [0, 1, 2].map(|axis| f32::from_bits(self.entries.words[place + axis * pitch]));
        grid.cell_of(Vec4::new(x, y, z, 0.0))
    }

    /// Whether a stretch of so many blocks holds points of a cell.
    pub(super) fn holds(&self, grid: &Grid, (first, blocks): (u32, u32), cell: IVec3) -> bool {
        let entries = 0..blocks * self.reserved() as u32;
        // From the end: most who ask mean the last.
        let mut entries = entries.rev();
        entries.any(|k| self.row(first, k) != NOBODY && self.cell(grid, first, k) == cell)
    }

    /// Memory held [bytes].
    pub(super) fn bytes(&self) -> usize {
        let free: usize = self.free.iter().map(Vec::capacity).sum();
        self.entries.bytes() + (free + self.owners.capacity()) * size_of::<u32>()
    }
}
