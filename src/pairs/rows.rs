//! The loop over all rows in parallel, with stored lists or with neighbours found on the spot.

use std::{cell::RefCell, ops::Range};

use glam::{IVec3, Vec4};
use rayon::prelude::*;

use super::{
    Pair, PairSlopes, PairSum, broadcast, difference, dot, putting,
    slopes::{Computed, Generations, Kept, Known, Slopes, make_room},
};
use crate::{
    kernel::Kernel,
    neighbours::{NeighbourLists, Recomputed, Search},
    simd::{LANES, Simd, Vectorised},
    state::{CHUNK, Execution},
};

/// Where the particles of a pass are: fluid and boundary, each with a fourth entry and ended by a sentinel; and how far
/// they reach.
#[derive(Clone, Copy)]
pub struct Places<'a> {
    /// Positions of the fluid particles \[m].
    pub fluid: &'a [Vec4],
    /// Positions \[m] and volumes \[m³; m² in 2-D] of the boundary particles.
    pub boundary: &'a [Vec4],
    /// The kernel whose slopes the pairs have.
    pub kernel: &'a Kernel,
}

impl Places<'_> {
    /// How many rows of the fluid there are.
    fn rows(&self) -> usize {
        self.fluid.len() - 1
    }

    /// How many chunks they make.
    fn chunks(&self) -> usize {
        self.rows().div_ceil(CHUNK)
    }

    /// The rows of a chunk.
    fn chunk(&self, chunk: usize) -> Range<usize> {
        let first = chunk * CHUNK;
        first..self.rows().min(first + CHUNK)
    }
}

/// Where a loop takes neighbours from: the fluid's, and the boundary's if there is one.
#[derive(Clone, Copy)]
pub enum Source<'a> {
    /// Lists.
    Stored(&'a NeighbourLists, Option<&'a NeighbourLists>),
    /// Searches.
    Recomputed(Search<'a>, Option<Search<'a>>),
}

/// Runs `pass` over all rows into `out`.
pub fn sum<P: PairSum>(
    pass: &P,
    source: Source,
    places: Places,
    out: &mut [P::Output],
    execution: &Execution,
) {
    over_rows(pass, source, places, None, putting(out), execution);
}

/// Runs `pass` over all rows; what it gives goes to `takers`.
pub(super) fn over_rows<P: PairSum, T: FnMut(usize, P::Output)>(
    pass: &P,
    source: Source,
    places: Places,
    slopes: Option<&PairSlopes>,
    takers: impl IndexedParallelIterator<Item = T>,
    execution: &Execution,
) {
    debug_assert_eq!(takers.len(), places.chunks(), "a taker a chunk");
    let set = execution.instruction_set;
    let work = |(chunk, take)| {
        let rows = places.chunk(chunk);
        match source {
            Source::Stored(fluid, boundary) => {
                let chunk = StoredChunk {
                    pass,
                    places,
                    fluid,
                    boundary,
                    slopes: Computed,
                    rows,
                    take,
                };
                match slopes.and_then(|slopes| slopes.chunk(chunk.rows.start)) {
                    Some(slopes) => set.arithmetic().dispatch(chunk.with(Known(slopes.iter()))),
                    None => set.arithmetic().dispatch(chunk),
                }
            }
            Source::Recomputed(fluid, boundary) => {
                set.dispatch(SpotChunk {
                    pass,
                    places,
                    fluid,
                    boundary,
                    rows,
                    take,
                });
            }
        }
    };
    execution.install(|| takers.enumerate().for_each(work));
}

/// The same with lists, at positions whose slopes are kept.
pub(super) fn over_rows_and_keep<P: PairSum, T: FnMut(usize, P::Output)>(
    pass: &P,
    (fluid, boundary): (&NeighbourLists, Option<&NeighbourLists>),
    places: Places,
    (slopes, generations): (&mut PairSlopes, Generations),
    takers: impl IndexedParallelIterator<Item = T>,
    execution: &Execution,
) {
    debug_assert_eq!(takers.len(), places.chunks(), "a taker a chunk");
    let set = execution.instruction_set.arithmetic();
    let slopes = slopes.chunks_to_fill(places.rows(), generations);
    execution.install(|| {
        let chunks = takers.zip(slopes).enumerate();
        chunks.for_each(|(chunk, (take, slopes))| {
            let rows = places.chunk(chunk);
            make_room(slopes, fluid, rows.clone());
            set.dispatch(StoredChunk {
                pass,
                places,
                fluid,
                boundary,
                slopes: Kept(slopes.iter_mut()),
                rows,
                take,
            });
        });
    });
}

/// How many rows before its turn a list is asked for; 8 and 32 do as well.
const AHEAD: usize = 16;

#[inline(always)]
fn pair<S: Simd>(
    simd: S,
    own: [S::F; 3],
    points: &[Vec4],
    rows: S::Rows,
    (kernel, slopes): (&Kernel, &mut impl Slopes),
) -> Pair<S> {
    let (x, fourth) = difference(simd, own, points, rows);
    let distance = dot(simd, x, x);
    Pair {
        x,
        distance,
        fourth,
        slope: slopes.next(simd, kernel, distance),
    }
}

