//! Neighbour lists: rows in one flat array, in an order that no number of threads changes.
//!
//! [`search`] goes through the cells of an index in parallel (paper 4.5.2), tests the candidates around each and writes
//! the hits. Every block of cells has a region of the flat array, sized by what it needed in the last step; a block
//! that needs more gets a region at the end and is searched once more. A particle is not in its own list.
//!
//! Not done, and why. Half the search, every pair tested once and written to both lists: the tests are a sixth of the
//! query by a profile, so half of them is less than what scattered writes to lists of other cells, their counting in a
//! first pass and their sorting would cost. Lists of 16-bit offsets: a density pass over them took 10 % less time
//! in a trial, at half the memory; but rows along the Z-curve are further apart than 32 767 wherever it crosses one of its
//! large borders, so every list would need a second form, and every loop a branch for it.

use std::{
    cell::RefCell,
    sync::atomic::{AtomicU64, Ordering::Relaxed},
};

use bevy_ecs::prelude::*;
use glam::{IVec3, Vec4};

use crate::{
    boundary::BoundarySamples,
    column::Positions,
    execution::Execution,
    index::{FluidIndex, Run, SpatialIndex},
    pairs::PairSlopes,
    simd::{CANDIDATE_ALIGNMENT, Candidates, Near, Portable, Probe, Simd, Vectorised},
};

/// Cells that one task searches.
const BLOCK: usize = 16;

/// Neighbour lists of all rows.
#[derive(Debug, Default)]
pub struct NeighbourLists {
    /// Start and length of every row's list, packed. The rows of a cell are scattered and each is written by one cell
    /// alone: relaxed atomics, plain moves on every machine, say so without `unsafe`.
    spans: Vec<AtomicU64>,
    /// The lists.
    rows: Vec<u32>,
    regions: Vec<Region>,
}

/// Part of the flat array that a block of cells writes.
#[derive(Debug, Default, Clone, Copy)]
struct Region {
    start: usize,
    len: usize,
    /// Entries needed, which may be more than `len`.
    needed: usize,
}

/// Neighbours of a particle within the fluid at the default support, roughly.
const FULL_NEIGHBOURHOOD: f64 = 30.0;

/// Bits of a list's length in its span; the others hold the start.
const LENGTH_BITS: u32 = 24;

impl NeighbourLists {
    /// Neighbours of `row`; none if it came after the search, in an order that keeps stale lists.
    #[inline(always)]
    pub fn of(&self, row: usize) -> &[u32] {
        let Some(span) = self.spans.get(row) else {
            return &[];
        };
        let span = span.load(Relaxed);
        let start = (span >> LENGTH_BITS) as usize;
        &self.rows[start..start + (span & ((1 << LENGTH_BITS) - 1)) as usize]
    }

    /// Pairs of a row and a neighbour in all lists.
    pub fn pairs(&self) -> usize {
        self.regions.iter().map(|region| region.needed).sum()
    }

    /// Memory held [bytes].
    pub fn bytes(&self) -> usize {
        self.spans.capacity() * size_of::<AtomicU64>()
            + self.rows.capacity() * size_of::<u32>()
            + self.regions.capacity() * size_of::<Region>()
    }

