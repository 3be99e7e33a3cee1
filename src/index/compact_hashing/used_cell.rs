//! What the list of used cells holds of each.

use std::sync::atomic::{AtomicU32, Ordering};

use glam::IVec3;

/// A non-empty hash cell.
#[derive(Debug)]
pub(super) struct UsedCell {
    /// Spatial cell of all its points, or of the first.
    pub(super) cell: IVec3,
    /// Its place in the table.
    pub(super) hash: u32,
    /// Its first block in the pool.
    pub(super) first: u32,
    /// Blocks reserved, a power of two.
    pub(super) blocks: u32,
    /// Number of points.
    pub(super) len: Count,
    /// How many of them, the first, are in spatial cell `cell`.
    pub(super) kin: Count,
}

/// A number of points. In parallel loops a thread counts in the simple used cells of the blocks that are its own, and
/// looks at no others: what it reads does not depend on the other threads.
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
    /// The paper's collision flag: whether it holds points of several spatial cells.
    pub(super) fn collision(&self) -> bool {
        self.kin.get() < self.len.get()
    }

    /// Whether it holds points of one spatial cell in one block, as nearly all do.
    pub(super) fn is_simple(&self) -> bool {
        !self.collision() && self.blocks == 1
    }

    /// Counts the points of a simple used cell.
    #[inline(always)]
    pub(super) fn set_len(&self, len: u32) {
        self.len.set(len);
        self.kin.set(len);
    }
}
