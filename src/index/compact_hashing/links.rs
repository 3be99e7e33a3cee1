//! Links from every used cell to those around it, kept exact: a query that follows them computes no hash and compares
//! no coordinates.
//!
//! They are of the used cell's first spatial cell. A used cell that holds several is found by its table for the others.

use glam::IVec3;
use rayon::prelude::*;

use super::{super::Grid, CompactHashing, UsedCell};
use crate::state::Execution;

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

    fn get(&self, handle: u32, k: usize) -> u32 {
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

impl CompactHashing {
    /// Sets the links to the first spatial cell of a used cell, found by those from it.
    pub(super) fn point_links_at(&mut self, handle: u32, to: u32) {
        let cell = self.cells[handle as usize].cell;
        for k in 0..self.links.each() {
            let other = self.links.get(handle, k);
            let around = cell.wrapping_add(self.grid.neighbourhood[k]);
            if around == cell {
                self.links.set(handle, k, to);
            } else if let Some(used) = self.cells.get(other as usize)
                && used.cell == around
            {
                // The neighbourhood is symmetric: counted from the end its offsets point back.
                self.links.set(other, self.links.each() - 1 - k, to);
            }
        }
    }

    /// The used cell that holds points of a spatial cell.
    #[inline]
    fn holder(&self, cell: IVec3) -> u32 {
        let holds = |used: &UsedCell| {
            let mut others = used.kin.get()..used.len.get();
            used.cell == cell || others.any(|k| self.pool.cell(&self.grid, used.first, k) == cell)
        };
        let used = self.used(cell).filter(|(_, used)| holds(used));
        used.map_or(ABSENT, |(handle, _)| handle)
    }

    /// Sets the links from and to the spatial cells that changed.
    pub(super) fn relink(&mut self, execution: &Execution) {
        let each = self.links.each();
        if each == 0 || self.changed.is_empty() {
            return self.changed.clear();
        }
        self.links.resize(self.cells.len());
        // Found in parallel, where many loads wait for the table at a time.
        let mut around = std::mem::take(&mut self.around);
        around.resize(self.changed.len() * each, ABSENT);
        let this = &*self;
        execution.install(|| {
            let cells = around.par_chunks_mut(each).zip(&this.changed);
            cells.with_min_len(64).for_each(|(around, cell)| {
                for (other, &offset) in around.iter_mut().zip(&this.grid.neighbourhood) {
                    *other = this.holder(cell.wrapping_add(offset));
                }
            });
        });
        for (&cell, around) in self.changed.iter().zip(around.chunks_exact(each)) {
            // In the middle of its neighbourhood.
            let holder = around[each / 2];
            let first = self.cells.get(holder as usize).map(|used| used.cell);
            for (k, &other) in around.iter().enumerate() {
                if first == Some(cell) {
                    self.links.set(holder, k, other);
                }
                if let Some(used) = self.cells.get(other as usize)
                    && used.cell == cell.wrapping_add(self.grid.neighbourhood[k])
                {
                    self.links.set(other, each - 1 - k, holder);
                }
            }
        }
        self.changed.clear();
        self.around = around;
    }

    /// Whether every link leads to the used cell that holds its points.
    #[cfg(test)]
    pub(crate) fn links_are_exact(&self) -> bool {
        self.cells.iter().enumerate().all(|(handle, used)| {
            let around = self.grid.neighbourhood.iter();
            let holders = around.map(|&offset| self.holder(used.cell.wrapping_add(offset)));
            self.links.each() == 0 || holders.eq(self.links.of(handle).iter().copied())
        })
    }

    /// Sets all links.
    pub(super) fn link_all(&mut self, execution: &Execution) {
        let mut links = std::mem::replace(&mut self.links, Links::new(&self.grid));
        links.resize(self.cells.len());
        let this = &*self;
        execution.install(|| {
            let cells = links.par_iter_mut().zip(&this.cells);
            cells.for_each(|(links, used)| {
                for (link, &offset) in links.iter_mut().zip(&this.grid.neighbourhood) {
                    *link = this.holder(used.cell.wrapping_add(offset));
                }
            });
        });
        self.links = links;
    }
}