    /// Gives every block a region, by what it needed last or, for blocks of a new order, by the mean.
    fn lay_out(&mut self, index: &dyn SpatialIndex, points: usize, same_cells: bool) {
        self.spans.resize_with(points, AtomicU64::default);
        // Before the first search: as many as in a full neighbourhood.
        let mean = if self.pairs() == 0 {
            FULL_NEIGHBOURHOOD
        } else {
            self.pairs() as f64 / points.max(1) as f64
        };
        let blocks = index.places().div_ceil(BLOCK);
        self.regions.resize(blocks, Region::default());
        let mut start = 0;
        for (block, region) in self.regions.iter_mut().enumerate() {
            let expected = if same_cells {
                region.needed
            } else {
                let places = block * BLOCK..index.places().min((block + 1) * BLOCK);
                (places.map(|place| index.place_len(place)).sum::<usize>() as f64 * mean) as usize
            };
            let len = expected + expected / 16 + CANDIDATE_ALIGNMENT;
            *region = Region {
                start,
                len,
                needed: 0,
            };
            start += len;
        }
        // What regions without room left behind at the end is free again.
        self.rows.truncate(start);
        if self.rows.capacity() > start + start / 2 {
            self.rows.shrink_to_fit();
        }
        if self.rows.capacity() < start {
            // A little more, so that lists that lengthen step by step are not moved in every one.
            let room = start + start / 16;
            self.rows.reserve_exact(room - self.rows.len());
        }
        self.rows.resize(start, 0);
    }
}

/// What a search reads.
#[derive(Clone, Copy)]
pub struct Search<'a> {
    /// Index of the particles whose neighbours are wanted.
    pub of: &'a dyn SpatialIndex,
    /// Where they are, by row.
    pub points: &'a [Vec4],
    /// Index of the particles that may be neighbours.
    pub among: &'a dyn SpatialIndex,
    /// Where they are, by row.
    pub among_points: &'a [Vec4],
    /// Whether both are the same particles, so that a row is not its own neighbour.
    pub same: bool,
}

impl Search<'_> {
    fn radius_squared(&self) -> f32 {
        let h = self.among.grid().support_radius;
        h * h
    }

    /// Within reach of the box around `rows`. Of the 216 candidates in 27 cells around a cell of eight these are 110
    /// to 170, and the test costs no more than the copy that has to be made anyway.
    #[inline(always)]
    fn near(&self, rows: &[u32]) -> Near {
        let (mut low, mut high) = (Vec4::INFINITY, Vec4::NEG_INFINITY);
        for &row in rows {
            let point = self.points[row as usize];
            // In this order a coordinate that is not a number leaves the box as it is.
            (low, high) = (point.min(low), point.max(high));
        }
        Near {
            low: low.truncate().to_array(),
            high: high.truncate().to_array(),
            radius_squared: self.radius_squared(),
        }
    }

    fn probe(&self, row: u32) -> Probe {
        let center = self.points[row as usize];
        Probe {
            center: [center.x, center.y, center.z],
            radius_squared: self.radius_squared(),
            own_row: if self.same { row } else { u32::MAX },
        }
    }
}

/// Buffers of one thread, warm after the first step.
#[derive(Default)]
struct Scratch {
    runs: Vec<Run>,
    candidates: Candidates,
    hits: Vec<u32>,
}

thread_local! {
    static SCRATCH: RefCell<Scratch> = RefCell::default();
    static SPARE: RefCell<Vec<Scratch>> = RefCell::default();
}

impl Scratch {
    /// Takes the candidates around `cell` that are near enough to any of `members`, points of that cell, and room for as
    /// many hits. Without members all are.
    #[inline(always)]
    fn fetch<S: Simd>(
        &mut self,
        simd: S,
        search: &Search,
        (place, cell): (Option<usize>, IVec3),
        members: &[u32],
    ) {
        self.candidates.clear();
        self.runs.clear();
        match place {
            Some(place) if search.same => search.among.runs_around(place, cell, &mut self.runs),
            _ => search.among.runs(cell, &mut self.runs),
        }
        let entries = search.among.entries();
        if !entries.with_positions() {
            for &run in &self.runs {
                self.candidates
                    .extend(entries.rows(run), search.among_points);
            }
        } else if !self.runs.is_empty() {
            let near = if members.is_empty() {
                Near::ALL
            } else {
                search.near(members)
            };
            simd.take_near(&mut self.candidates, near, entries.blocks(), &self.runs);
        }
        self.candidates.pad();
        if self.hits.len() < self.room() {
            self.hits.resize(self.room(), 0);
        }
    }

