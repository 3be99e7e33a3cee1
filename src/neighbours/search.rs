//! The neighbour search: tests the candidates around every cell and writes the lists.

use std::{
    cell::RefCell,
    sync::{
        Mutex, PoisonError,
        atomic::{AtomicUsize, Ordering::Relaxed},
    },
};

use glam::{IVec3, Vec4};

use super::lists::{NeighbourLists, Region, Spans};
use crate::{
    index::{Images, Run, SpatialIndex},
    memory,
    simd::{CANDIDATE_ALIGNMENT, Candidates, FIRST_ROOM, Near, Probe, Simd, Vectorised},
    state::Execution,
    state::ListsTooLong,
};

/// Input of a search.
#[derive(Clone, Copy)]
pub struct Search<'a> {
    /// Index of the particles whose neighbours are searched.
    pub of: &'a dyn SpatialIndex,
    /// Their positions, by row.
    pub points: &'a [Vec4],
    /// Index of the particles that may be neighbours.
    pub among: &'a dyn SpatialIndex,
    /// Their positions, by row.
    pub among_points: &'a [Vec4],
    /// Whether both sets are the same particles, so that a row is not its own neighbour.
    pub same: bool,
}

impl<'a> Search<'a> {
    /// Neighbours among the points of one index.
    pub fn among_themselves(index: &'a dyn SpatialIndex, points: &'a [Vec4]) -> Self {
        Self {
            of: index,
            points,
            among: index,
            among_points: points,
            same: true,
        }
    }
}

