//! Sets the links, and keeps them exact when cells appear or disappear.

use glam::IVec3;
use rayon::prelude::*;

use super::{super::entries::NONE, cells::CompactHashing, links::Links, used_cell::UsedCell};
use crate::state::Execution;

impl CompactHashing {
    /// Redirects all links that lead to the primary cell of a used cell. They are found through its own links.
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

    /// The neighbourhood is symmetric: offset k counted from the end points back.
    #[inline]
    fn holder(&self, cell: IVec3) -> u32 {
        let holds = |used: &UsedCell| {
            let mut others = used.primary_len.get()..used.len.get();
            used.cell == cell || others.any(|k| self.pool.cell(&self.grid, used.first, k) == cell)
        };
        let used = self.used(cell).filter(|(_, used)| holds(used));
        used.map_or(NONE, |(handle, _)| handle)
    }

    /// Sets the links from and to the spatial cells that changed.
    pub(super) fn relink(&mut self, execution: &Execution) {
        let each = self.links.each();
        if each == 0 || self.changed.is_empty() {
            return self.changed.clear();
        }
        self.links.resize(self.cells.len());
        // The look-ups run in parallel, so that their memory latencies overlap.
        let mut around = std::mem::take(&mut self.around);
        around.resize(self.changed.len() * each, NONE);
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
            // The cell itself is the middle of its neighbourhood.
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
