//! Who changed its cell, and the way there (paper 4.5.1).
//!
//! Three loops. The first goes over all entries in parallel: it compares the cell of a point's new position with the one
//! that it is in, copies the position, and moves those up who follow one that leaves. The second counts who leaves and
//! comes, serially and in a fixed order. The third puts in, in parallel by blocks of the pool, who comes to a used cell of
//! one spatial cell with room left: six of seven. What is left, new cells, cells that collide or are full, is a matter
//! of single points.
//!
//! Deviation: the paper moves serially whoever changed its cell. 131 072 points of which 3.7 % do so took 11 ns a point
//! for that, with one thread and with two; now it is 8 and 6, and at 1 048 576 points 12 and 9 for 15. The first loop
//! takes 8 with two threads.

use glam::{IVec3, Vec4};
use rayon::prelude::*;

use super::{
    super::{
        Grid,
        entries::{NOBODY, PADDING},
        hash::CellHash,
    },
    CompactHashing, EMPTY, UsedCell,
    pool::QUARTER,
};
use crate::{
    execution::Execution,
    simd::{Cube, LANES, Lanes, Simd, Vectorised},
};

/// Blocks that are one task.
const BLOCKS: usize = 128;

/// A point that changed its cell, or is gone.
#[derive(Debug, Clone, Copy)]
pub(super) struct Mover {
    row: u32,
    /// The used cell that it left.
    left: u32,
    /// The one at the hash of the cell that it comes to. It is looked up in parallel, where many loads wait for the table
    /// at a time.
    comes_to: u32,
    /// The cells that it left and comes to.
    from: IVec3,
    to: IVec3,
}

/// A point that comes to a block.
#[derive(Debug, Clone, Copy)]
pub(super) struct Arrival {
    block: u32,
    row: u32,
}

/// What the comparison reads.
struct Comparison<'a> {
    grid: &'a Grid,
    cells: &'a [UsedCell],
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
    /// Entries that stay so far.
    end: usize,
}

impl Comparison<'_> {
    /// Copies the positions of a block's entries, and moves those up that follow one that leaves.
    #[inline(always)]
    fn block<S: Simd>(&self, simd: S, owner: u32, words: &mut [u32], movers: &mut Vec<Mover>) {
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
            end: 0,
        };
        for first in (0..pitch).step_by(LANES) {
            if block.rows[first] == NOBODY {
                break;
            }
            if pitch - first < LANES {
                self.entries::<S, QUARTER>(simd, first, &mut block, movers);
            } else {
                self.entries::<S, LANES>(simd, first, &mut block, movers);
            }
        }
        // What was copied past the last, and what those left behind who moved up.
        block.rows[block.end..].fill(NOBODY);
    }

    /// The same for `N` entries from `first`.
    #[inline(always)]
    fn entries<S: Simd, const N: usize>(
        &self,
        simd: S,
        first: usize,
        block: &mut Block,
        movers: &mut Vec<Mover>,
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
            let k = first + lane;
            let old = [0, 1, 2].map(|axis| f32::from_bits(block.columns[axis][k]));
            match self.mover(block.used, block.owner, block.rows[k], old) {
                Some(mover) => movers.push(mover),
                None => stay |= 1 << lane,
            }
            uncertain &= uncertain - 1;
        }
        // Over entries that were read, since no more than those stay.
        let end = block.end;
        for (to, from) in block.columns.iter_mut().zip([x, y, z]) {
            let mut lanes = Lanes::default();
            simd.store(simd.compress(from, stay), &mut lanes);
            to[end..end + N].copy_from_slice(&lanes.0.map(f32::to_bits)[..N]);
        }
        let rows = simd.compress_rows(rows, stay);
        block.rows[end..end + N].copy_from_slice(&rows[..N]);
        block.end += stay.count_ones() as usize;
    }

    /// The mover that a point is, if it is one.
    #[inline(always)]
    fn mover(&self, used: &UsedCell, owner: u32, row: u32, old: [f32; 3]) -> Option<Mover> {
        let from = if used.collision() {
            self.grid.cell_of(Vec4::new(old[0], old[1], old[2], 0.0))
        } else {
            used.cell
        };
        let new = self.points.get(row as usize);
        let to = new.map_or(from, |&new| self.grid.cell_of(new));
        (new.is_none() || to != from).then(|| Mover {
            row,
            left: owner,
            comes_to: self.table[self.hash.of(to) as usize],
            from,
            to,
        })
    }
}

/// The comparison of some blocks.
struct Blocks<'a> {
    comparison: &'a Comparison<'a>,
    owners: &'a [u32],
    words: &'a mut [u32],
    words_a_block: usize,
    movers: &'a mut Vec<Mover>,
}

impl Vectorised for Blocks<'_> {
    type Output = ();

    #[inline(always)]
    fn run<S: Simd>(self, simd: S) {
        let blocks = self.words.chunks_exact_mut(self.words_a_block);
        for (&owner, block) in self.owners.iter().zip(blocks) {
            self.comparison.block(simd, owner, block, self.movers);
        }
    }
}

