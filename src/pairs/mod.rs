//! Sums over neighbours: the shape that every loop of the paper's Algorithms 1 and 2 has.
//!
//! A pass says what one particle adds up over its fluid and its boundary neighbours, eight at a time ([`PairSum`]);
//! [`PairsWithSlopes::sum`] runs it over all rows in parallel, with stored lists or with neighbours found on the spot. The
//! loop fetches the neighbours' positions, a third of its time, and hands a [`Pair`] to the pass: several sums in one pass
//! fetch them once. What comes out goes to takers, one a chunk of rows ([`putting`], [`adding`], [`both`]). After the density
//! pass the kernel's slopes are known, too (see [`PairSlopes`]).

mod slopes;

use std::{
    cell::RefCell,
    ops::{AddAssign, Range},
};

use bevy_ecs::{prelude::*, system::SystemParam};
use glam::{IVec3, Vec4};
use rayon::prelude::*;

pub use self::slopes::PairSlopes;
use self::slopes::{Computed, Kept, Known, Slopes};
use crate::{
    boundary::BoundarySamples,
    column::{Positions, SENTINEL},
    execution::{CHUNK, Execution},
    index::FluidIndex,
    kernel::CubicSpline,
    material::Material,
    neighbours::{BoundaryNeighbours, FluidNeighbours, NeighbourLists, OnTheSpot, Search},
    simd::{LANES, Simd, Vectorised},
};

/// What a particle sums over its neighbours. Mark every method `#[inline(always)]`.
pub trait PairSum: Copy + Sync {
    /// Values of the particle itself and its partial sums, in lanes.
    type Sums<S: Simd>;
    /// What becomes of them.
    type Output: Send;
    /// Whether it sums over fluid neighbours.
    const FLUID: bool = true;
    /// Whether it sums over boundary neighbours. At the positions of the step their sums are known
    /// ([`WallSums`](crate::boundary::sums::WallSums)).
    const BOUNDARY: bool = false;
    /// Whether it wants to know how many neighbours there are.
    const COUNTS: bool = false;
    /// Whether slopes are all it takes of a pair. Where they are known positions are not fetched then, and the rest of the
    /// pair is zero.
    const SLOPES_ALONE: bool = false;

    /// Before the first neighbour of row `i`, which is at `own`.
    fn start<S: Simd>(&self, simd: S, i: usize, own: Vec4) -> Self::Sums<S>;
    /// Eight fluid neighbours, rows `j`; lanes without one hold a row whose sentinel adds nothing.
    #[inline(always)]
    fn fluid<S: Simd>(&self, _: S, _pair: &Pair<S>, _j: S::Rows, _: &mut Self::Sums<S>) {}
    /// Eight boundary neighbours, likewise; the fourth entries are their volumes [m³; m² in 2-D].
    #[inline(always)]
    fn boundary<S: Simd>(&self, _: S, _pair: &Pair<S>, _: &mut Self::Sums<S>) {}
    /// After the last of so many neighbours, fluid and boundary, if it counts them.
    fn finish<S: Simd>(&self, simd: S, neighbours: usize, sums: Self::Sums<S>) -> Self::Output;
}

/// Two sums in one pass.
impl<A: PairSum, B: PairSum> PairSum for (A, B) {
    type Sums<S: Simd> = (A::Sums<S>, B::Sums<S>);
    type Output = (A::Output, B::Output);
    const FLUID: bool = A::FLUID || B::FLUID;
    const BOUNDARY: bool = A::BOUNDARY || B::BOUNDARY;
    const COUNTS: bool = A::COUNTS || B::COUNTS;
    const SLOPES_ALONE: bool = A::SLOPES_ALONE && B::SLOPES_ALONE;

    #[inline(always)]
    fn start<S: Simd>(&self, simd: S, i: usize, own: Vec4) -> Self::Sums<S> {
        (self.0.start(simd, i, own), self.1.start(simd, i, own))
    }

