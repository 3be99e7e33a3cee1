//! Who changed its cell (paper 4.5.1), and the way of most of them, in parallel.
//!
//! One loop over all entries compares the cell of a point's new position with the one that it is in, copies the
//! position, and moves those up who follow one that leaves. Chunk by chunk those who left are then put in where they
//! come to a simple used cell of the same chunk, which is still in the cache: most of them. The others are in
//! `moves.rs`.
//!
//! Rows and positions are prefetched. After some time the points of a block lie in up to eight places in memory, which
//! no hardware prefetcher predicts: prefetching them saves a quarter of the time. How far ahead, from 1 to 24 blocks,
//! makes no difference.
//!
//! With two threads 131 072 points of which 3.7 % change their cell take 3.4 ns each, half of it for those. Tried and
//! dropped for them: leavers that are only noted in the loop, and looked at together after it (no difference).

use glam::Vec4;

use super::{
    super::{
        entries::{NOBODY, prefetch_block},
        grid::Grid,
        hash::CellHash,
    },
    arrivals::Arrivals,
    links::{ABSENT, Links},
    movers::{Mover, Moves},
    pool::QUARTER,
    used_cell::UsedCell,
};
use crate::simd::{Cube, LANES, Simd, Vectorised, prefetch};

/// Blocks that are one task: along the Z-curve 8 × 8 × 16 cells, whose points fit the second-level cache. More than
/// four of five who leave a cell there come to another of them.
pub(super) const BLOCKS: usize = 1024;

/// Blocks from the one at hand to those that are fetched ahead of it.
const BLOCKS_AHEAD: usize = 8;
/// The same of points.
const POINTS_AHEAD: usize = 3;

/// What the comparison reads.
pub(super) struct Comparison<'a> {
    pub(super) grid: &'a Grid,
    pub(super) cells: &'a [UsedCell],
    pub(super) links: &'a Links,
    pub(super) hash: CellHash,
    pub(super) table: &'a [u32],
    pub(super) points: &'a [Vec4],
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
    /// Asks for the rows of a block that comes soon, and for the positions of one that comes sooner: both are anywhere
    /// in memory but near those before.
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
                used.set_len(end as u32);
                if end == 0 {
                    moves.emptied.push(owner);
                }
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
            let lane = uncertain.trailing_zeros();
            let stays = self.stays(block, first + lane as usize, moves);
            stay |= u32::from(stays) << lane;
            uncertain &= uncertain - 1;
        }
        // Over entries that were read, since no more than those stay.
        let end = block.end;
        let moved_up = stay != present || end < first;
        for (to, from) in block.columns.iter_mut().zip([x, y, z]) {
            let from = if moved_up {
                simd.compress(from, stay)
            } else {
                from
            };
            to[end..end + N].copy_from_slice(&simd.bits(from)[..N]);
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
        if used.is_simple() {
            moves.left += 1;
        } else {
            moves.departures.push((owner, from));
        }
        if let Some(to) = to {
            // Needed once all blocks of the chunk are done.
            if let Some(link) = self.links.towards(owner, to.wrapping_sub(used.cell)) {
                prefetch(link);
            }
            moves.movers.push(Mover {
                row,
                handle: owner,
                block: NOBODY,
                to,
            });
        }
        false
    }

    /// The used cell at the hash of the cell that a mover comes to, which is near that it left, and its block. The
    /// links are in the order of the cells, and so near; the table is anywhere.
    #[inline(always)]
    fn destination(&self, mover: &Mover) -> (u32, u32) {
        let Mover { handle, to, .. } = *mover;
        let offset = to.wrapping_sub(self.cells[handle as usize].cell);
        let handle = match self.links.towards(handle, offset) {
            Some(&holder) if holder != ABSENT => holder,
            _ => self.table[self.hash.of(to) as usize],
        };
        let used = self.cells.get(handle as usize);
        let used = used.filter(|used| used.cell == to && used.blocks == 1);
        (handle, used.map_or(NOBODY, |used| used.first))
    }
}

/// The comparison of some blocks.
pub(super) struct Blocks<'a> {
    pub(super) comparison: &'a Comparison<'a>,
    /// The first of them.
    pub(super) first: usize,
    pub(super) owners: &'a [u32],
    pub(super) words: &'a mut [u32],
    pub(super) words_a_block: usize,
    pub(super) moves: &'a mut Moves,
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
        for mover in &mut moves.movers {
            (mover.handle, mover.block) = comparison.destination(mover);
        }
        let arrivals = Arrivals {
            cells: comparison.cells,
            points: comparison.points,
            first: self.first,
            words,
            words_a_block,
            movers: &mut moves.movers,
        };
        arrivals.run(simd);
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
