//! Who changed its cell (paper 4.5.1), and the way of most of them, in parallel.
//!
//! One loop over all entries compares the cell of a point's new position with the one that it is in, copies the position,
//! and moves those up who follow one that leaves. Chunk by chunk those who left are then put in where they come to a
//! simple used cell of the same chunk, which is still in the cache: three of four. The others are in `moves.rs`.
//!
//! Rows and positions are asked for ahead. With time a block's points come from up to eight places in memory, which no
//! processor foresees: with two threads 131 072 points took 7 ns each as long as every point was where its row says, and
//! 12 to 15 later. What is asked for ahead takes 10. How far ahead, from 1 to 24 blocks, makes no difference.

use glam::{IVec3, Vec4};
use rayon::prelude::*;

use super::{
    super::{
        Grid,
        entries::{NOBODY, PADDING, prefetch_block},
        hash::CellHash,
    },
    CompactHashing, UsedCell,
    links::{ABSENT, Links},
    pool::QUARTER,
};
use crate::{
    execution::Execution,
    simd::{Cube, LANES, Lanes, Simd, Vectorised, prefetch},
};

/// Blocks that are one task: along the Z-curve 8 × 8 × 8 cells, whose points fit the second-level cache. Four of five who
/// leave a cell there come to another of them.
pub(super) const BLOCKS: usize = 512;

/// Blocks from the one at hand to those that are fetched ahead of it.
const BLOCKS_AHEAD: usize = 8;
/// The same of points.
const POINTS_AHEAD: usize = 3;

/// A point that left its cell and is in none.
#[derive(Debug, Clone, Copy)]
pub(super) struct Mover {
    pub(super) row: u32,
    /// The used cell that it left; then the one at the hash of the cell that it comes to.
    pub(super) handle: u32,
    /// The cell that it comes to.
    pub(super) to: IVec3,
}

/// What the points of a chunk of blocks did.
#[derive(Debug, Default)]
pub(super) struct Moves {
    /// Points that have no place yet.
    pub(super) movers: Vec<Mover>,
    /// Simple used cells that lost points, and how many.
    pub(super) lost: Vec<(u32, u32)>,
    /// Simple used cells that got a point.
    pub(super) gained: Vec<u32>,
    /// The used cells that are not simple and lost a point, and the spatial cell that it was in.
    pub(super) departures: Vec<(u32, IVec3)>,
}

impl Moves {
    fn clear(&mut self) {
        self.movers.clear();
        self.lost.clear();
        self.gained.clear();
        self.departures.clear();
    }

    /// Points that changed their cell, or are gone.
    pub(super) fn len(&self) -> usize {
        let simple: u32 = self.lost.iter().map(|&(_, lost)| lost).sum();
        simple as usize + self.departures.len()
    }

    /// Memory held [bytes].
    pub(super) fn bytes(&self) -> usize {
        self.movers.capacity() * size_of::<Mover>()
            + self.lost.capacity() * size_of::<(u32, u32)>()
            + self.gained.capacity() * size_of::<u32>()
            + self.departures.capacity() * size_of::<(u32, IVec3)>()
    }
}

/// What the comparison reads.
struct Comparison<'a> {
    grid: &'a Grid,
    cells: &'a [UsedCell],
    links: &'a Links,
    hash: CellHash,
    table: &'a [u32],
    points: &'a [Vec4],
}

/// A block whose entries are compared.
struct Block<'a> {
    owner: u32,
    used: &'a UsedCell,
    /// Where no point is a mover.
    interior: Option<Cube>,
    /// x, y and z, as bits.
    columns: [&'a mut [u32]; 3],
    rows: &'a mut [u32],
    /// Entries seen so far, and those of them that stay.
    seen: usize,
    end: usize,
}