    #[inline(always)]
    fn fluid<S: Simd>(&self, simd: S, pair: &Pair<S>, j: S::Rows, sums: &mut Self::Sums<S>) {
        self.0.fluid(simd, pair, j, &mut sums.0);
        self.1.fluid(simd, pair, j, &mut sums.1);
    }

    #[inline(always)]
    fn boundary<S: Simd>(&self, simd: S, pair: &Pair<S>, sums: &mut Self::Sums<S>) {
        self.0.boundary(simd, pair, &mut sums.0);
        self.1.boundary(simd, pair, &mut sums.1);
    }

    #[inline(always)]
    fn finish<S: Simd>(&self, simd: S, neighbours: usize, sums: Self::Sums<S>) -> Self::Output {
        (
            self.0.finish(simd, neighbours, sums.0),
            self.1.finish(simd, neighbours, sums.1),
        )
    }
}

/// A particle and eight neighbours.
#[derive(Clone, Copy)]
pub struct Pair<S: Simd> {
    /// `x_i − x_j` [m].
    pub x: [S::F; 3],
    /// Its square [m²].
    pub distance: S::F,
    /// The neighbours' fourth entries.
    pub fourth: S::F,
    /// The kernel's slope at the distance [m⁻¹].
    pub slope: S::F,
}

/// A vector in all lanes.
#[inline(always)]
pub fn broadcast<S: Simd>(simd: S, point: Vec4) -> [S::F; 3] {
    [
        simd.splat(point.x),
        simd.splat(point.y),
        simd.splat(point.z),
    ]
}

/// `own` minus the vectors of eight rows, and the rows' fourth entries.
#[inline(always)]
pub fn difference<S: Simd>(
    simd: S,
    own: [S::F; 3],
    vectors: &[Vec4],
    rows: S::Rows,
) -> ([S::F; 3], S::F) {
    let [x, y, z, fourth] = simd.gather(vectors, rows);
    let difference = [
        simd.sub(own[0], x),
        simd.sub(own[1], y),
        simd.sub(own[2], z),
    ];
    (difference, fourth)
}

#[inline(always)]
fn pair<S: Simd>(
    simd: S,
    own: [S::F; 3],
    points: &[Vec4],
    rows: S::Rows,
    (kernel, slopes): (&CubicSpline, &mut impl Slopes),
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

/// Where the particles of a pass are: fluid and boundary, each with a fourth entry and ended by a sentinel; and how far
/// they reach.
#[derive(Clone, Copy)]
pub struct Places<'a> {
    /// Positions of the fluid particles [m].
    pub fluid: &'a [Vec4],
    /// Positions [m] and volumes [m³; m² in 2-D] of the boundary particles.
    pub boundary: &'a [Vec4],
    /// The kernel whose slopes the pairs have.
    pub kernel: &'a CubicSpline,
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

/// Scalar product.
#[inline(always)]
pub fn dot<S: Simd>(simd: S, a: [S::F; 3], b: [S::F; 3]) -> S::F {
    simd.mul_add(a[2], b[2], simd.mul_add(a[1], b[1], simd.mul(a[0], b[0])))
}

/// `sum += factor · vector`.
#[inline(always)]
pub fn accumulate<S: Simd>(simd: S, sum: &mut [S::F; 3], factor: S::F, vector: [S::F; 3]) {
    for (sum, component) in sum.iter_mut().zip(vector) {
        *sum = simd.mul_add(factor, component, *sum);
    }
}

/// Neighbours of the fluid particles, stored or not, and where loops over them run.
#[derive(SystemParam)]
pub struct Pairs<'w> {
    fluid: Option<Res<'w, FluidNeighbours>>,
    boundary: Option<Res<'w, BoundaryNeighbours>>,
    samples: Option<Res<'w, BoundarySamples>>,
    index: Res<'w, FluidIndex>,
    positions: Res<'w, Positions>,
    material: Res<'w, Material>,
    /// Where loops run.
    pub execution: Res<'w, Execution>,
}

