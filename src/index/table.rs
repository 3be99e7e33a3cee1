//! The table of a dense structure (paper 4.2, Figure 1): the first entry of every cell of the box.
//!
//! Deviation: an empty cell refers to where its entries would be. A cell then ends where the next begins, and in
//! row-major order adjacent cells along x form one run of entries: nine runs instead of 27. In return, every step
//! writes the whole table instead of the used cells.

use glam::{IVec3, Vec4};
use rayon::prelude::*;

use super::{
    domain::Domain,
    entries::{Entries, Run},
};
use crate::state::{CHUNK, Execution};

/// Entries per task.
const SERIAL: usize = 4096;

/// Entries per partition.
const BLOCK: usize = 64;

/// A (cell key, row) pair, the paper's handle, in one word. Sorted as numbers, the rows of a cell ascend.
pub(super) type Handle = u64;

#[inline(always)]
pub(super) fn handle(key: u32, row: u32) -> Handle {
    Handle::from(key) << 32 | Handle::from(row)
}

#[inline(always)]
pub(super) fn key_of(handle: Handle) -> u32 {
    (handle >> 32) as u32
}

/// Entries sorted by the key of their cell, and the first entry of each cell.
#[derive(Debug, Default)]
pub(super) struct SortedCells {
    /// Keys in the order of the entries.
    pub(super) keys: Vec<u32>,
    pub(super) entries: Entries,
    first: Vec<u32>,
}

impl SortedCells {
    /// Stores sorted handles as entries with positions, and the references to them.
    pub(super) fn take(
        &mut self,
        handle: impl Fn(usize) -> Handle + Sync,
        cells: usize,
        points: &[Vec4],
        execution: &Execution,
    ) {
        self.keys.resize(points.len(), 0);
        self.entries.resize(points.len());
        let Self {
            keys,
            entries,
            first,
        } = self;
        execution.install(|| {
            keys.par_chunks_mut(CHUNK)
                .zip(entries.all_rows_mut().par_chunks_mut(CHUNK))
                .enumerate()
                .for_each(|(chunk, (keys, rows))| {
                    for (k, (key, row)) in (chunk * CHUNK..).zip(keys.iter_mut().zip(rows)) {
                        let handle = handle(k);
                        (*key, *row) = (key_of(handle), handle as u32);
                    }
                });
        });
        entries.copy_positions(points, execution);
        first.resize(cells + 1, 0);
        execution.install(|| refer(keys, 0, first, 0));
    }

    /// The entries of the cells `first` to `last`.
    #[inline]
    pub(super) fn run(&self, first: u32, last: u32) -> Run {
        let start = self.first[first as usize];
        let len = self.first[last as usize + 1] - start;
        Run { start, len }
    }

    /// Number of partitions: blocks of entries.
    pub(super) fn partitions(&self) -> usize {
        self.keys.len().div_ceil(BLOCK)
    }

    /// The entries of a partition: those of the cells that begin in the block.
    pub(super) fn partition(&self, partition: usize) -> std::ops::Range<usize> {
        let border = |k: usize| {
            let Some(&key) = self.keys.get(k) else {
                return self.keys.len();
            };
            if k > 0 && self.keys[k - 1] == key {
                self.first[key as usize + 1] as usize
            } else {
                k
            }
        };
        border(partition * BLOCK)..border((partition + 1) * BLOCK)
    }

    /// See [`SpatialIndex::next_cell`](super::SpatialIndex::next_cell); returns the key instead of the cell.
    pub(super) fn next_cell(&self, partition: usize, from: usize) -> Option<(u32, &[u32])> {
        let range = self.partition(partition);
        let start = range.start + from;
        if start >= range.end {
            return None;
        }
        let key = self.keys[start];
        let end = self.first[key as usize + 1] as usize;
        Some((key, &self.entries.all_rows()[start..end]))
    }

    pub(super) fn bytes(&self) -> usize {
        (self.keys.capacity() + self.first.capacity()) * size_of::<u32>() + self.entries.bytes()
    }
}

/// Parallel reduction into the table (paper 4.2.1). Where the key of an entry differs from the previous one, its cell,
/// and the empty cells between, begin there. `first` is the part of the table from `first_cell` to the cell of the
/// last of `keys`, or to the table's end.
fn refer(keys: &[u32], first_entry: usize, first: &mut [u32], first_cell: usize) {
    if keys.len() <= SERIAL {
        let mut written = 0;
        for (k, &key) in keys.iter().enumerate() {
            let end = key as usize + 1 - first_cell;
            if end > written {
                first[written..end].fill((first_entry + k) as u32);
                written = end;
            }
        }
        first[written..].fill((first_entry + keys.len()) as u32);
        return;
    }
    let (left, right) = keys.split_at(keys.len() / 2);
    let split = left.last().map_or(0, |&key| key as usize + 1) - first_cell;
    let (first_left, first_right) = first.split_at_mut(split);
    rayon::join(
        || refer(left, first_entry, first_left, first_cell),
        || {
            refer(
                right,
                first_entry + left.len(),
                first_right,
                first_cell + split,
            )
        },
    );
}

/// The runs of entries around a cell in a row-major table.
pub(super) fn row_major_runs(
    domain: &Domain,
    reach: IVec3,
    center: IVec3,
    run: impl Fn(u32, u32) -> Run,
    out: &mut Vec<Run>,
) {
    let x = domain.span(center, reach, 0);
    if x.is_empty() {
        return;
    }
    for z in domain.span(center, reach, 2) {
        for y in domain.span(center, reach, 1) {
            let first = domain.row_major([x.start, y, z]);
            let run = run(first, first + (x.end - 1 - x.start));
            if run.len > 0 {
                out.push(run);
            }
        }
    }
}