impl Comparison<'_> {
    /// Asks for the rows of a block that comes soon, and for the positions of one that comes sooner: both are anywhere in
    /// memory but near those before.
    #[inline(always)]
    fn fetch_ahead(&self, words: &[u32], words_a_block: usize, k: usize) {
        let block = |k: usize| words.get(k * words_a_block..(k + 1) * words_a_block);
        if let Some(block) = block(k + BLOCKS_AHEAD) {
            prefetch_block(block);
        }
        let (Some(block), Some(last)) = (block(k + POINTS_AHEAD), self.points.len().checked_sub(1))
        else {
            return;
        };
        // Three quarters of the entries: few blocks have more points.
        for &row in &block[3 * words_a_block / 4..][..3 * words_a_block / 16] {
            prefetch(&self.points[last.min(row as usize)]);
        }
    }

    /// Copies the positions of a block's entries, and moves those up that follow one that leaves.
    #[inline(always)]
    fn block<S: Simd>(&self, simd: S, owner: u32, words: &mut [u32], moves: &mut Moves) {
        let Some(used) = self.cells.get(owner as usize) else {
            return;
        };
        let (columns, rows) = columns(words);
        let pitch = rows.len();
        let mut block = Block {
            owner,
            used,
            interior: (!used.collision()).then(|| self.grid.interior(used.cell)),
            columns,
            rows,
            seen: 0,
            end: 0,
        };
        for first in (0..pitch).step_by(LANES) {
            if block.rows[first] == NOBODY {
                break;
            }
            if pitch - first < LANES {
                self.entries::<S, QUARTER>(simd, first, &mut block, moves);
            } else {
                self.entries::<S, LANES>(simd, first, &mut block, moves);
            }
        }
        let Block { seen, end, .. } = block;
        if end < seen {
            // What those left behind who moved up.
            block.rows[end..].fill(NOBODY);
            if used.is_simple() {
                moves.lost.push((owner, (seen - end) as u32));
            }
        }
    }

    /// The same for `N` entries from `first`.
    #[inline(always)]
    fn entries<S: Simd, const N: usize>(
        &self,
        simd: S,
        first: usize,
        block: &mut Block,
        moves: &mut Moves,
    ) {
        let rows = simd.rows(&block.rows[first..first + N]);
        let [x, y, z, _] = simd.gather(self.points, rows);
        let inside = block
            .interior
            .map_or(0, |cell| simd.inside([x, y, z], cell));
        let known = simd.below(rows, self.points.len() as u32);
        let present = simd.below(rows, NOBODY);
        let mut stay = present & inside & known;
        let mut uncertain = present & !stay;
        while uncertain != 0 {
            let lane = uncertain.trailing_zeros() as usize;
            if self.stays(block, first + lane, moves) {
                stay |= 1 << lane;
            }
            uncertain &= uncertain - 1;
        }
        // Over entries that were read, since no more than those stay.
        let end = block.end;
        let moved_up = stay != present || end < first;
        for (to, from) in block.columns.iter_mut().zip([x, y, z]) {
            let mut lanes = Lanes::default();
            let from = if moved_up {
                simd.compress(from, stay)
            } else {
                from
            };
            simd.store(from, &mut lanes);
            to[end..end + N].copy_from_slice(&lanes.0.map(f32::to_bits)[..N]);
        }
        if moved_up {
            let rows = simd.compress_rows(rows, stay);
            block.rows[end..end + N].copy_from_slice(&rows[..N]);
        }
        block.seen += present.count_ones() as usize;
        block.end += stay.count_ones() as usize;
    }

    /// Whether the point of entry `k` stays in its cell; a mover or one that is gone does not.
    #[inline(always)]
    fn stays(&self, block: &Block, k: usize, moves: &mut Moves) -> bool {
        let Block { owner, used, .. } = *block;
        let from = if used.collision() {
            let old = [0, 1, 2].map(|axis| f32::from_bits(block.columns[axis][k]));
            self.grid.cell_of(Vec4::new(old[0], old[1], old[2], 0.0))
        } else {
            used.cell
        };
        let row = block.rows[k];
        let to = self
            .points
            .get(row as usize)
            .map(|&new| self.grid.cell_of(new));
        if to == Some(from) {
            return true;
        }
        if !used.is_simple() {
            moves.departures.push((owner, from));
        }
        if let Some(to) = to {
            let handle = owner;
            // Needed once all blocks of the chunk are done.
            if let Some(link) = self.links.towards(owner, to.wrapping_sub(used.cell)) {
                prefetch(link);
            }
            moves.movers.push(Mover { row, handle, to });
        }
        false
    }

    /// The used cell at the hash of `to`, which is near that of `from`. The links are in the order of the cells, and so
    /// near; the table is anywhere.
    #[inline(always)]
    fn holder(&self, from: u32, to: IVec3) -> u32 {
        let offset = to.wrapping_sub(self.cells[from as usize].cell);
        match self.links.towards(from, offset) {
            Some(&holder) if holder != ABSENT => holder,
            _ => self.table[self.hash.of(to) as usize],
        }
    }
}

