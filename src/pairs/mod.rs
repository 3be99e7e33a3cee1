//! Sums over neighbours: the shape that every loop of the paper's Algorithms 1 and 2 has.
//!
//! A pass says what one particle adds up over its fluid and its boundary neighbours, eight at a time ([`PairSum`]);
//! [`PairsWithSlopes::sum`] runs it over all rows in parallel, with stored lists or with neighbours found on the spot.
//! The loop fetches the neighbours' positions, a third of its time, and hands a [`Pair`] to the pass: several sums in
//! one pass fetch them once. What comes out goes to takers, one a chunk of rows ([`putting`], [`adding`], [`both`]).
//! After the density pass the kernel's slopes are known, too (see [`PairSlopes`]).

mod pass;
mod rows;
mod slopes;
mod takers;

use std::ops::AddAssign;

use bevy_ecs::{prelude::*, system::SystemParam};
use glam::Vec4;
use rayon::prelude::*;

use self::slopes::Generations;
pub use self::{
    pass::{Pair, PairSum, accumulate, broadcast, difference, dot},
    rows::{Places, Source, sum},
    slopes::PairSlopes,
    takers::{adding, both, putting},
};
use crate::{
    index::{BoundarySamples, FluidIndex},
    neighbours::{BoundaryNeighbours, FluidNeighbours, Recomputed, Search},
    simd::{Simd, Vectorised},
    state::{CHUNK, Execution, Material, Positions, Rows, SENTINEL},
};

/// Neighbours of the fluid particles, stored or not, and where loops over them run.
#[derive(SystemParam)]
pub struct Pairs<'w> {
    fluid: Option<Res<'w, FluidNeighbours>>,
    boundary: Option<Res<'w, BoundaryNeighbours>>,
    samples: Option<Res<'w, BoundarySamples>>,
    index: Res<'w, FluidIndex>,
    rows: Res<'w, Rows>,
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
        let generations = self.generations();
        let slopes = self
            .slopes
            .as_deref()
            .and_then(|slopes| slopes.at(generations));
        rows::over_rows(pass, source, places, slopes, takers, &self.execution);
    }
}

impl Pairs<'_> {
    /// Positions at the start of the step, as the lists were found from.
    pub fn positions(&self) -> &Positions {
        &self.positions
    }

    /// Runs `pass` over all rows, at the positions of the step, and keeps the slopes of the pairs, unless the scene has
    /// no place for them.
    pub fn sum_and_keep<P: PairSum, T: FnMut(usize, P::Output)>(
        &self,
        pass: &P,
        slopes: Option<&mut PairSlopes>,
        takers: impl IndexedParallelIterator<Item = T>,
    ) {
        let (source, places) = (self.source(), self.places(&self.positions.0));
        match (source, slopes) {
            (Source::Stored(fluid, boundary), Some(slopes)) => {
                let lists = (fluid, boundary);
                let slopes = (slopes, self.generations());
                rows::over_rows_and_keep(pass, lists, places, slopes, takers, &self.execution);
            }
            _ => rows::over_rows(pass, source, places, None, takers, &self.execution),
        }
    }

    /// Runs `pass` with the step's neighbours at any positions, which a sentinel ends, into `out`, which has one entry
    /// a row.
    pub fn sum_at<P: PairSum>(&self, fluid: &[Vec4], pass: &P, out: &mut [P::Output]) {
        let places = self.places(fluid);
        sum(pass, self.source(), places, out, &self.execution);
    }

    /// As [`sum_at`](Self::sum_at), with walls where they are at the end of the step.
    pub fn sum_ahead<P: PairSum>(&self, fluid: &[Vec4], pass: &P, out: &mut [P::Output]) {
        let mut places = self.places(fluid);
        if let Some(samples) = &self.samples
            && !samples.ahead.is_empty()
        {
            places.boundary = &samples.ahead;
        }
        sum(pass, self.source(), places, out, &self.execution);
    }

    fn generations(&self) -> Generations {
        Generations {
            rows: self.rows.generation,
            lists: self.fluid.as_ref().map_or(0, |lists| lists.generation),
        }
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
                        Source::Recomputed(_, Some(boundary)) => {
                            execution.instruction_set.dispatch(BoundaryChunk {
                                boundary,
                                first: rows.start,
                                a,
                                b,
                                work,
                            });
                        }
                        Source::Stored(_, None) | Source::Recomputed(_, None) => {}
                    }
                });
        });
    }

    fn source(&self) -> Source<'_> {
        match &self.fluid {
            Some(fluid) => {
                Source::Stored(&fluid.lists, self.boundary.as_ref().map(|lists| &lists.0))
            }
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
                Source::Recomputed(fluid, boundary)
            }
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
        let mut boundary = Recomputed::new(self.boundary);
        for ((i, a), b) in (self.first..).zip(self.a).zip(self.b) {
            let near = boundary.of(simd, i);
            if !near.is_empty() {
                (self.work)(i, near, a, b);
            }
        }
    }
}
