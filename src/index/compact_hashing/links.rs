//! Links from every used cell to those around it, kept exact: a query that follows them computes no hash and compares
//! no coordinates.
//!
//! They are of the used cell's first spatial cell. A used cell that holds several is found by its table for the others.

use glam::IVec3;
use rayon::prelude::*;

use super::super::grid::Grid;

/// Largest neighbourhood that is linked. The 125 cells within reach of cells of h/2 would take 500 bytes a cell,
/// in which there is one particle.
const LARGEST: usize = 27;

/// No used cell holds points of the cell.
pub(super) const ABSENT: u32 = u32::MAX;

/// Handles of the used cells around each, by its handle and in the order of the neighbourhood.
#[derive(Debug)]
pub(super) struct Links {
    /// Links of a cell.
    each: usize,
    /// How many cells away they lead along each axis.
    reach: IVec3,
    links: Vec<u32>,
}

impl Links {
    /// None yet, for the cells of `grid`.
    pub(super) fn new(grid: &Grid) -> Self {
        let each = grid.neighbourhood.len();
        Self {
            each: if each > LARGEST { 0 } else { each },
            reach: grid.reach,
            links: Vec::new(),
        }
    }

    /// Links of a cell; 0 if the neighbourhood is too large for links.
    pub(super) fn each(&self) -> usize {
        self.each
    }

    /// Keeps those of so many cells; new ones lead nowhere.
    pub(super) fn resize(&mut self, cells: usize) {
        let len = cells * self.each;
        if self.links.capacity() < len {
            // A sixteenth ahead, not twice as much.
            self.links.reserve_exact(len + len / 16 - self.links.len());
        }
        self.links.resize(len, ABSENT);
    }

    /// Those of every cell in turn, to be set in parallel.
    pub(super) fn par_iter_mut(&mut self) -> impl IndexedParallelIterator<Item = &mut [u32]> {
        self.links.par_chunks_mut(self.each.max(1))
    }

    /// Sets the link of a cell to the `k`-th of its neighbourhood.
    pub(super) fn set(&mut self, handle: u32, k: usize, to: u32) {
        self.links[handle as usize * self.each + k] = to;
    }

    pub(super) fn get(&self, handle: u32, k: usize) -> u32 {
        self.links[handle as usize * self.each + k]
    }

    /// The link of a cell to the one at `offset` from it, if there is one to there.
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

    /// Gives a cell the links of another.
    pub(super) fn copy(&mut self, from: u32, to: u32) {
        let from = from as usize * self.each;
        let to = to as usize * self.each;
        self.links.copy_within(from..from + self.each, to);
    }

    /// Those of a cell.
    #[inline(always)]
    pub(super) fn of(&self, handle: usize) -> &[u32] {
        &self.links[handle * self.each..(handle + 1) * self.each]
    }

    /// Memory held [bytes].
    pub(super) fn bytes(&self) -> usize {
        self.links.capacity() * size_of::<u32>()
    }
}
