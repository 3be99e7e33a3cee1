//! Z-index sort (paper 4.3): as index sort, but keys follow the Z-curve and handles stay sorted between steps.
//!
//! Requires a bounding box whose edges are padded to powers of two: up to 32 bytes for every cell in the unpadded box,
//! at most [`MAX_CELLS`](crate::state::MAX_CELLS) with padding. Keys interleave the bits of the coordinates (4.3.1), as
//! many bits as each axis needs, so that a long flat box is not padded to a cube.
//!
//! Handles are nearly sorted in the order of the last step (4.3.2: about 2 % of the points change their cell).
//! Deviation: instead of an insertion sort, changed handles are removed, sorted and merged in one sweep (4 ns per
//! point instead of 78 where 2 % change; `docs/decisions/z_index_sort.md`). If half of the points or more changed, all
//! handles are sorted.

use super::structure::Structure;
use glam::{IVec3, Vec4};
use rayon::prelude::*;

use super::{
    Grid, SpatialIndex,
    domain::Domain,
    entries::{Entries, Run},
    table::{Handle, SortedCells, handle},
};
use crate::state::DomainTooLarge;
use crate::state::{CHUNK, Execution};

/// Fraction of changed handles from which all are sorted: there both variants cost the same.
const DISORDER: f32 = 0.5;

/// The structure of section 4.3.
pub struct ZIndexSort {
    grid: Grid,
    domain: Domain,
    /// For every axis and coordinate its bits, spread to their positions in a key.
    dilated: [Vec<u32>; 3],
    /// The bits of a key that belong to each axis.
    masks: [u32; 3],
    handles: Vec<Handle>,
    /// Handles whose key changed, per chunk; `moved` has all of them, sorted.
    changed: Vec<Vec<Handle>>,
    moved: Vec<Handle>,
    cells: SortedCells,
}

/// Cells of a table whose edges are powers of two.
pub(super) fn padded(size: [u64; 3]) -> u64 {
    super::domain::unpadded(size.map(|cells| cells.max(1).next_power_of_two()))
}

/// The structure's row.
pub(in crate::index) const ROW: Structure = Structure {
    build: |grid, _| Box::new(ZIndexSort::new(grid)),
    table: Some(padded),
    bytes_per_particle: 33.0,
};

impl ZIndexSort {
    /// An empty index.
    pub fn new(grid: Grid) -> Self {
        Self {
            grid,
            domain: Domain::default(),
            dilated: Default::default(),
            masks: [0; 3],
            handles: Vec::new(),
            changed: Vec::new(),
            moved: Vec::new(),
            cells: SortedCells::default(),
        }
    }

    /// Spreads the coordinates of every axis: bit by bit, alternating between the axes until the bits of each are used
    /// up.
    fn dilate(&mut self) {
        let bits = self
            .domain
            .size
            .map(|cells| u32::BITS - (cells - 1).leading_zeros());
        let mut places: [Vec<u32>; 3] = Default::default();
        let mut next = 0;
        for bit in 0..bits.into_iter().max().unwrap_or(0) {
            for axis in 0..3 {
                if bit < bits[axis] {
                    places[axis].push(next);
                    next += 1;
                }
            }
        }
        let spread = |x: u32, places: &[u32]| {
            let bits = places.iter().enumerate();
            bits.fold(0, |key, (bit, place)| key | (x >> bit & 1) << place)
        };
        let axes = self.dilated.iter_mut().zip(&mut self.masks);
        for (((dilated, mask), places), &size) in axes.zip(&places).zip(&self.domain.size) {
            dilated.clear();
            dilated.extend((0..size).map(|x| spread(x, places)));
            *mask = spread(u32::MAX, places);
        }
    }

    /// The cell of a key.
    fn cell(&self, key: u32) -> IVec3 {
        let coordinate = |axis: usize| {
            let bits = key & self.masks[axis];
            self.dilated[axis].partition_point(|&dilated| dilated < bits) as i32
        };
        let relative = IVec3::new(coordinate(0), coordinate(1), coordinate(2));
        self.domain.origin.wrapping_add(relative)
    }