impl Search<'_> {
    fn radius_squared(&self) -> f32 {
        let h = self.among.grid().support_radius;
        h * h
    }

    /// The support radius around the bounding box of `rows`. Of the 216 candidates in 27 cells around a cell of eight
    /// points, 110 to 170 pass; the test is free, because the candidates must be copied anyway.
    #[inline(always)]
    fn near(&self, rows: &[u32]) -> Near {
        let (mut low, mut high) = (Vec4::INFINITY, Vec4::NEG_INFINITY);
        for &row in rows {
            // Images of points have no lists.
            let Some(&point) = self.points.get(row as usize) else {
                continue;
            };
            // With this order of arguments, NaN coordinates do not change the box.
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

/// Runs reserved at once: the 125 cells around a point with cells of h/2.
const FIRST_RUNS: usize = 128;

/// Buffers of one thread, reused between steps.
#[derive(Default)]
pub(super) struct Scratch {
    runs: Vec<Run>,
    pub(super) candidates: Candidates,
    hits: Vec<u32>,
}

thread_local! {
    static SCRATCH: RefCell<Scratch> = RefCell::default();
    static SPARE: RefCell<Vec<Scratch>> = RefCell::default();
}

impl Scratch {
    /// Collects the candidates around `cell` that are near any of `members`, the points of that cell, and reserves as
    /// many hits. Without members it collects all candidates.
    #[inline(always)]
    pub(super) fn fetch<S: Simd>(
        &mut self,
        simd: S,
        search: &Search,
        (partition, cell): (Option<usize>, IVec3),
        members: &[u32],
    ) {
        self.candidates.clear();
        self.runs.clear();
        self.runs.reserve(FIRST_RUNS);
        match partition {
            Some(partition) if search.same => {
                search.among.runs_around(partition, cell, &mut self.runs)
            }
            _ => search.among.runs(cell, &mut self.runs),
        }
        let entries = search.among.entries();
        if !entries.with_positions() {
            let images = search.among.images();
            let points = images.map_or(search.among_points, Images::points);
            for &run in &self.runs {
                self.candidates.extend(entries.rows(run), points);
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
            self.hits.resize(self.room().max(FIRST_ROOM), 0);
        }
    }

    /// Buffer length that `collect_hits` needs.
    fn room(&self) -> usize {
        self.candidates.padded_len() + CANDIDATE_ALIGNMENT
    }
}

/// Maximum memory per pair \[bytes]: an entry that did not fit exists three times for a moment, and each has a kernel
/// gradient.
const BYTES_PER_PAIR: u64 = 16;

/// Maximum number of pairs: limited by the range of a span and by the machine's memory.
fn most_pairs() -> usize {
    let fitting = memory::of_machine() / BYTES_PER_PAIR;
    usize::try_from(fitting.min(u32::MAX.into())).unwrap_or(usize::MAX)
}

/// Computes the lists of all rows. If they are too long, all lists are empty.
pub fn search(
    search: &Search,
    lists: &mut NeighbourLists,
    execution: &Execution,
) -> Result<(), ListsTooLong> {
    lists.lay_out(search.of, search.points.len());
    let NeighbourLists {
        spans,
        rows,
        regions,
        strays,
        partitions_per_block,
        ..
    } = &mut *lists;
    let too_long = Mutex::new(None);
    let (strayed, most) = (AtomicUsize::new(0), most_pairs());
    let task = Task {
        search,
        spans,
        strays,
        strayed: &strayed,
        most,
        too_long: &too_long,
        base: 0,
        first_block: 0,
        partitions: search.of.partitions(),
        partitions_per_block: *partitions_per_block,
        execution,
    };
    execution.install(|| task.split(rows, regions));
    let too_long = too_long
        .into_inner()
        .unwrap_or_else(PoisonError::into_inner);
    let pairs = lists.pairs();
    let fits = too_long.is_none() && pairs <= most;
    if fits && lists.gather_strays() <= u32::MAX as usize {
        return Ok(());
    }
    lists.clear();
    Err(too_long.unwrap_or(ListsTooLong::Together { pairs, most }))
}

/// Blocks that are searched in parallel, each with its own region.
#[derive(Clone, Copy)]
struct Task<'a> {
    search: &'a Search<'a>,
    spans: &'a Spans,
    /// See [`NeighbourLists::strays`].
    strays: &'a Mutex<Vec<u32>>,
    /// Number of entries that did not fit, and the most that are kept: beyond it the search fails.
    strayed: &'a AtomicUsize,
    most: usize,
    /// The first row whose list is too long.
    too_long: &'a Mutex<Option<ListsTooLong>>,
    /// Position of the first entry in the flat array.
    base: usize,
    first_block: usize,
    partitions: usize,
    partitions_per_block: usize,
    execution: &'a Execution,
}

impl Task<'_> {
    /// Keeps a list that did not fit.
    #[cold]
    fn stray(&self, row: u32, list: &[u32]) {
        if list.len() > usize::from(u16::MAX)
            || self.strayed.fetch_add(list.len(), Relaxed) + list.len() > self.most
        {
            return;
        }
        let mut strays = self.strays.lock().unwrap_or_else(PoisonError::into_inner);
        strays.extend([row, list.len() as u32]);
        strays.extend(list);
    }

    /// Records a list that is too long.
    #[cold]
    fn refuse(&self, row: u32, count: usize) {
        let row = row as usize;
        let mut too_long = self.too_long.lock().unwrap_or_else(PoisonError::into_inner);
        match *too_long {
            Some(ListsTooLong::OfRow { row: first, .. }) if first < row => {}
            _ => *too_long = Some(ListsTooLong::OfRow { row, count }),
        }
    }

    /// Splits blocks and array recursively, which gives disjoint regions without a list of slices.
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
        let first = task.first_block * task.partitions_per_block;
        let mut scratch = SCRATCH.take();
        let points = task.search.points.len();
        let images = task.search.among.images();
        // Rows of other ranks have lists of boundary particles alone.
        let of_rank = task.search.same.then(|| task.execution.owned(points));
        let own = of_rank.unwrap_or(0..points);
        let own = own.start as u32..own.end as u32;
        // Position of the next list.
        let mut end = 0;
        for partition in first..task.partitions.min(first + task.partitions_per_block) {
            let mut done = 0;
            if task.search.same {
                task.search.among.prefetch_around(partition + 1);
            }
            while let Some((cell, members)) = task.search.of.next_cell(partition, done) {
                done += members.len();
                if images.is_some() || own.len() < points {
                    let others = members.iter().filter(|row| !own.contains(row));
                    // Images of points have no spans.
                    let with_spans = others.clone().filter(|&&row| (row as usize) < points);
                    with_spans.for_each(|&row| task.spans.set(row, 0, 0));
                    if others.count() == members.len() {
                        continue;
                    }
                }
                scratch.fetch(simd, task.search, (Some(partition), cell), members);
                let members = members.iter().filter(|row| own.contains(row));
                if scratch.candidates.is_empty() {
                    for &row in members {
                        task.spans.set(row, 0, 0);
                    }
                    continue;
                }
                for &row in members {
                    let probe = task.search.probe(row);
                    let room = &mut rows[end..region.len];
                    // If the region has enough space, hits are written directly into the list.
                    let count = if room.len() >= scratch.room() {
                        let count = simd.collect_hits(&scratch.candidates, probe, room);
                        if let Some(images) = images {
                            images.resolve(&mut room[..count]);
                        }
                        count
                    } else {
                        let hits = &mut scratch.hits;
                        let count = simd.collect_hits(&scratch.candidates, probe, hits);
                        if let Some(images) = images {
                            images.resolve(&mut hits[..count]);
                        }
                        match room.get_mut(..count) {
                            Some(list) => list.copy_from_slice(&hits[..count]),
                            None => task.stray(row, &hits[..count]),
                        }
                        count
                    };
                    region.found += count;
                    if count > usize::from(u16::MAX) {
                        task.refuse(row, count);
                    }
                    if end + count <= region.len {
                        task.spans.set(row, task.base + end, count);
                        end += count;
                    }
                }
            }
        }
        SCRATCH.set(scratch);
    }
}

/// Neighbours that are recomputed instead of stored (paper 5.3.1). Consecutive rows of one cell share the candidates.
pub struct Recomputed<'a> {
    search: Search<'a>,
    scratch: Scratch,
    cell: Option<IVec3>,
}

impl<'a> Recomputed<'a> {
    /// No candidates yet.
    pub fn new(search: Search<'a>) -> Self {
        Self {
            search,
            scratch: SPARE.with_borrow_mut(Vec::pop).unwrap_or_default(),
            cell: None,
        }
    }

    /// Neighbours of `row`, the same and in the same order as in a stored list.
    #[inline(always)]
    pub fn of<S: Simd>(&mut self, simd: S, row: usize) -> &[u32] {
        let cell = self.search.of.grid().cell_of(self.search.points[row]);
        if self.cell != Some(cell) {
            self.cell = Some(cell);
            self.scratch.fetch(simd, &self.search, (None, cell), &[]);
        }
        let probe = self.search.probe(row as u32);
        let count = simd.collect_hits(&self.scratch.candidates, probe, &mut self.scratch.hits);
        if let Some(images) = self.search.among.images() {
            images.resolve(&mut self.scratch.hits[..count]);
        }
        &self.scratch.hits[..count]
    }
}

impl Drop for Recomputed<'_> {
    fn drop(&mut self) {
        SPARE.with_borrow_mut(|spare| spare.push(std::mem::take(&mut self.scratch)));
    }
}
