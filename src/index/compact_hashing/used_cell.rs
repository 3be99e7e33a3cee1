//! An element of the list of used cells.

use std::sync::atomic::{AtomicU32, Ordering};

use glam::IVec3;

/// A non-empty hash cell.
#[derive(Debug)]
pub(super) struct UsedCell {
    /// Primary spatial cell: the cell of all points, or of the first points.
    pub(super) cell: IVec3,
    /// Its position in the hash table.
    pub(super) hash: u32,
    /// Its first block in the pool.
    pub(super) first: u32,
    /// Blocks reserved, a power of two.
    pub(super) blocks: u32,
    /// Number of points.
    pub(super) len: Count,
    /// Number of points in spatial cell `cell`; they come first.
    pub(super) primary_len: Count,
}

/// A number of points. In parallel loops a thread only reads and writes the counts of simple used cells in its own
/// blocks, so the result does not depend on other threads.
#[derive(Debug)]
pub(super) struct Count(pub(super) AtomicU32);

impl Count {
    #[inline(always)]
    pub(super) fn get(&self) -> u32 {
        self.0.load(Ordering::Relaxed)
    }

    #[inline(always)]
    pub(super) fn set(&self, count: u32) {
        self.0.store(count, Ordering::Relaxed);
    }
}

impl UsedCell {
    /// The paper's collision flag: whether the used cell holds points of several spatial cells.
    pub(super) fn collision(&self) -> bool {
        self.primary_len.get() < self.len.get()
    }

    /// Whether the used cell holds points of one spatial cell in one block. Nearly all do.
    pub(super) fn is_simple(&self) -> bool {
        !self.collision() && self.blocks == 1
    }

    /// Sets the number of points of a simple used cell.
    #[inline(always)]
    pub(super) fn set_len(&self, len: u32) {
        self.len.set(len);
        self.primary_len.set(len);
    }
}