    /// Room that hits may need while they are written.
    fn room(&self) -> usize {
        self.candidates.padded_len() + CANDIDATE_ALIGNMENT
    }
}

/// Writes the lists of all rows. `same_cells` says that the cells are, by and large, those of the last search.
pub fn search(
    search: &Search,
    lists: &mut NeighbourLists,
    same_cells: bool,
    execution: &Execution,
) {
    lists.lay_out(search.of, search.points.len(), same_cells);
    let NeighbourLists {
        spans,
        rows,
        regions,
    } = lists;
    let cells = search.of.places();
    let run = |rows: &mut [u32], base: usize, first_block: usize, regions: &mut [Region]| {
        let task = Task {
            search,
            spans,
            base,
            first_block,
            cells,
            execution,
        };
        execution.install(|| task.split(rows, regions));
    };
    run(rows, 0, 0, regions);
    // Blocks that ran out of room: a new region at the end, in the order of the blocks.
    for (block, region) in regions.iter_mut().enumerate() {
        if region.needed > region.len {
            let start = rows.len();
            let len = region.needed + CANDIDATE_ALIGNMENT;
            // Not twice as much, as a vector would take: the next layout would give it back.
            if rows.capacity() < start + len {
                rows.reserve_exact(len + start / 16);
            }
            rows.resize(start + len, 0);
            *region = Region {
                start,
                len,
                needed: 0,
            };
            run(
                &mut rows[start..],
                start,
                block,
                std::slice::from_mut(region),
            );
        }
    }
}

/// Distances that the paper's query computes: for every row all candidates around its cell, the row itself among them.
/// Ours computes fewer, since it first drops candidates that none of the cell's points reaches.
pub fn tested_pairs(search: &Search) -> usize {
    let mut scratch = Scratch::default();
    let mut tested = 0;
    for place in 0..search.of.places() {
        let mut done = 0;
        while let Some((coordinates, members)) = search.of.group(place, done) {
            done += members.len();
            scratch.fetch(Portable, search, (Some(place), coordinates), &[]);
            tested += members.len() * scratch.candidates.len();
        }
    }
    tested
}

/// Blocks that are searched in parallel, each with its own region.
#[derive(Clone, Copy)]
struct Task<'a> {
    search: &'a Search<'a>,
    spans: &'a [AtomicU64],
    /// Place of the first entry in the flat array.
    base: usize,
    first_block: usize,
    cells: usize,
    execution: &'a Execution,
}

impl Task<'_> {
    /// Halves the blocks and the array with them until one is left: disjoint regions without a list of slices.
    fn split(self, rows: &mut [u32], regions: &mut [Region]) {
        match regions {
            [] => {}
            [region] => {
                let block = Block {
                    task: self,
                    region,
                    rows,
                };
                self.execution.instruction_set.dispatch(block);
            }
            _ => {
                let half = regions.len() / 2;
                let (left, right) = regions.split_at_mut(half);
                let (left_rows, right_rows) = rows.split_at_mut(right[0].start - self.base);
                let later = Task {
                    base: right[0].start,
                    first_block: self.first_block + half,
                    ..self
                };
                rayon::join(
                    || self.split(left_rows, left),
                    || later.split(right_rows, right),
                );
            }
        }
    }
}

/// The search of one block.
struct Block<'a> {
    task: Task<'a>,
    region: &'a mut Region,
    rows: &'a mut [u32],
}

