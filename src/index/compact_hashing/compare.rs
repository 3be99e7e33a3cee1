//! Who changed its cell (paper 4.5.1, first loop): positions of the last step against those of this one.

use glam::{IVec3, Vec4};
use rayon::prelude::*;

use super::{
    super::{
        Grid,
        entries::{NOBODY, PADDING},
        hash::CellHash,
    },
    pool::Pool,
};
use crate::execution::Execution;

/// Blocks that one task compares.
const BLOCKS: usize = 128;

/// A point that changed its cell, or is gone.
#[derive(Debug, Clone, Copy)]
pub(super) struct Mover {
    /// Its entry, counted through all blocks.
    pub(super) entry: u32,
    pub(super) row: u32,
    /// Handles at the hashes of the cells that it left and comes to. They are looked up here, where several threads and
    /// many loads wait for the table at a time, and not one by one while points are moved.
    pub(super) handles: [u32; 2],
    /// The cells that it left and comes to.
    pub(super) from: IVec3,
    pub(super) to: IVec3,
}

/// Copies the positions of all points to their entries and fills `movers`, chunk by chunk in the order of the entries.
pub(super) fn copy_and_compare(
    pool: &mut Pool,
    (hash, table): (CellHash, &[u32]),
    grid: &Grid,
    points: &[Vec4],
    movers: &mut Vec<Vec<Mover>>,
    execution: &Execution,
) {
    let pitch = pool.reserved();
    let words = &mut pool.entries.words;
    let len = words.len() - PADDING;
    let chunk = BLOCKS * 4 * pitch;
    let mover = |entry: usize, row: u32, old: Vec4| {
        let from = grid.cell_of(old);
        let new = points.get(row as usize);
        let to = new.map_or(from, |&new| grid.cell_of(new));
        (new.is_none() || to != from).then(|| Mover {
            entry: entry as u32,
            row,
            handles: [from, to].map(|cell| table[hash.of(cell) as usize]),
            from,
            to,
        })
    };
    movers.resize_with(len.div_ceil(chunk), Vec::new);
    execution.install(|| {
        movers
            .par_iter_mut()
            .zip(words[..len].par_chunks_mut(chunk))
            .enumerate()
            .for_each(|(chunk, (movers, words))| {
                movers.clear();
                for (k, block) in words.chunks_exact_mut(4 * pitch).enumerate() {
                    let first = (chunk * BLOCKS + k) * pitch;
                    let (positions, rows) = block.split_at_mut(3 * pitch);
                    let (x, yz) = positions.split_at_mut(pitch);
                    let (y, z) = yz.split_at_mut(pitch);
                    let entries = x.iter_mut().zip(y).zip(z).zip(rows);
                    for (k, (((x, y), z), &mut row)) in entries.enumerate() {
                        if row == NOBODY {
                            break;
                        }
                        let [old_x, old_y, old_z] = [*x, *y, *z].map(f32::from_bits);
                        let old = Vec4::new(old_x, old_y, old_z, 0.0);
                        let new = points.get(row as usize);
                        if !new.is_some_and(|&new| grid.surely_alike(old, new)) {
                            movers.extend(mover(first + k, row, old));
                        }
                        if let Some(new) = new {
                            [*x, *y, *z, _] = new.to_array().map(f32::to_bits);
                        }
                    }
                }
            });
    });
}