/// The same after the density pass, which left the slopes of all pairs.
#[derive(SystemParam)]
pub struct PairsWithSlopes<'w> {
    pairs: Pairs<'w>,
    slopes: Option<Res<'w, PairSlopes>>,
}

impl<'w> std::ops::Deref for PairsWithSlopes<'w> {
    type Target = Pairs<'w>;

    fn deref(&self) -> &Pairs<'w> {
        &self.pairs
    }
}

impl PairsWithSlopes<'_> {
    /// Runs `pass` over all rows into `out`, which has one entry a row.
    pub fn sum<P: PairSum>(&self, pass: &P, out: &mut [P::Output]) {
        self.sum_into(pass, putting(out));
    }

    /// Runs `pass` over all rows and adds what it gives to `out`, which has one entry a row.
    pub fn add<P: PairSum<Output: AddAssign>>(&self, pass: &P, out: &mut [P::Output]) {
        self.sum_into(pass, adding(out));
    }

    /// Runs `pass` over all rows. What it gives goes to `takers`, one a chunk of rows, with its place in the chunk.
    pub fn sum_into<P: PairSum, T: FnMut(usize, P::Output)>(
        &self,
        pass: &P,
        takers: impl IndexedParallelIterator<Item = T>,
    ) {
        let (source, places) = (self.source(), self.places(&self.positions.0));
        let slopes = self.slopes.as_deref();
        over_rows(pass, source, places, slopes, takers, &self.execution);
    }
}

