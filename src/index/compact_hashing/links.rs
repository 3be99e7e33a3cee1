//! Links from every used cell to the used cells around it. A query that follows them computes no hash and compares no
//! coordinates.
//!
//! Links belong to the primary spatial cell of a used cell. The other spatial cells of the same used cell use the hash
//! table.

use glam::IVec3;
use rayon::prelude::*;

use super::super::{entries::NONE, grid::Grid};

/// Largest neighbourhood with links. The 125 neighbours of cells of edge h/2 would need 500 bytes per cell, which
/// holds one particle.
const LARGEST: usize = 27;

/// Links per cell.
#[derive(Debug)]
pub(super) struct Links {
    /// Links per cell.
    each: usize,
    /// Number of cells that links reach along each axis.
    reach: IVec3,
    links: Vec<u32>,
}

impl Links {
    /// No links yet, for the cells of `grid`.
    pub(super) fn new(grid: &Grid) -> Self {
        let each = grid.neighbourhood.len();
        Self {
            each: if each > LARGEST { 0 } else { each },
            reach: grid.reach,
            links: Vec::new(),
        }
    }

    /// Links per cell; 0 if the neighbourhood is too large for links.
    pub(super) fn each(&self) -> usize {
        self.each
    }

    /// Adapts to a number of cells; new links are `NONE`.
    pub(super) fn resize(&mut self, cells: usize) {
        let len = cells * self.each;
        if self.links.capacity() < len {
            // Reserves a sixteenth more, instead of doubling.
            self.links.reserve_exact(len + len / 16 - self.links.len());
        }
        self.links.resize(len, NONE);
    }

    /// The links of every cell in turn, for writing in parallel.
    pub(super) fn par_iter_mut(&mut self) -> impl IndexedParallelIterator<Item = &mut [u32]> {
        self.links.par_chunks_mut(self.each.max(1))
    }

    /// Sets the link of a cell to the `k`-th cell of its neighbourhood.
    pub(super) fn set(&mut self, handle: u32, k: usize, to: u32) {
        self.links[handle as usize * self.each + k] = to;
    }

    pub(super) fn get(&self, handle: u32, k: usize) -> u32 {
        self.links[handle as usize * self.each + k]
    }

    /// The link of a cell to the cell at `offset`, if `offset` is within reach.
    #[inline(always)]
    pub(super) fn towards(&self, handle: u32, offset: IVec3) -> Option<&u32> {
        let reach = self.reach;
        if self.each == 0 || offset.cmpgt(reach).any() || offset.cmplt(-reach).any() {
            return None;
        }
        let (from_first, side) = (offset + reach, 2 * reach + 1);
        let k = from_first.x + side.x * (from_first.y + side.y * from_first.z);
        self.links.get(handle as usize * self.each + k as usize)
    }

    /// Copies the links of one cell to another.
    pub(super) fn copy(&mut self, from: u32, to: u32) {
        let from = from as usize * self.each;
        let to = to as usize * self.each;
        self.links.copy_within(from..from + self.each, to);
    }

    /// Links of a cell.
    #[inline(always)]
    pub(super) fn of(&self, handle: usize) -> &[u32] {
        &self.links[handle * self.each..(handle + 1) * self.each]
    }

    /// Memory held \[bytes].
    pub(super) fn bytes(&self) -> usize {
        self.links.capacity() * size_of::<u32>()
    }
}