/// One row of a pass: one loop over whole vectors, the last filled up with absent rows, and no case for a rest.
#[inline(always)]
fn row<P: PairSum, S: Simd, L: Slopes>(
    pass: &P,
    simd: S,
    places: Places,
    i: usize,
    (mut fluid, mut boundary): (&[u32], &[u32]),
    slopes: &mut L,
) -> P::Output {
    let neighbours = fluid.len() + boundary.len();
    let mut sums = pass.start(simd, i, places.fluid[i]);
    let own = broadcast(simd, places.fluid[i]);
    while P::FLUID && !fluid.is_empty() {
        let rows = simd.rows(fluid);
        let pair = if P::SLOPES_ALONE && L::KNOWN {
            let zero = simd.splat(0.0);
            Pair {
                x: [zero; 3],
                distance: zero,
                fourth: zero,
                slope: slopes.next(simd, places.kernel, zero),
            }
        } else {
            pair(simd, own, places.fluid, rows, (places.kernel, slopes))
        };
        pass.fluid(simd, &pair, rows, &mut sums);
        fluid = fluid.get(LANES..).unwrap_or_default();
    }
    while P::BOUNDARY && !boundary.is_empty() {
        let rows = simd.rows(boundary);
        let slopes = (places.kernel, &mut Computed);
        let pair = pair(simd, own, places.boundary, rows, slopes);
        pass.boundary(simd, &pair, rows, &mut sums);
        boundary = boundary.get(LANES..).unwrap_or_default();
    }
    pass.finish(simd, neighbours, sums)
}

struct StoredChunk<'a, P, L, T> {
    pass: &'a P,
    places: Places<'a>,
    fluid: &'a NeighbourLists,
    boundary: Option<&'a NeighbourLists>,
    slopes: L,
    rows: Range<usize>,
    take: T,
}

impl<'a, P, L, T> StoredChunk<'a, P, L, T> {
    fn with<M>(self, slopes: M) -> StoredChunk<'a, P, M, T> {
        StoredChunk {
            pass: self.pass,
            places: self.places,
            fluid: self.fluid,
            boundary: self.boundary,
            slopes,
            rows: self.rows,
            take: self.take,
        }
    }
}

impl<P: PairSum, L: Slopes, T: FnMut(usize, P::Output)> Vectorised for StoredChunk<'_, P, L, T> {
    type Output = ();

    #[inline(always)]
    fn run<S: Simd>(mut self, simd: S) {
        // Copies of its own, so that their fields stay in registers.
        let pass = *self.pass;
        let kernel = *self.places.kernel;
        let places = Places {
            kernel: &kernel,
            ..self.places
        };
        let mut slopes = self.slopes;
        for (k, i) in self.rows.enumerate() {
            let boundary = match self.boundary {
                Some(lists) if P::BOUNDARY || P::COUNTS => lists.of(i),
                _ => &[],
            };
            if P::FLUID {
                self.fluid.prefetch(i + AHEAD);
            }
            let lists = (self.fluid.of(i), boundary);
            (self.take)(k, row(&pass, simd, places, i, lists, &mut slopes));
        }
    }
}

struct SpotChunk<'a, P, T> {
    pass: &'a P,
    places: Places<'a>,
    fluid: Search<'a>,
    boundary: Option<Search<'a>>,
    rows: Range<usize>,
    take: T,
}

impl<P: PairSum, T: FnMut(usize, P::Output)> Vectorised for SpotChunk<'_, P, T> {
    type Output = ();

    #[inline(always)]
    fn run<S: Simd>(mut self, simd: S) {
        let grid = self.fluid.of.grid();
        // Rows of a cell one after the other, so that they share its candidates.
        let mut order = ORDER.take();
        order.clear();
        for (k, &point) in self.fluid.points[self.rows.clone()].iter().enumerate() {
            order.push((grid.cell_of(point), k));
        }
        order.sort_unstable_by_key(|&(cell, k)| (cell.to_array(), k));
        let mut fluid = Recomputed::new(self.fluid);
        let mut boundary = self.boundary.map(Recomputed::new);
        for &(_, k) in &order {
            let i = self.rows.start + k;
            let near_boundary = match &mut boundary {
                Some(search) if P::BOUNDARY || P::COUNTS => search.of(simd, i),
                _ => &[],
            };
            let near = (fluid.of(simd, i), near_boundary);
            (self.take)(k, row(self.pass, simd, self.places, i, near, &mut Computed));
        }
        ORDER.set(order);
    }
}

thread_local! {
    /// The rows of a chunk by their cells: a buffer of the thread, warm after the first step.
    static ORDER: RefCell<Vec<(IVec3, usize)>> = const { RefCell::new(Vec::new()) };
}
