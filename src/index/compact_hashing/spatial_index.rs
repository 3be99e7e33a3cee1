//! The structure as a [`SpatialIndex`]: how it follows the points, and what a query asks of it.

use glam::{IVec3, Vec4};

use super::{
    super::{
        entries::{Entries, Run},
        grid::Grid,
        structure::SpatialIndex,
    },
    cells::{CompactHashing, EMPTY},
    links::ABSENT,
    movers::{Mover, Moves},
    used_cell::UsedCell,
};
use crate::state::{DomainTooLarge, Execution};

/// Bits of [`CompactHashing::reached`] a point: about 64 a used cell of edge h.
const BITS_A_POINT: usize = 8;

impl CompactHashing {
    /// Brings the points that changed their cell to the new one.
    fn follow(&mut self, points: &[Vec4], execution: &Execution) -> Result<(), DomainTooLarge> {
        let hash = self.hash.resized(points.len(), self.handles_a_point);
        if self.len == 0 || points.is_empty() || hash.size != self.hash.size {
            return self.rebuild(points, execution);
        }
        self.copy_and_compare(points, execution);
        if self.moved() > points.len() / 4 {
            return self.rebuild(points, execution);
        }
        self.account_for_departures();
        self.put_in(points, execution);
        for (row, &point) in points.iter().enumerate().skip(self.len) {
            let cell = self.grid.cell_of(point);
            let handle = self.table[self.hash.of(cell) as usize];
            if self.insert(handle, cell, row as u32, point) {
                self.reach_from(cell);
                self.changed.push(cell);
            }
        }
        self.relink(execution);
        self.drop_emptied();
        // What drops moved of cells that share a used cell.
        self.relink(execution);
        self.len = points.len();
        Ok(())
    }

    /// Takes the used cells without a point off the list, the last first, so that none of them takes another's place.
    fn drop_emptied(&mut self) {
        let mut emptied = std::mem::take(&mut self.emptied);
        emptied.sort_unstable_by(|a, b| b.cmp(a));
        emptied.dedup();
        for handle in emptied.drain(..) {
            let used = &self.cells[handle as usize];
            if used.len.get() > 0 {
                continue;
            }
            self.pool.release(used.first, used.blocks);
            self.table[used.hash as usize] = EMPTY;
            self.point_links_at(handle, ABSENT);
            self.cells.swap_remove(handle as usize);
            let last = self.cells.len() as u32;
            if let Some(moved) = self.cells.get(handle as usize) {
                self.table[moved.hash as usize] = handle;
                self.pool.give(moved.first, moved.blocks, handle);
                for k in moved.kin.get()..moved.len.get() {
                    let cell = self.pool.cell(&self.grid, moved.first, k);
                    self.changed.push(cell);
                }
                self.links.copy(last, handle);
                self.point_links_at(handle, handle);
            }
            self.links.resize(self.cells.len());
        }
        self.emptied = emptied;
    }
}

impl SpatialIndex for CompactHashing {
    fn update(&mut self, points: &[Vec4], execution: &Execution) -> Result<(), DomainTooLarge> {
        // The threads are entered once for all loops: the serial parts between them go along.
        execution.install(|| self.follow(points, execution))
    }

    fn rebuild(&mut self, points: &[Vec4], execution: &Execution) -> Result<(), DomainTooLarge> {
        self.hash = self.hash.resized(points.len(), self.handles_a_point);
        self.table.clear();
        self.table.resize(self.hash.size, EMPTY);
        let words = (points.len() * BITS_A_POINT)
            .div_ceil(64)
            .next_power_of_two();
        self.reached.clear();
        self.reached.resize(words, 0);
        self.cells.clear();
        self.pool.clear();
        for (row, &point) in points.iter().enumerate() {
            let cell = self.grid.cell_of(point);
            let handle = self.table[self.hash.of(cell) as usize];
            if self.insert(handle, cell, row as u32, point) {
                self.reach_from(cell);
            }
        }
        self.link_all(execution);
        self.len = points.len();
        Ok(())
    }

    fn grid(&self) -> &Grid {
        &self.grid
    }

    fn places(&self) -> usize {
        self.cells.len()
    }

    fn place_len(&self, place: usize) -> usize {
        self.cells[place].len.get() as usize
    }

    fn group(&self, place: usize, from: usize) -> Option<(IVec3, &[u32])> {
        let (used, from) = (&self.cells[place], from as u32);
        if from >= used.len.get() {
            return None;
        }
        let kin = used.kin.get();
        if from < kin {
            let run = self.pool.run(used.first, from, kin);
            return Some((used.cell, self.pool.entries.rows(run)));
        }
        let first = self.pool.cell(&self.grid, used.first, from);
        let end = self.end_of_alike((used.first, used.len.get()), from, first);
        let run = self.pool.run(used.first, from, end);
        Some((first, self.pool.entries.rows(run)))
    }

    fn entries(&self) -> &Entries {
        &self.pool.entries
    }

    fn runs(&self, center: IVec3, out: &mut Vec<Run>) {
        if self.cells.is_empty() {
            return;
        }
        let (word, bit) = self.reach_bit(center);
        if self.reached[word] & bit == 0 {
            return;
        }
        if let Some((handle, used)) = self.used(center)
            && used.cell == center
            && self.links.each() > 0
        {
            return self.runs_around(handle as usize, center, out);
        }
        for &offset in &self.grid.neighbourhood {
            let cell = center.wrapping_add(offset);
            if let Some((_, used)) = self.used(cell) {
                self.find_in(used, cell, out);
            }
        }
    }

    fn runs_around(&self, place: usize, center: IVec3, out: &mut Vec<Run>) {
        if self.cells[place].cell != center || self.links.each() == 0 {
            return self.runs(center, out);
        }
        let links = self.links.of(place);
        out.reserve(links.len());
        for (k, &link) in links.iter().enumerate() {
            let Some(used) = self.cells.get(link as usize) else {
                continue;
            };
            if used.is_simple() {
                // Nearly all: one run, of the cell that was asked for.
                out.push(self.pool.run(used.first, 0, used.len.get()));
            } else {
                self.find_in(used, center.wrapping_add(self.grid.neighbourhood[k]), out);
            }
        }
    }

    /// Of the used cells before it most were asked for before. The query of a million points gains a tenth to a fifth,
    /// one of 13 000, which the caches hold, loses up to a tenth.
    fn prefetch_around(&self, place: usize) {
        if place >= self.cells.len() || self.links.each() == 0 {
            return;
        }
        for &link in self.links.of(place) {
            if link as usize >= place
                && let Some(used) = self.cells.get(link as usize)
            {
                self.pool.prefetch(used.first);
            }
        }
    }

    fn bytes(&self) -> usize {
        let moves: usize = self.moves.iter().map(Moves::bytes).sum();
        let arrivals: usize = self.arrivals.iter().map(Vec::capacity).sum();
        let handles = [&self.table, &self.emptied, &self.reduced, &self.around];
        let handles: usize = handles.into_iter().map(Vec::capacity).sum();
        handles * size_of::<u32>()
            + self.changed.capacity() * size_of::<IVec3>()
            + self.cells.capacity() * size_of::<UsedCell>()
            + self.reached.capacity() * size_of::<u64>()
            + self.links.bytes()
            + self.pool.bytes()
            + moves
            + arrivals * size_of::<Mover>()
    }
}
