//! Finds the points that changed their cell (paper 4.5.1) and moves most of them, in parallel.
//!
//! A loop over all entries computes the cell of each new position, compares it with the cell that holds the entry,
//! copies the position, and closes the gaps of points that leave. After each chunk, departed points are inserted if
//! their destination is a simple used cell of the same chunk, which is still in the cache. `moves.rs` handles the
//! rest.
//!
//! Rows and positions are prefetched, which saves a quarter of the time: after some steps, the points of a block are
//! at up to eight distant places in memory. The prefetch distance (1 to 24 blocks) has no effect. Two threads need 3.4
//! ns per point for 131 072 points of which 3.7 % change their cell.

use glam::Vec4;

use super::{
    super::{
        entries::{NONE, prefetch_block},
        grid::Grid,
        hash::CellHash,
    },
    arrivals::Arrivals,
    departed::{Departed, Moves},
    links::Links,
    pool::QUARTER,
    used_cell::UsedCell,
};
use crate::simd::{Cube, LANES, Simd, Vectorised, prefetch};

/// Blocks per task: along the Z-curve these are 8 × 8 × 16 cells, whose points fit the second-level cache. More than
/// four of five points that leave a cell enter another cell of the same task.
pub(super) const BLOCKS: usize = 1024;

/// Prefetch distance for blocks \[blocks].
const BLOCKS_AHEAD: usize = 8;
/// Prefetch distance for positions \[blocks].
const POINTS_AHEAD: usize = 3;

/// Input of the comparison.
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
    /// The region in which a point certainly stays in its cell.
    interior: Option<Cube>,
    /// x, y and z, as bit patterns.
    columns: [&'a mut [u32]; 3],
    rows: &'a mut [u32],
    /// Entries processed so far; `end` counts those that stay.
    seen: usize,
    end: usize,
}

impl Comparison<'_> {
    /// Prefetches the rows of a later block and the positions of a nearer one. Both can be anywhere in memory.
    #[inline(always)]
    fn fetch_ahead(&self, words: &[u32], words_per_block: usize, k: usize) {
        let block = |k: usize| words.get(k * words_per_block..(k + 1) * words_per_block);
        if let Some(block) = block(k + BLOCKS_AHEAD) {
            prefetch_block(block);
        }
        let (Some(block), Some(last)) = (block(k + POINTS_AHEAD), self.points.len().checked_sub(1))
        else {
            return;
        };
        // Three quarters of the entries: few blocks have more points.
        for &row in &block[3 * words_per_block / 4..][..3 * words_per_block / 16] {
            prefetch(&self.points[last.min(row as usize)]);
        }
    }

    /// Copies the positions of a block's entries and closes the gaps of entries that leave.
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
            if block.rows[first] == NONE {
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
            // Clears the entries behind the last one that stays.
            block.rows[end..].fill(NONE);
            if used.is_simple() {
                used.set_len(end as u32);
                if end == 0 {
                    moves.emptied.push(owner);
                }
            }
        }
    }

    /// Processes `N` entries from `first` on.
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
        let present = simd.below(rows, NONE);
        let mut stay = present & inside & known;
        let mut uncertain = present & !stay;
        while uncertain != 0 {
            let lane = uncertain.trailing_zeros();
            let stays = self.stays(block, first + lane as usize, moves);
            stay |= u32::from(stays) << lane;
            uncertain &= uncertain - 1;
        }
        // Overwrites only entries that were read already, because `end <= first`.
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

    /// Whether the point of entry `k` stays in its cell. Points that departed or were removed do not.
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
            // Used after all blocks of the chunk are processed.
            if let Some(link) = self.links.towards(owner, to.wrapping_sub(used.cell)) {
                prefetch(link);
            }
            moves.departed.push(Departed {
                row,
                handle: owner,
                block: NONE,
                to,
            });
        }
        false
    }

    /// The used cell at the hash of a departed point's new cell, and its block. Links come first: they are stored in
    /// the order of the cells, whereas a table look-up is a random access.
    #[inline(always)]
    fn destination(&self, departed: &Departed) -> (u32, u32) {
        let Departed { handle, to, .. } = *departed;
        let offset = to.wrapping_sub(self.cells[handle as usize].cell);
        let handle = match self.links.towards(handle, offset) {
            Some(&holder) if holder != NONE => holder,
            _ => self.table[self.hash.of(to) as usize],
        };
        let used = self.cells.get(handle as usize);
        let used = used.filter(|used| used.cell == to && used.blocks == 1);
        (handle, used.map_or(NONE, |used| used.first))
    }
}

/// Comparison of a sequence of blocks.
pub(super) struct Blocks<'a> {
    pub(super) comparison: &'a Comparison<'a>,
    /// Index of the first block.
    pub(super) first: usize,
    pub(super) owners: &'a [u32],
    pub(super) words: &'a mut [u32],
    pub(super) words_per_block: usize,
    pub(super) moves: &'a mut Moves,
}

impl Vectorised for Blocks<'_> {
    type Output = ();

    #[inline(always)]
    fn run<S: Simd>(self, simd: S) {
        let Self {
            comparison,
            words,
            words_per_block,
            moves,
            ..
        } = self;
        for (k, &owner) in self.owners.iter().enumerate() {
            comparison.fetch_ahead(words, words_per_block, k);
            let block = &mut words[k * words_per_block..][..words_per_block];
            comparison.block(simd, owner, block, moves);
        }
        for departed in &mut moves.departed {
            (departed.handle, departed.block) = comparison.destination(departed);
        }
        let arrivals = Arrivals {
            cells: comparison.cells,
            points: comparison.points,
            first: self.first,
            words,
            words_per_block,
            departed: &mut moves.departed,
        };
        arrivals.run(simd);
    }
}

/// Splits a block into its columns: x, y and z as bit patterns, and rows.
#[inline(always)]
fn columns(block: &mut [u32]) -> ([&mut [u32]; 3], &mut [u32]) {
    let pitch = block.len() / 4;
    let (positions, rows) = block.split_at_mut(3 * pitch);
    let (x, yz) = positions.split_at_mut(pitch);
    let (y, z) = yz.split_at_mut(pitch);
    ([x, y, z], rows)
}