    /// Updates the handles for the points, and sorts them.
    fn sort(&mut self, points: &[Vec4], anew: bool, execution: &Execution) {
        let (grid, domain, dilated) = (&self.grid, &self.domain, &self.dilated);
        let key = |row: u32| {
            let place = domain.place(grid.cell_of(points[row as usize]));
            (0..3).fold(0, |key, axis| key | dilated[axis][place[axis] as usize])
        };
        let (keys, rows) = (&self.cells.keys, self.cells.entries.all_rows());
        let known = keys.len();
        let all = |handles: &mut Vec<Handle>| {
            execution.install(|| {
                (0..points.len() as u32)
                    .into_par_iter()
                    .map(|row| handle(key(row), row))
                    .collect_into_vec(handles);
                handles.par_sort_unstable();
            });
        };
        if anew || known == 0 {
            return all(&mut self.handles);
        }
        // Handles with an unchanged key keep their order; changed ones are collected. Removed rows are skipped.
        self.changed.resize_with(known.div_ceil(CHUNK), Vec::new);
        self.handles.resize(known, 0);
        execution.install(|| {
            self.handles
                .par_chunks_mut(CHUNK)
                .zip(&mut self.changed)
                .zip(keys.par_chunks(CHUNK).zip(rows.par_chunks(CHUNK)))
                .for_each(|((handles, changed), (keys, rows))| {
                    changed.clear();
                    for ((out, &old), &row) in handles.iter_mut().zip(keys).zip(rows) {
                        *out = Handle::MAX;
                        if (row as usize) < points.len() {
                            let new = key(row);
                            let handle = handle(new, row);
                            if new == old {
                                *out = handle;
                            } else {
                                changed.push(handle);
                            }
                        }
                    }
                });
        });
        self.moved.clear();
        self.moved.extend(self.changed.iter().flatten());
        let spawned = known as u32..points.len() as u32;
        self.moved.extend(spawned.map(|row| handle(key(row), row)));
        if self.moved.len() as f32 > DISORDER * points.len() as f32 {
            return all(&mut self.handles);
        }
        execution.install(|| self.moved.par_sort_unstable());
        insert(&mut self.handles, &self.moved);
    }
}

/// Merges sorted `moved` into sorted `handles`, whose gaps are `Handle::MAX`.
fn insert(handles: &mut Vec<Handle>, moved: &[Handle]) {
    handles.retain(|&handle| handle != Handle::MAX);
    let mut stay = handles.len();
    handles.resize(stay + moved.len(), 0);
    let mut place = handles.len();
    for &new in moved.iter().rev() {
        while stay > 0 && handles[stay - 1] > new {
            place -= 1;
            stay -= 1;
            handles[place] = handles[stay];
        }
        place -= 1;
        handles[place] = new;
    }
}

impl SpatialIndex for ZIndexSort {
    fn update(&mut self, points: &[Vec4], execution: &Execution) -> Result<(), DomainTooLarge> {
        let changed = self.domain.fit(&self.grid, points, padded, execution)?;
        if changed {
            self.dilate();
        }
        self.sort(points, changed, execution);
        let cells = padded(self.domain.size.map(u64::from)) as usize;
        let sorted = |k: usize| self.handles[k];
        self.cells.take(sorted, cells, points, execution);
        Ok(())
    }

    fn rebuild(&mut self, points: &[Vec4], execution: &Execution) -> Result<(), DomainTooLarge> {
        self.cells.keys.clear();
        self.update(points, execution)
    }

    fn grid(&self) -> &Grid {
        &self.grid
    }

    fn partitions(&self) -> usize {
        self.cells.partitions()
    }

    fn partition_len(&self, partition: usize) -> usize {
        self.cells.partition(partition).len()
    }

    fn next_cell(&self, partition: usize, from: usize) -> Option<(IVec3, &[u32])> {
        let (key, rows) = self.cells.next_cell(partition, from)?;
        Some((self.cell(key), rows))
    }

    fn entries(&self) -> &Entries {
        &self.cells.entries
    }

    fn runs(&self, center: IVec3, out: &mut Vec<Run>) {
        let [x, y, z] = [0, 1, 2].map(|axis| {
            let span = self.domain.span(center, self.grid.reach, axis);
            &self.dilated[axis][span.start as usize..span.end as usize]
        });
        for z in z {
            for y in y {
                for x in x {
                    let key = x | y | z;
                    let run = self.cells.run(key, key);
                    if run.len > 0 {
                        out.push(run);
                    }
                }
            }
        }
    }

    fn bytes(&self) -> usize {
        let dilated: usize = self.dilated.iter().map(Vec::capacity).sum();
        let changed: usize = self.changed.iter().map(Vec::capacity).sum();
        let handles = self.handles.capacity() + self.moved.capacity() + changed;
        dilated * size_of::<u32>() + handles * size_of::<Handle>() + self.cells.bytes()
    }
}