impl Vectorised for Block<'_> {
    type Output = ();

    #[inline(always)]
    fn run<S: Simd>(self, simd: S) {
        let Self { task, region, rows } = self;
        let first = task.first_block * BLOCK;
        let mut scratch = SCRATCH.take();
        for cell in first..task.cells.min(first + BLOCK) {
            let mut done = 0;
            while let Some((coordinates, members)) = task.search.of.group(cell, done) {
                done += members.len();
                scratch.fetch(simd, task.search, (Some(cell), coordinates), members);
                if scratch.candidates.is_empty() {
                    for &row in members {
                        task.spans[row as usize].store(0, Relaxed);
                    }
                    continue;
                }
                for &row in members {
                    let probe = task.search.probe(row);
                    let used = region.needed;
                    // With room to spare hits go straight into the list.
                    let count = match rows.get_mut(used..region.len) {
                        Some(list) if list.len() >= scratch.room() => {
                            simd.collect_hits(&scratch.candidates, probe, list)
                        }
                        list => {
                            let count =
                                simd.collect_hits(&scratch.candidates, probe, &mut scratch.hits);
                            if let Some(list) = list.and_then(|list| list.get_mut(..count)) {
                                list.copy_from_slice(&scratch.hits[..count]);
                            }
                            count
                        }
                    };
                    let span = ((task.base + used) as u64) << LENGTH_BITS | count as u64;
                    task.spans[row as usize].store(span, Relaxed);
                    region.needed += count;
                }
            }
        }
        SCRATCH.set(scratch);
    }
}

/// Neighbours found on the spot and not stored (paper 5.3.1): rows asked for in an order that stays within a cell, or
/// near it, share the candidates.
pub struct OnTheSpot<'a> {
    search: Search<'a>,
    scratch: Scratch,
    cell: Option<IVec3>,
}

impl<'a> OnTheSpot<'a> {
    /// Nothing found yet.
    pub fn new(search: Search<'a>) -> Self {
        Self {
            search,
            scratch: SPARE.with_borrow_mut(Vec::pop).unwrap_or_default(),
            cell: None,
        }
    }

    /// Neighbours of `row`, the same in the same order as a stored list would hold.
    #[inline(always)]
    pub fn of<S: Simd>(&mut self, simd: S, row: usize) -> &[u32] {
        let cell = self.search.of.grid().cell_of(self.search.points[row]);
        if self.cell != Some(cell) {
            self.cell = Some(cell);
            self.scratch.fetch(simd, &self.search, (None, cell), &[]);
        }
        let probe = self.search.probe(row as u32);
        let count = simd.collect_hits(&self.scratch.candidates, probe, &mut self.scratch.hits);
        &self.scratch.hits[..count]
    }
}

impl Drop for OnTheSpot<'_> {
    fn drop(&mut self) {
        SPARE.with_borrow_mut(|spare| spare.push(std::mem::take(&mut self.scratch)));
    }
}

/// Lists of the fluid particles (absent when neighbours are recomputed).
#[derive(Resource, Default)]
pub struct FluidNeighbours(pub NeighbourLists);

/// Lists of the boundary particles around every fluid particle.
#[derive(Resource, Default)]
pub struct BoundaryNeighbours(pub NeighbourLists);

/// Finds the neighbours among the fluid (phase `FindNeighbours`).
pub fn find_fluid_neighbours(
    mut lists: ResMut<FluidNeighbours>,
    mut slopes: ResMut<PairSlopes>,
    index: Res<FluidIndex>,
    positions: Res<Positions>,
    execution: Res<Execution>,
) {
    slopes.forget();
    let points = positions.points();
    let of = &*index.structure;
    let task = Search {
        of,
        points,
        among: of,
        among_points: points,
        same: true,
    };
    search(&task, &mut lists.0, !index.rebuilt, &execution);
}

/// Finds the neighbours among the boundary (phase `FindNeighbours`).
pub fn find_boundary_neighbours(
    mut lists: ResMut<BoundaryNeighbours>,
    index: Res<FluidIndex>,
    boundary: Res<BoundarySamples>,
    positions: Res<Positions>,
    execution: Res<Execution>,
) {
    let task = Search {
        of: &*index.structure,
        points: positions.points(),
        among: &*boundary.index,
        among_points: boundary.points(),
        same: false,
    };
    search(&task, &mut lists.0, !index.rebuilt, &execution);
}
