//! Links from a used cell to those around it, which a query may trust only after it has looked.
//!
//! Atomics, since queries that run side by side set what they found; all would find the same, so it does not matter
//! who is first, and a link that is out of date costs a look-up and no more.

use std::sync::atomic::{AtomicU32, Ordering::Relaxed};

use super::super::Grid;

/// Largest neighbourhood that is linked. The 125 cells within reach of cells of h/2 would take 500 bytes a cell,
/// in which there is one particle.
const LARGEST: usize = 27;

/// What a used cell knows of a cell around it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Link {
    /// Nothing.
    Unknown,
    /// It holds no points.
    Absent,
    /// Its used cell, when it was looked up.
    To(u32),
}

const UNKNOWN: u32 = u32::MAX;
const ABSENT: u32 = u32::MAX - 1;

/// A [`Link`] that readers may set.
#[derive(Debug)]
pub(super) struct SharedLink(AtomicU32);

impl SharedLink {
    #[inline(always)]
    pub(super) fn get(&self) -> Link {
        match self.0.load(Relaxed) {
            UNKNOWN => Link::Unknown,
            ABSENT => Link::Absent,
            handle => Link::To(handle),
        }
    }

    #[inline(always)]
    pub(super) fn set(&self, link: Link) {
        let raw = match link {
            Link::Unknown => UNKNOWN,
            Link::Absent => ABSENT,
            Link::To(handle) => handle,
        };
        self.0.store(raw, Relaxed);
    }
}

/// Links of all used cells, by their handles and in the order of the neighbourhood.
#[derive(Debug)]
pub(super) struct Links {
    /// Links of a cell; 0 if cells have none.
    each: usize,
    links: Vec<SharedLink>,
}

impl Links {
    /// None yet, for the cells of `grid`.
    pub(super) fn new(grid: &Grid) -> Self {
        let each = grid.neighbourhood.len();
        Self {
            each: if each > LARGEST { 0 } else { each },
            links: Vec::new(),
        }
    }

    pub(super) fn clear(&mut self) {
        self.links.clear();
    }

    /// Those of one more cell, unknown.
    pub(super) fn push(&mut self) {
        let len = self.links.len() + self.each;
        self.links
            .resize_with(len, || SharedLink(AtomicU32::new(UNKNOWN)));
    }

    /// Takes those of a cell out and puts the last cell's in their place.
    pub(super) fn swap_remove(&mut self, handle: usize) {
        let last = self.links.len() - self.each;
        for k in 0..self.each {
            let link = self.links[last + k].get();
            self.links[handle * self.each + k].set(link);
        }
        self.links.truncate(last);
    }

    /// Makes all links of a cell unknown.
    pub(super) fn forget(&mut self, handle: usize) {
        for k in 0..self.each {
            self.links[handle * self.each + k].set(Link::Unknown);
        }
    }

    /// Makes one link of a cell unknown, the `k`-th from the end.
    pub(super) fn forget_one(&mut self, handle: usize, k: usize) {
        if self.each > 0 {
            self.links[(handle + 1) * self.each - 1 - k].set(Link::Unknown);
        }
    }

    /// Those of a cell, unless the neighbourhood is too large for links.
    #[inline(always)]
    pub(super) fn of(&self, handle: usize) -> Option<&[SharedLink]> {
        (self.each > 0).then(|| &self.links[handle * self.each..(handle + 1) * self.each])
    }

    /// Memory held [bytes].
    pub(super) fn bytes(&self) -> usize {
        self.links.capacity() * size_of::<SharedLink>()
    }
}
