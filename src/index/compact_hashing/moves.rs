//! Those who changed their cell, and are not in the new one yet (paper 4.5.1; see `comparison.rs`).
//!
//! Who left and came is counted serially and in a fixed order. Who comes to a simple used cell of another chunk is put in
//! in parallel. What is left, new cells, cells that collide or are full, a twentieth, is a matter of single points.
//!
//! Deviation: the paper moves serially whoever changed its cell. 131 072 points of which 3.7 % do so took 11 ns a point
//! for that, with one thread and with two; now it is 3 with two threads.

use glam::Vec4;
use rayon::prelude::*;

use super::{
    super::entries::PADDING,
    CompactHashing, EMPTY, UsedCell,
    comparison::{BLOCKS, Mover, insert_by_row},
};
use crate::execution::Execution;

/// A point that comes to a block of its chunk.
#[derive(Debug, Clone, Copy)]
pub(super) struct Arrival {
    block: u32,
    row: u32,
}

impl CompactHashing {
    /// Accounts for the points that left, and for those that are in a new cell already.
    pub(super) fn account(&mut self) {
        let moves = std::mem::take(&mut self.moves);
        for &(handle, lost) in moves.iter().flat_map(|moves| &moves.lost) {
            let used = &mut self.cells[handle as usize];
            used.len -= lost;
            used.kin -= lost;
            if used.len == 0 {
                self.changed.push(used.cell);
                self.emptied.push(handle);
            }
        }
        for &handle in moves.iter().flat_map(|moves| &moves.gained) {
            let used = &mut self.cells[handle as usize];
            used.len += 1;
            used.kin += 1;
        }
        for &(handle, from) in moves.iter().flat_map(|moves| &moves.departures) {
            let used = &mut self.cells[handle as usize];
            let of_the_first = from == used.cell;
            used.len -= 1;
            used.kin -= u32::from(of_the_first);
            let used = *used;
            // With the last point of all the links to the first cell go.
            let was_last = if of_the_first {
                used.kin == 0 && used.len > 0
            } else {
                !self.pool.holds(&self.grid, (used.first, used.blocks), from)
            };
            if was_last {
                self.changed.push(from);
            }
            if used.len == 0 {
                self.emptied.push(handle);
            } else if used.kin == 0 || used.blocks > 1 {
                self.reduced.push(handle);
            }
        }
        self.moves = moves;
        self.close_up();
    }

    /// Closes the gaps in used cells that are not simple and lost points.
    fn close_up(&mut self) {
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

    /// Brings those that have no place yet to their new cells.
    pub(super) fn put_in(&mut self, points: &[Vec4], execution: &Execution) {
        self.put_in_simple(points, execution);
        let moves = std::mem::take(&mut self.moves);
        for mover in moves.iter().flat_map(|moves| &moves.movers) {
            let Mover { row, handle, to } = *mover;
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
        self.moves = moves;
    }

    /// Those of them that come to simple used cells, in parallel.
    fn put_in_simple(&mut self, points: &[Vec4], execution: &Execution) {
        let pitch = self.pool.reserved();
        self.arrivals.resize_with(self.moves.len(), Vec::new);
        self.arrivals.iter_mut().for_each(Vec::clear);
        for moves in &mut self.moves {
            moves.movers.retain(|mover| {
                let used = self.cells.get_mut(mover.handle as usize);
                let has_room = |used: &&mut UsedCell| {
                    used.cell == mover.to
                        && used.is_simple()
                        && (1..pitch as u32).contains(&used.len)
                };
                let Some(used) = used.filter(has_room) else {
                    return true;
                };
                used.len += 1;
                used.kin += 1;
                self.arrivals[used.first as usize / BLOCKS].push(Arrival {
                    block: used.first % BLOCKS as u32,
                    row: mover.row,
                });
                false
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
                    for &Arrival { block, row } in arrivals {
                        let block = &mut words[block as usize * 4 * pitch..][..4 * pitch];
                        insert_by_row(block, row, points[row as usize]);
                    }
                });
        });
    }
}
