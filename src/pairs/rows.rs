//! The parallel loop over all rows, with stored lists or with recomputed neighbours.

use std::{cell::RefCell, ops::Range};

use glam::{IVec3, Vec4};
use rayon::prelude::*;

use super::{
    KernelGradients, Pair, PairSum, broadcast, difference, dot,
    gradients::{Computed, Generations, GradFactors, Kept, Known, make_room},
    image::{Image, Open, Space},
    store,
};
use crate::{
    kernel::Kernel,
    neighbours::{NeighbourLists, Recomputed, Search},
    scene::Period,
    simd::{LANES, Simd, Vectorised},
    state::{CHUNK, Execution},
};

/// Positions of a pass: fluid and boundary, each with a fourth entry and ended by a sentinel; and the kernel.
#[derive(Clone, Copy)]
pub struct Points<'a> {
    /// Positions of the fluid particles \[m].
    pub fluid: &'a [Vec4],
    /// Positions \[m] and volumes \[m³; m² in 2-D] of the boundary particles.
    pub boundary: &'a [Vec4],
    /// The kernel of the pairs.
    pub kernel: &'a Kernel,
    /// The box that repeats.
    pub period: Period,
}

impl Points<'_> {
    /// Number of rows of the fluid.
    fn rows(&self) -> usize {
        self.fluid.len().saturating_sub(1)
    }

    /// Number of chunks.
    fn chunks(&self) -> usize {
        self.rows().div_ceil(CHUNK)
    }

    /// The rows of a chunk.
    fn chunk(&self, chunk: usize) -> Range<usize> {
        let first = chunk * CHUNK;
        first..self.rows().min(first + CHUNK)
    }
}

/// Source of the neighbours of a loop: in the fluid, and in the boundary if there is one.
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
    points: Points,
    out: &mut [P::Output],
    execution: &Execution,
) {
    over_rows(pass, source, points, None, store(out), execution);
}

/// Runs `pass` over all rows and passes its results to `sinks`.
pub(super) fn over_rows<P: PairSum, T: FnMut(usize, P::Output)>(
    pass: &P,
    source: Source,
    points: Points,
    grad_factors: Option<&KernelGradients>,
    sinks: impl IndexedParallelIterator<Item = T>,
    execution: &Execution,
) {
    debug_assert_eq!(sinks.len(), points.chunks(), "one sink per chunk");
    let set = execution.instruction_set;
    let work = |(chunk, take)| {
        let rows = points.chunk(chunk);
        match source {
            Source::Stored(fluid, boundary) => {
                let chunk = StoredChunk {
                    pass,
                    points,
                    fluid,
                    boundary,
                    grad_factors: Computed,
                    rows,
                    take,
                };
                match grad_factors.and_then(|grad_factors| grad_factors.chunk(chunk.rows.start)) {
                    Some(grad_factors) => set
                        .arithmetic()
                        .dispatch(chunk.with(Known(grad_factors.iter()))),
                    None => set.arithmetic().dispatch(chunk),
                }
            }
            Source::Recomputed(fluid, boundary) => {
                set.dispatch(RecomputedChunk {
                    pass,
                    points,
                    fluid,
                    boundary,
                    rows,
                    take,
                });
            }
        }
    };
    execution.install(|| sinks.enumerate().for_each(work));
}

/// As [`over_rows`] with lists; also stores the gradient factors of the pairs.
pub(super) fn over_rows_and_keep<P: PairSum, T: FnMut(usize, P::Output)>(
    pass: &P,
    (fluid, boundary): (&NeighbourLists, Option<&NeighbourLists>),
    points: Points,
    (grad_factors, generations): (&mut KernelGradients, Generations),
    sinks: impl IndexedParallelIterator<Item = T>,
    execution: &Execution,
) {
    debug_assert_eq!(sinks.len(), points.chunks(), "one sink per chunk");
    let set = execution.instruction_set.arithmetic();
    let grad_factors = grad_factors.chunks_to_fill(points.rows(), generations);
    execution.install(|| {
        let chunks = sinks.zip(grad_factors).enumerate();
        chunks.for_each(|(chunk, (take, grad_factors))| {
            let rows = points.chunk(chunk);
            make_room(grad_factors, fluid, rows.clone());
            set.dispatch(StoredChunk {
                pass,
                points,
                fluid,
                boundary,
                grad_factors: Kept(grad_factors.iter_mut()),
                rows,
                take,
            });
        });
    });
}

/// Rows by which the prefetch of lists is ahead of the loop; 8 and 32 are as good.
const AHEAD: usize = 16;

#[inline(always)]
fn pair<S: Simd>(
    simd: S,
    own: [S::F; 3],
    points: &[Vec4],
    rows: S::Rows,
    space: &impl Space<S>,
    (kernel, grad_factors): (&Kernel, &mut impl GradFactors),
) -> Pair<S> {
    let (x_ij, packed_j) = difference(simd, own, points, rows);
    let x_ij = space.nearest(simd, x_ij);
    let r2 = dot(simd, x_ij, x_ij);
    Pair {
        x_ij,
        r2,
        packed_j,
        grad_factor: grad_factors.next(simd, kernel, r2),
    }
}

