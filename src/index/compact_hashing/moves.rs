//! Points that changed their cell (paper 4.5.1): found by the comparison (see `comparison.rs`), then brought to the new
//! one if they are not in it yet.
//!
//! Who comes to a simple used cell of another chunk is put in in parallel, by the thread whose chunk it is; it counts,
//! too. What is left, new cells, cells that collide or are full, a twentieth, is a matter of single points, in a fixed
//! order.
//!
//! Deviation: the paper moves serially whoever changed its cell. 131 072 points of which 3.7 % do so took 11 ns a point
//! for that, with one thread and with two; now it is 0.8 of the 4.4 that the whole update takes with two threads.

use std::mem::take;

use glam::Vec4;
use rayon::prelude::*;

use super::{
    super::entries::PADDING,
    arrivals::Arrivals,
    cells::{CompactHashing, EMPTY},
    comparison::{BLOCKS, Blocks, Comparison},
    movers::{Mover, Moves},
};
use crate::{simd::prefetch, state::Execution};

/// Points from the one at hand to that which is fetched ahead of it: single points are anywhere in memory.
const AHEAD: usize = 6;

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

    /// Accounts for the points that left used cells that are not simple.
    pub(super) fn account_for_departures(&mut self) {
        let moves = take(&mut self.moves);
        let emptied = moves.iter().flat_map(|moves| &moves.emptied);
        self.emptied.extend(emptied);
        let departures = moves.iter().flat_map(|moves| &moves.departures);
        let mut ahead = departures.clone().skip(AHEAD);
        for &(handle, from) in departures {
            if let Some(&(next, _)) = ahead.next() {
                self.prefetch_entries(next);
            }
            let used = &self.cells[handle as usize];
            let of_the_first = from == used.cell;
            let (len, kin) = (used.len.get() - 1, used.kin.get() - u32::from(of_the_first));
            used.len.set(len);
            used.kin.set(kin);
            // With the last point of all the links to the first cell go.
            let was_last = if of_the_first {
                kin == 0 && len > 0
            } else {
                !self.pool.holds(&self.grid, (used.first, used.blocks), from)
            };
            if was_last {
                self.changed.push(from);
            }
            if len == 0 {
                self.emptied.push(handle);
            } else if kin == 0 || used.blocks > 1 {
                self.reduced.push(handle);
            }
        }
        self.moves = moves;
        self.close_up();
    }

    /// Hints that the first entries of a used cell are about to be read.
    fn prefetch_entries(&self, handle: u32) {
        if let Some(used) = self.cells.get(handle as usize) {
            self.pool.prefetch(used.first);
        }
    }

    /// Closes the gaps in used cells that are not simple and lost points.
    fn close_up(&mut self) {
        let mut reduced = take(&mut self.reduced);
        reduced.sort_unstable();
        reduced.dedup();
        for handle in reduced.drain(..) {
            let used = &self.cells[handle as usize];
            let (first, blocks) = (used.first, used.blocks);
            let (len, kin) = (used.len.get(), used.kin.get());
            self.pool.close_gaps(first, blocks);
            if len == 0 {
                continue;
            }
            if kin == 0 {
                // Another spatial cell comes first now.
                let cell = |k: u32| self.pool.cell(&self.grid, first, k);
                let of_first = (0..len).take_while(|&k| cell(k) == cell(0)).count() as u32;
                let used = &mut self.cells[handle as usize];
                used.cell = cell(0);
                used.kin.set(of_first);
                self.changed.push(used.cell);
            }
            if blocks > 1 && 3 * len <= blocks * self.pool.reserved() as u32 {
                self.move_to_blocks(blocks / 2, handle, len);
            }
        }
        self.reduced = reduced;
    }

    /// Brings those that have no place yet to their new cells.
    pub(super) fn put_in(&mut self, points: &[Vec4], execution: &Execution) {
        self.put_in_simple(points, execution);
        let (moves, arrivals) = (take(&mut self.moves), take(&mut self.arrivals));
        let others = moves.iter().map(|moves| &moves.movers);
        let others = others.chain(&arrivals).flatten();
        let mut ahead = others.clone().skip(AHEAD);
        for mover in others {
            if let Some(next) = ahead.next() {
                prefetch(&points[next.row as usize]);
                self.prefetch_entries(next.handle);
            }
            let Mover {
                row, handle, to, ..
            } = *mover;
            let handle = match handle {
                // Another may have come before.
                EMPTY => self.table[self.hash.of(to) as usize],
                handle => handle,
            };
            if self.insert(handle, to, row, points[row as usize]) {
                self.reach_from(to);
                self.changed.push(to);
            }
        }
        (self.moves, self.arrivals) = (moves, arrivals);
    }

    /// Those of them that come to simple used cells, in parallel. Who finds no room stays among the arrivals.
    fn put_in_simple(&mut self, points: &[Vec4], execution: &Execution) {
        self.arrivals.resize_with(self.moves.len(), Vec::new);
        self.arrivals.iter_mut().for_each(Vec::clear);
        for moves in &mut self.moves {
            moves.movers.retain(|&mover| {
                let arrivals = self.arrivals.get_mut(mover.block as usize / BLOCKS);
                arrivals.map(|arrivals| arrivals.push(mover)).is_none()
            });
        }
        let cells = &self.cells;
        let words_a_block = 4 * self.pool.reserved();
        let words = &mut self.pool.entries.words;
        let len = words.len() - PADDING;
        let arrivals = &mut self.arrivals;
        let instruction_set = execution.instruction_set.arithmetic();
        execution.install(|| {
            words[..len]
                .par_chunks_mut(BLOCKS * words_a_block)
                .zip(arrivals)
                .enumerate()
                .for_each(|(chunk, (words, movers))| {
                    let arrivals = Arrivals {
                        cells,
                        points,
                        first: chunk * BLOCKS,
                        words,
                        words_a_block,
                        movers,
                    };
                    instruction_set.dispatch(arrivals);
                });
        });
    }
}
