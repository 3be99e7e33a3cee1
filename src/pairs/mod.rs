//! Sums over neighbours: the form of every loop of the paper's Algorithms 1 and 2.
//!
//! A pass ([`PairSum`]) defines what a particle sums over its fluid and boundary neighbours, eight at a time.
//! [`PairsWithGradients::sum`] runs it over all rows in parallel, with stored lists or with recomputed neighbours. The
//! loop loads the neighbours' positions, which takes a third of its time, and passes a [`Pair`] to the pass; several
//! sums in one pass load them once. Sums go to sinks, one per chunk of rows ([`store`], [`add`], [`zip`]). After the
//! density pass the gradient factors of the kernel are stored, too (see [`KernelGradients`]).

pub(crate) mod choice;
mod gradients;
mod image;
mod pass;
mod rows;
mod sinks;

use std::ops::AddAssign;

use bevy_ecs::{prelude::*, system::SystemParam};
use glam::Vec4;
use rayon::prelude::*;

use self::{choice::OwnKernel, gradients::Generations};
pub use self::{
    gradients::KernelGradients,
    image::reaches_across,
    pass::{Pair, PairSum, accumulate, broadcast, difference, dot},
    rows::{Points, Source, sum},
    sinks::{add, store, zip},
};
use crate::{
    index::{BoundarySamples, FluidIndex},
    kernel::Kernel,
    neighbours::{BoundaryNeighbours, FluidNeighbours, Recomputed, Search},
    simd::{Simd, Vectorised},
    state::{CHUNK, Execution, Material, Positions, Rows, SENTINEL},
};

/// Neighbours of the fluid particles, stored or not, and the threads for loops over them.
#[derive(SystemParam)]
pub struct Pairs<'w> {
    fluid: Option<Res<'w, FluidNeighbours>>,
    boundary: Option<Res<'w, BoundaryNeighbours>>,
    samples: Option<Res<'w, BoundarySamples>>,
    index: Res<'w, FluidIndex>,
    rows: Res<'w, Rows>,
    positions: Res<'w, Positions>,
    material: Res<'w, Material>,
    own_kernel: Option<Res<'w, OwnKernel>>,
    /// Threads of the loops.
    pub execution: Res<'w, Execution>,
}

/// As [`Pairs`], after the density pass, which stored the gradient factors of all pairs.
#[derive(SystemParam)]
pub struct PairsWithGradients<'w> {
    pairs: Pairs<'w>,
    grad_factors: Option<Res<'w, KernelGradients>>,
}

impl<'w> std::ops::Deref for PairsWithGradients<'w> {
    type Target = Pairs<'w>;

    fn deref(&self) -> &Pairs<'w> {
        &self.pairs
    }
}

impl PairsWithGradients<'_> {
    /// Runs `pass` over all rows and stores the results in `out`, which has one entry per row.
    pub fn sum<P: PairSum>(&self, pass: &P, out: &mut [P::Output]) {
        self.sum_into(pass, store(out));
    }

    /// Runs `pass` over all rows and adds the results to `out`, which has one entry per row.
    pub fn add<P: PairSum<Output: AddAssign>>(&self, pass: &P, out: &mut [P::Output]) {
        self.sum_into(pass, add(out));
    }

    /// Runs `pass` over all rows and passes the results to `sinks`, one per chunk, each with its index in the chunk.
    pub fn sum_into<P: PairSum, T: FnMut(usize, P::Output)>(
        &self,
        pass: &P,
        sinks: impl IndexedParallelIterator<Item = T>,
    ) {
        let (source, points) = (self.source(), self.points(&self.positions.0));
        let generations = self.generations();
        let grad_factors = self
            .grad_factors
            .as_deref()
            .filter(|_| self.chosen().is_none())
            .and_then(|grad_factors| grad_factors.at(generations));
        rows::over_rows(pass, source, points, grad_factors, sinks, &self.execution);
    }
}

impl Pairs<'_> {
    /// Runs `pass` over the rows that have boundary neighbours and stores the results in `out`, which has one entry per
    /// row; the other entries stay.
    pub fn sum_beside_boundary<P: PairSum>(&self, pass: &P, out: &mut [P::Output]) {
        const { assert!(P::BESIDE_BOUNDARY) };
        sum(
            pass,
            self.source(),
            self.points(&self.positions.0),
            out,
            &self.execution,
        );
    }

    /// Positions at the start of the step, as the lists were found from.
    pub fn positions(&self) -> &Positions {
        &self.positions
    }

    /// The kernel of the sums: the scene's, or that of the stage.
    pub fn kernel(&self) -> &Kernel {
        let chosen = self.chosen();
        chosen.map_or(&self.material.kernel, |chosen| &chosen.kernel)
    }

    /// What a viscosity that is made for the scene's kernel is multiplied by \[-].
    pub(crate) fn viscosity_share(&self) -> f32 {
        self.chosen().map_or(1.0, |chosen| chosen.viscosity)
    }

    fn chosen(&self) -> Option<&choice::Chosen> {
        self.own_kernel.as_ref()?.0.as_ref()
    }

    /// Runs `pass` over all rows at the positions of the step, and stores the gradient factors of the pairs if the
    /// scene keeps them.
    pub fn sum_and_keep<P: PairSum, T: FnMut(usize, P::Output)>(
        &self,
        pass: &P,
        grad_factors: Option<&mut KernelGradients>,
        sinks: impl IndexedParallelIterator<Item = T>,
    ) {
        let (source, points) = (self.source(), self.points(&self.positions.0));
        match (source, grad_factors) {
            (Source::Stored(fluid, boundary), Some(grad_factors)) => {
                let lists = (fluid, boundary);
                let grad_factors = (grad_factors, self.generations());
                rows::over_rows_and_keep(pass, lists, points, grad_factors, sinks, &self.execution);
            }
            _ => rows::over_rows(pass, source, points, None, sinks, &self.execution),
        }
    }

    /// Runs `pass` with the step's neighbours at other positions, which end with a sentinel, and stores the results in
    /// `out`, which has one entry per row.
    pub fn sum_at<P: PairSum>(&self, fluid: &[Vec4], pass: &P, out: &mut [P::Output]) {
        let points = self.points(fluid);
        sum(pass, self.source(), points, out, &self.execution);
    }

    /// As [`sum_at`](Self::sum_at), with walls where they are at the end of the step.
    pub fn sum_ahead<P: PairSum>(&self, fluid: &[Vec4], pass: &P, out: &mut [P::Output]) {
        let mut points = self.points(fluid);
        if let Some(samples) = &self.samples
            && !samples.ahead.is_empty()
        {
            points.boundary = &samples.ahead;
        }
        sum(pass, self.source(), points, out, &self.execution);
    }

    fn generations(&self) -> Generations {
        Generations {
            rows: self.rows.generation,
            lists: self.fluid.as_ref().map_or(0, |lists| lists.generation),
        }
    }

    fn points<'a>(&'a self, fluid: &'a [Vec4]) -> Points<'a> {
        let samples = self.samples.as_ref();
        Points {
            fluid,
            boundary: samples.map_or(&[SENTINEL], |samples| &samples.packed),
            kernel: self.kernel(),
            period: self.material.period,
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

/// Rows near the boundary, whose neighbours are recomputed.
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