/// One row of a pass. Rows without images have a loop of their own: a choice within costs a density pass a tenth.
#[inline(always)]
fn row<P: PairSum, S: Simd, L: GradFactors>(
    pass: &P,
    simd: S,
    points: Points,
    i: usize,
    lists: (&[u32], &[u32]),
    grad_factors: &mut L,
) -> P::Output {
    let support_radius = points.kernel.support_radius;
    match Image::of(simd, &points.period, support_radius, points.fluid[i]) {
        None => row_in(pass, simd, points, i, lists, (&Open, grad_factors)),
        Some(image) => row_in(pass, simd, points, i, lists, (&image, grad_factors)),
    }
}

/// A loop over whole vectors, the last one padded with absent rows.
#[inline(always)]
fn row_in<P: PairSum, S: Simd, L: GradFactors, N: Space<S>>(
    pass: &P,
    simd: S,
    points: Points,
    i: usize,
    (mut fluid, mut boundary): (&[u32], &[u32]),
    (space, grad_factors): (&N, &mut L),
) -> P::Output {
    let neighbours = fluid.len() + boundary.len();
    let mut sums = pass.start(simd, i, points.fluid[i]);
    let own = broadcast(simd, points.fluid[i]);
    while P::FLUID && !fluid.is_empty() {
        let rows = simd.rows(fluid);
        let pair = if P::GRADIENTS_ONLY && L::KNOWN && !N::REPEATS {
            let zero = simd.splat(0.0);
            Pair {
                x_ij: [zero; 3],
                r2: zero,
                packed_j: zero,
                grad_factor: grad_factors.next(simd, points.kernel, zero),
            }
        } else {
            let grad_factors = (points.kernel, &mut *grad_factors);
            pair(simd, own, points.fluid, rows, space, grad_factors)
        };
        pass.fluid(simd, &pair, rows, &mut sums);
        fluid = fluid.get(LANES..).unwrap_or_default();
    }
    while P::BOUNDARY && !boundary.is_empty() {
        let rows = simd.rows(boundary);
        let grad_factors = (points.kernel, &mut Computed);
        let pair = pair(simd, own, points.boundary, rows, space, grad_factors);
        pass.boundary(simd, &pair, rows, &mut sums);
        boundary = boundary.get(LANES..).unwrap_or_default();
    }
    pass.finish(simd, neighbours, sums)
}

/// Whether a pass has to know the boundary neighbours of a row.
const fn needs_boundary<P: PairSum>() -> bool {
    P::BOUNDARY || P::COUNTS || P::BESIDE_BOUNDARY
}

struct StoredChunk<'a, P, L, T> {
    pass: &'a P,
    points: Points<'a>,
    fluid: &'a NeighbourLists,
    boundary: Option<&'a NeighbourLists>,
    grad_factors: L,
    rows: Range<usize>,
    take: T,
}

impl<'a, P, L, T> StoredChunk<'a, P, L, T> {
    fn with<M>(self, grad_factors: M) -> StoredChunk<'a, P, M, T> {
        StoredChunk {
            pass: self.pass,
            points: self.points,
            fluid: self.fluid,
            boundary: self.boundary,
            grad_factors,
            rows: self.rows,
            take: self.take,
        }
    }
}

impl<P: PairSum, L: GradFactors, T: FnMut(usize, P::Output)> Vectorised
    for StoredChunk<'_, P, L, T>
{
    type Output = ();

    #[inline(always)]
    fn run<S: Simd>(mut self, simd: S) {
        // Copies of its own, so that their fields stay in registers.
        let pass = *self.pass;
        let kernel = *self.points.kernel;
        let points = Points {
            kernel: &kernel,
            ..self.points
        };
        let mut grad_factors = self.grad_factors;
        for (k, i) in self.rows.enumerate() {
            let boundary = match self.boundary {
                Some(lists) if needs_boundary::<P>() => lists.of(i),
                _ => &[],
            };
            if P::BESIDE_BOUNDARY && boundary.is_empty() {
                continue;
            }
            if P::FLUID {
                self.fluid.prefetch(i + AHEAD);
            }
            let lists = (self.fluid.of(i), boundary);
            (self.take)(k, row(&pass, simd, points, i, lists, &mut grad_factors));
        }
    }
}

struct RecomputedChunk<'a, P, T> {
    pass: &'a P,
    points: Points<'a>,
    fluid: Search<'a>,
    boundary: Option<Search<'a>>,
    rows: Range<usize>,
    take: T,
}

impl<P: PairSum, T: FnMut(usize, P::Output)> Vectorised for RecomputedChunk<'_, P, T> {
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
                Some(search) if needs_boundary::<P>() => search.of(simd, i),
                _ => &[],
            };
            if P::BESIDE_BOUNDARY && near_boundary.is_empty() {
                continue;
            }
            let near = (fluid.of(simd, i), near_boundary);
            (self.take)(k, row(self.pass, simd, self.points, i, near, &mut Computed));
        }
        ORDER.set(order);
    }
}

thread_local! {
    /// The rows of a chunk by their cells: a buffer of the thread, warm after the first step.
    static ORDER: RefCell<Vec<(IVec3, usize)>> = const { RefCell::new(Vec::new()) };
}
