//! The search: candidates around every cell, tested and written into lists.

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
    index::{Run, SpatialIndex},
    memory,
    simd::{CANDIDATE_ALIGNMENT, Candidates, FIRST_ROOM, Near, Portable, Probe, Simd, Vectorised},
    state::Execution,
    state::ListsTooLong,
};

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

impl<'a> Search<'a> {
    /// The points of an index among each other.
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

/// Runs that there is room for at once: the 125 cells around a point with cells of h/2.
const FIRST_RUNS: usize = 128;

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
    /// Takes the candidates around `cell` that are near enough to any of `members`, points of that cell, and room for
    /// as many hits. Without members all are.
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
        self.runs.reserve(FIRST_RUNS);
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
            self.hits.resize(self.room().max(FIRST_ROOM), 0);
        }
    }

    /// Room that hits may need while they are written.
    fn room(&self) -> usize {
        self.candidates.padded_len() + CANDIDATE_ALIGNMENT
    }
}

/// Bytes of memory a pair at most: an entry that found no room is held thrice for a moment, and each has a slope.
const BYTES_A_PAIR: u64 = 16;

/// Pairs that lists can hold: what a span can say, and what the machine has memory for.
fn most_pairs() -> usize {
    let fitting = memory::of_machine() / BYTES_A_PAIR;
    usize::try_from(fitting.min(u32::MAX.into())).unwrap_or(usize::MAX)
}

/// Writes the lists of all rows. Where they are too long there are none.
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
        places_a_block,
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
        places: search.of.places(),
        places_a_block: *places_a_block,
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
    spans: &'a Spans,
    /// See [`NeighbourLists::strays`].
    strays: &'a Mutex<Vec<u32>>,
    /// Entries of lists that found no room, and the most that are taken: with more there will be no lists.
    strayed: &'a AtomicUsize,
    most: usize,
    /// The list of the first row that is too long.
    too_long: &'a Mutex<Option<ListsTooLong>>,
    /// Place of the first entry in the flat array.
    base: usize,
    first_block: usize,
    places: usize,
    places_a_block: usize,
    execution: &'a Execution,
}

impl Task<'_> {
    /// Takes a list that found no room.
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

    /// Takes note of a list that is too long.
    #[cold]
    fn refuse(&self, row: u32, count: usize) {
        let row = row as usize;
        let mut too_long = self.too_long.lock().unwrap_or_else(PoisonError::into_inner);
        match *too_long {
            Some(ListsTooLong::OfRow { row: first, .. }) if first < row => {}
            _ => *too_long = Some(ListsTooLong::OfRow { row, count }),
        }
    }

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
        let first = task.first_block * task.places_a_block;
        let mut scratch = SCRATCH.take();
        // Where the next list goes.
        let mut end = 0;
        for place in first..task.places.min(first + task.places_a_block) {
            let mut done = 0;
            if task.search.same {
                task.search.among.prefetch_around(place + 1);
            }
            while let Some((cell, members)) = task.search.of.group(place, done) {
                done += members.len();
                scratch.fetch(simd, task.search, (Some(place), cell), members);
                if scratch.candidates.is_empty() {
                    for &row in members {
                        task.spans.set(row, 0, 0);
                    }
                    continue;
                }
                for &row in members {
                    let probe = task.search.probe(row);
                    let room = &mut rows[end..region.len];
                    // With room to spare hits go straight into the list.
                    let count = if room.len() >= scratch.room() {
                        simd.collect_hits(&scratch.candidates, probe, room)
                    } else {
                        let hits = &mut scratch.hits;
                        let count = simd.collect_hits(&scratch.candidates, probe, hits);
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