impl Pairs<'_> {
    /// Positions at the start of the step, as the lists were found from.
    pub fn positions(&self) -> &Positions {
        &self.positions
    }

    /// Runs `pass` over all rows, at the positions of the step, and keeps the slopes of the pairs, unless the scene has no
    /// place for them.
    pub fn sum_and_keep<P: PairSum, T: FnMut(usize, P::Output)>(
        &self,
        pass: &P,
        slopes: Option<&mut PairSlopes>,
        takers: impl IndexedParallelIterator<Item = T>,
    ) {
        let (source, places) = (self.source(), self.places(&self.positions.0));
        let (Source::Stored(fluid, boundary), Some(slopes)) = (source, slopes) else {
            return over_rows(pass, source, places, None, takers, &self.execution);
        };
        let set = self.execution.instruction_set.arithmetic();
        debug_assert_eq!(takers.len(), places.chunks(), "a taker a chunk");
        let slopes = slopes.chunks_to_fill(places.rows());
        self.execution.install(|| {
            let chunks = takers.zip(slopes).enumerate();
            chunks.for_each(|(chunk, (take, slopes))| {
                let rows = places.chunk(chunk);
                slopes::make_room(slopes, fluid, rows.clone());
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

    /// Runs `pass` with the step's neighbours at any positions, which a sentinel ends, into `out`, which has one entry a row.
    pub fn sum_at<P: PairSum>(&self, fluid: &[Vec4], pass: &P, out: &mut [P::Output]) {
        let places = self.places(fluid);
        sum(pass, self.source(), places, out, &self.execution);
    }

    fn places<'a>(&'a self, fluid: &'a [Vec4]) -> Places<'a> {
        let samples = self.samples.as_ref();
        Places {
            fluid,
            boundary: samples.map_or(&[SENTINEL], |samples| &samples.packed),
            kernel: &self.material.kernel,
        }
    }

    /// Calls `work` with every row that has boundary neighbours, these, and the row's entries of two columns.
    pub fn update_near_boundary<A: Send, B: Send>(
        &self,
        (a, b): (&mut [A], &mut [B]),
        work: impl Fn(usize, &[u32], &mut A, &mut B) + Sync,
    ) {
        let execution = &*self.execution;
        let source = self.source();
        execution.install(|| {
            a.par_chunks_mut(CHUNK)
                .zip(b.par_chunks_mut(CHUNK))
                .enumerate()
                .for_each(|(chunk, (a, b))| {
                    let (rows, work) = (chunk * CHUNK.., &work);
                    match source {
                        Source::Stored(_, Some(boundary)) => {
                            for ((i, a), b) in rows.zip(a).zip(b) {
                                let near = boundary.of(i);
                                if !near.is_empty() {
                                    work(i, near, a, b);
                                }
                            }
                        }
                        Source::OnTheSpot(_, Some(boundary)) => {
                            execution.instruction_set.dispatch(BoundaryChunk {
                                boundary,
                                first: rows.start,
                                a,
                                b,
                                work,
                            });
                        }
                        Source::Stored(_, None) | Source::OnTheSpot(_, None) => {}
                    }
                });
        });
    }

    fn source(&self) -> Source<'_> {
        match &self.fluid {
            Some(fluid) => Source::Stored(&fluid.0, self.boundary.as_ref().map(|lists| &lists.0)),
            None => {
                let (of, points) = (&*self.index.structure, self.positions.points());
                let fluid = Search {
                    of,
                    points,
                    among: of,
                    among_points: points,
                    same: true,
                };
                let boundary = self.samples.as_ref().map(|samples| Search {
                    among: &*samples.index,
                    among_points: samples.points(),
                    same: false,
                    ..fluid
                });
                Source::OnTheSpot(fluid, boundary)
            }
        }
    }
}

/// Where a loop takes neighbours from: the fluid's, and the boundary's if there is one.
#[derive(Clone, Copy)]
pub enum Source<'a> {
    /// Lists.
    Stored(&'a NeighbourLists, Option<&'a NeighbourLists>),
    /// Searches.
    OnTheSpot(Search<'a>, Option<Search<'a>>),
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

/// Takers that put sums into a column, which has one entry a row.
pub fn putting<T: Send>(
    column: &mut [T],
) -> impl IndexedParallelIterator<Item = impl FnMut(usize, T) + Send> {
    let chunks = column.par_chunks_mut(CHUNK);
    chunks.map(|column| |k: usize, sum| column[k] = sum)
}

/// Takers that add sums to a column, which has one entry a row.
pub fn adding<T: Send + AddAssign>(
    column: &mut [T],
) -> impl IndexedParallelIterator<Item = impl FnMut(usize, T) + Send> {
    let chunks = column.par_chunks_mut(CHUNK);
    chunks.map(|column| |k: usize, sum| column[k] += sum)
}

/// Takers of the sums of two passes in one.
pub fn both<A, B>(
    first: impl IndexedParallelIterator<Item = impl FnMut(usize, A) + Send>,
    second: impl IndexedParallelIterator<Item = impl FnMut(usize, B) + Send>,
) -> impl IndexedParallelIterator<Item = impl FnMut(usize, (A, B)) + Send> {
    first.zip(second).map(|(mut first, mut second)| {
        move |k: usize, (a, b)| {
            first(k, a);
            second(k, b);
        }
    })
}

fn over_rows<P: PairSum, T: FnMut(usize, P::Output)>(
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
            Source::OnTheSpot(fluid, boundary) => {
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

/// How many rows before its turn a list is asked for; 8 and 32 do as well.
const AHEAD: usize = 16;

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
        pass.boundary(simd, &pair, &mut sums);
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

/// Rows near the boundary, found on the spot.
struct BoundaryChunk<'a, A, B, F> {
    boundary: Search<'a>,
    first: usize,
    a: &'a mut [A],
    b: &'a mut [B],
    work: &'a F,
}

impl<A, B, F: Fn(usize, &[u32], &mut A, &mut B)> Vectorised for BoundaryChunk<'_, A, B, F> {
    type Output = ();

    #[inline(always)]
    fn run<S: Simd>(self, simd: S) {
        let mut boundary = OnTheSpot::new(self.boundary);
        for ((i, a), b) in (self.first..).zip(self.a).zip(self.b) {
            let near = boundary.of(simd, i);
            if !near.is_empty() {
                (self.work)(i, near, a, b);
            }
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
        let mut fluid = OnTheSpot::new(self.fluid);
        let mut boundary = self.boundary.map(OnTheSpot::new);
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