impl CompactHashing {
    /// Copies the positions of all points to their entries and takes those out that leave their cell: they are in
    /// [`movers`](Self::movers) then, in the order of the entries.
    pub(super) fn copy_and_compare(&mut self, points: &[Vec4], execution: &Execution) {
        let comparison = Comparison {
            grid: &self.grid,
            cells: &self.cells,
            hash: self.hash,
            table: &self.table,
            points,
        };
        let words_a_block = 4 * self.pool.reserved();
        let owners = &self.pool.owners;
        let words = &mut self.pool.entries.words;
        let len = words.len() - PADDING;
        let chunks = owners.len().div_ceil(BLOCKS);
        self.movers.resize_with(chunks, Vec::new);
        let movers = &mut self.movers;
        let instruction_set = execution.instruction_set;
        execution.install(|| {
            movers
                .par_iter_mut()
                .zip(words[..len].par_chunks_mut(BLOCKS * words_a_block))
                .zip(owners.par_chunks(BLOCKS))
                .for_each(|((movers, words), owners)| {
                    movers.clear();
                    instruction_set.dispatch(Blocks {
                        comparison: &comparison,
                        owners,
                        words,
                        words_a_block,
                        movers,
                    });
                });
        });
    }

    /// Accounts for the points that left.
    pub(super) fn take_out(&mut self) {
        for mover in self.movers.iter().flatten() {
            let used = &mut self.cells[mover.left as usize];
            let of_the_first = mover.from == used.cell;
            used.len -= 1;
            used.kin -= u32::from(of_the_first);
            // With the last point of all the links to the first cell go.
            if !of_the_first || (used.kin == 0 && used.len > 0) {
                self.changed.push(mover.from);
            }
            if used.len == 0 {
                self.emptied.push(mover.left);
            } else if used.kin == 0 || used.blocks > 1 {
                self.reduced.push(mover.left);
            }
        }
        let mut reduced = std::mem::take(&mut self.reduced);
        reduced.sort_unstable();
        reduced.dedup();
        for handle in reduced.drain(..) {
            let UsedCell {
                first,
                blocks,
                len,
                kin,
                ..
            } = self.cells[handle as usize];
            self.pool.close_gaps(first, blocks);
            if len == 0 {
                continue;
            }
            if kin == 0 {
                // Another spatial cell comes first now.
                let cell = |k: u32| self.pool.cell(&self.grid, first, k);
                let of_first = (0..len).take_while(|&k| cell(k) == cell(0)).count() as u32;
                let used = &mut self.cells[handle as usize];
                (used.cell, used.kin) = (cell(0), of_first);
                self.changed.push(used.cell);
            }
            if blocks > 1 && 3 * len <= blocks * self.pool.reserved() as u32 {
                self.move_to_blocks(blocks / 2, handle, len);
            }
        }
        self.reduced = reduced;
    }

    /// Brings the movers to their new cells.
    pub(super) fn put_in(&mut self, points: &[Vec4], execution: &Execution) {
        let pitch = self.pool.reserved();
        let chunks = self.pool.owners.len().div_ceil(BLOCKS);
        self.arrivals.resize_with(chunks, Vec::new);
        self.arrivals.iter_mut().for_each(Vec::clear);
        let mut movers = std::mem::take(&mut self.movers);
        for movers in &mut movers {
            movers.retain(|mover| {
                let Some(used) = self.cells.get_mut(mover.comes_to as usize) else {
                    return true;
                };
                let is_simple = used.cell == mover.to
                    && !used.collision()
                    && used.blocks == 1
                    && (1..pitch as u32).contains(&used.len)
                    && (mover.row as usize) < points.len();
                if is_simple {
                    used.len += 1;
                    used.kin += 1;
                    self.arrivals[used.first as usize / BLOCKS].push(Arrival {
                        block: used.first % BLOCKS as u32,
                        row: mover.row,
                    });
                }
                !is_simple
            });
        }
        let words = &mut self.pool.entries.words;
        let len = words.len() - PADDING;
        let arrivals = &self.arrivals;
        execution.install(|| {
            words[..len]
                .par_chunks_mut(BLOCKS * 4 * pitch)
                .zip(arrivals)
                .for_each(|(words, arrivals)| {
                    for arrival in arrivals {
                        let first = arrival.block as usize * 4 * pitch;
                        let block = &mut words[first..first + 4 * pitch];
                        insert_by_row(block, arrival.row, points[arrival.row as usize]);
                    }
                });
        });
        for mover in movers.iter().flatten() {
            let Mover { row, to, .. } = *mover;
            if let Some(&point) = points.get(row as usize) {
                let handle = match mover.comes_to {
                    // Another may have come before.
                    EMPTY => self.table[self.hash.of(to) as usize],
                    handle => handle,
                };
                if self.insert(handle, to, row, point) {
                    self.reach_from(to);
                    self.changed.push(to);
                }
            }
        }
        self.movers = movers;
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

/// Adds a point to a block of one spatial cell, which has room for it, so that rows ascend.
fn insert_by_row(block: &mut [u32], row: u32, point: Vec4) {
    let ([x, y, z], rows) = columns(block);
    let end = rows.iter().position(|&row| row == NOBODY);
    let mut place = end.unwrap_or(rows.len() - 1);
    while place > 0 && rows[place - 1] > row {
        for column in [&mut *x, &mut *y, &mut *z, &mut *rows] {
            column[place] = column[place - 1];
        }
        place -= 1;
    }
    [x[place], y[place], z[place], _] = point.to_array().map(f32::to_bits);
    rows[place] = row;
}