/// The comparison of some blocks.
struct Blocks<'a> {
    comparison: &'a Comparison<'a>,
    /// The first of them.
    first: usize,
    owners: &'a [u32],
    words: &'a mut [u32],
    words_a_block: usize,
    moves: &'a mut Moves,
}

impl Vectorised for Blocks<'_> {
    type Output = ();

    #[inline(always)]
    fn run<S: Simd>(self, simd: S) {
        let Self {
            comparison,
            words,
            words_a_block,
            moves,
            ..
        } = self;
        for (k, &owner) in self.owners.iter().enumerate() {
            comparison.fetch_ahead(words, words_a_block, k);
            let block = &mut words[k * words_a_block..][..words_a_block];
            comparison.block(simd, owner, block, moves);
        }
        let Moves { movers, gained, .. } = moves;
        for mover in &mut *movers {
            mover.handle = comparison.holder(mover.handle, mover.to);
        }
        movers.retain(|mover| {
            let handle = mover.handle;
            let Some(used) = comparison.cells.get(handle as usize) else {
                return true;
            };
            let block = (used.first as usize).wrapping_sub(self.first);
            if used.cell != mover.to || !used.is_simple() || block >= self.owners.len() {
                return true;
            }
            let words = &mut words[block * words_a_block..][..words_a_block];
            let point = comparison.points[mover.row as usize];
            let is_in = insert_by_row(words, mover.row, point);
            if is_in {
                gained.push(handle);
            }
            !is_in
        });
    }
}

impl CompactHashing {
    /// Copies the positions of all points to their entries. Points that leave their cell are taken out; those that come
    /// to a simple one nearby are put in.
    pub(super) fn copy_and_compare(&mut self, points: &[Vec4], execution: &Execution) {
        let comparison = Comparison {
            grid: &self.grid,
            cells: &self.cells,
            links: &self.links,
            hash: self.hash,
            table: &self.table,
            points,
        };
        let words_a_block = 4 * self.pool.reserved();
        let owners = &self.pool.owners;
        let words = &mut self.pool.entries.words;
        let len = words.len() - PADDING;
        let chunks = owners.len().div_ceil(BLOCKS);
        self.moves.resize_with(chunks, Moves::default);
        let moves = &mut self.moves;
        let instruction_set = execution.instruction_set.arithmetic();
        execution.install(|| {
            moves
                .par_iter_mut()
                .zip(words[..len].par_chunks_mut(BLOCKS * words_a_block))
                .zip(owners.par_chunks(BLOCKS))
                .enumerate()
                .for_each(|(chunk, ((moves, words), owners))| {
                    moves.clear();
                    instruction_set.dispatch(Blocks {
                        comparison: &comparison,
                        first: chunk * BLOCKS,
                        owners,
                        words,
                        words_a_block,
                        moves,
                    });
                });
        });
    }

    /// How many points the comparison found to have changed their cell, or to be gone.
    pub(super) fn moved(&self) -> usize {
        self.moves.iter().map(Moves::len).sum()
    }
}

/// The columns of a block: x, y and z, as bits, and rows.
#[inline(always)]
fn columns(block: &mut [u32]) -> ([&mut [u32]; 3], &mut [u32]) {
    let pitch = block.len() / 4;
    let (positions, rows) = block.split_at_mut(3 * pitch);
    let (x, yz) = positions.split_at_mut(pitch);
    let (y, z) = yz.split_at_mut(pitch);
    ([x, y, z], rows)
}

/// Adds a point to a block of one spatial cell, so that rows ascend, unless the block is empty or full.
pub(super) fn insert_by_row(block: &mut [u32], row: u32, point: Vec4) -> bool {
    let ([x, y, z], rows) = columns(block);
    let last = rows.len() - 1;
    if rows[0] == NOBODY || rows[last] != NOBODY {
        return false;
    }
    // Rows ascend, and nobody is the largest.
    let place: usize = rows.iter().map(|&other| usize::from(other < row)).sum();
    for column in [&mut *x, &mut *y, &mut *z, &mut *rows] {
        column.copy_within(place..last, place + 1);
    }
    [x[place], y[place], z[place], _] = point.to_array().map(f32::to_bits);
    rows[place] = row;
    true
}
