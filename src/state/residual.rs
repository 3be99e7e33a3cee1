//! How well a pressure solve does: density errors over all particles, summed in chunks of rows.

use bevy_ecs::prelude::*;
use glam::Vec4;
use serde::{Deserialize, Serialize};

use super::{
    execution::{ChunkResults, Execution},
    ranks::ChunkResult,
    remembered::Remembers,
};

/// How well the last step's pressure solve did.
#[derive(Resource, Debug, Default)]
pub struct SolverState {
    /// Iterations done; 0 for methods that do not iterate.
    pub(crate) iterations: u32,
    /// Iterations of the divergence solve; 0 for methods without one.
    pub(crate) divergence_iterations: u32,
    /// Whether the force of the pressure terms beside the positions is to be summed: not before the first correction of
    /// a cold start, and not where it is known.
    pub(crate) wants_force: bool,
    /// Density error that remains.
    pub(crate) error: DensityError,
    /// What a solve has to get right: the part of it that this step has to remove, and where pressures may be too high
    /// also the density that is missing in particles that have one.
    pub(crate) residual: DensityError,
    /// Whether pressures may be too high.
    two_sided: bool,
    /// How far the last iteration went along them in all.
    pub(crate) progress: f64,
    chunks: ChunkResults<(ErrorSum, ErrorSum)>,
}

/// Compression `max(0, (ρ − ρ0)/ρ0)` \[-] over all particles.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
pub struct DensityError {
    /// Largest.
    pub largest: f32,
    /// The row that has it.
    pub row: usize,
    /// Mean.
    pub mean: f32,
}

/// A step that fails before its pressure solve reports the solve of the step before.
impl Remembers for SolverState {
    type State = (u32, u32, (DensityError, DensityError), (bool, bool, f64));

    fn state(&self, _: &[Entity]) -> Self::State {
        (
            self.iterations,
            self.divergence_iterations,
            (self.error, self.residual),
            (self.wants_force, self.two_sided, self.progress),
        )
    }

    fn set_state(&mut self, state: Self::State, _: &[Entity]) -> Result<(), &'static str> {
        (self.iterations, self.divergence_iterations) = (state.0, state.1);
        (self.error, self.residual) = state.2;
        (self.wants_force, self.two_sided, self.progress) = state.3;
        Ok(())
    }
}

/// Largest error and sum of errors of one chunk of rows.
#[derive(Debug, Clone, Copy, Default, Serialize, Deserialize)]
struct ErrorSum {
    largest: f32,
    row: usize,
    sum: f64,
    progress: f64,
}

/// What a method makes of a row.
pub(crate) struct Corrected {
    /// The pressure term `p/ρ²`.
    pub(crate) term: f32,
    /// `(ρ − ρ0)/ρ0` \[-], counted if positive.
    pub(crate) error: f32,
    /// What of it the step has to remove \[-].
    pub(crate) excess: f32,
    /// How far the correction went along that, where the method wants to know.
    pub(crate) progress: f32,
}

impl SolverState {
    /// Iterations done; 0 for methods that do not iterate.
    pub fn iterations(&self) -> u32 {
        self.iterations
    }

    /// Density error that remains.
    pub fn error(&self) -> DensityError {
        self.error
    }

    /// Before the first iteration of a solve, which begins with a force if there is a pressure.
    pub(crate) fn begin(&mut self, has_pressure: bool, overshoots: bool) {
        (self.iterations, self.wants_force) = (0, has_pressure);
        self.two_sided = has_pressure || overshoots;
    }

    /// Sets the pressure term beside every position, and what the method keeps of it, and measures the errors.
    pub(crate) fn update<K: Send>(
        &mut self,
        positions: &mut [Vec4],
        kept: &mut [K],
        execution: &Execution,
        // From row, old term and what the method keeps of it.
        correct: impl Fn(usize, f32, &mut K) -> Corrected + Sync,
    ) {
        let owned = execution.owned(kept.len());
        let rows = execution.all(kept.len());
        let columns = (&mut positions[owned.clone()], &mut kept[owned.clone()]);
        let two_sided = self.two_sided;
        let chunks = self.chunks.reset(owned.len());
        execution.map_chunks(columns, chunks, |first, positions, kept| {
            let first = owned.start + first;
            let mut result = <(ErrorSum, ErrorSum)>::default();
            for (row, (position, kept)) in (first..).zip(positions.iter_mut().zip(kept)) {
                let had_pressure = position.w > 0.0;
                let corrected = correct(row, position.w, kept);
                position.w = corrected.term;
                result.0.progress += f64::from(corrected.progress);
                let compression = corrected.error.max(0.0);
                result.0.add(compression, row);
                let missed = if two_sided && had_pressure {
                    corrected.excess.abs()
                } else {
                    // What is under the limit in all may grow up to it.
                    corrected.excess.min(corrected.error).max(0.0)
                };
                result.1.add(missed, row);
            }
            result
        });
        execution.share_fourth(positions);
        execution.join(&mut self.chunks);
        let chunks = || self.chunks.iter();
        self.error = DensityError::fold(chunks().map(|chunk| chunk.0), rows);
        self.residual = DensityError::fold(chunks().map(|chunk| chunk.1), rows);
        self.progress = chunks().map(|chunk| chunk.0.progress).sum();
    }
}

impl ChunkResult for (ErrorSum, ErrorSum) {
    fn rename(&mut self, name: impl Fn(usize) -> usize) {
        self.0.row = name(self.0.row);
        self.1.row = name(self.1.row);
    }
}

impl ErrorSum {
    #[inline]
    fn add(&mut self, error: f32, row: usize) {
        if error > self.largest {
            (self.largest, self.row) = (error, row);
        }
        self.sum += f64::from(error);
    }
}

impl DensityError {
    fn fold(chunks: impl Iterator<Item = ErrorSum>, rows: usize) -> Self {
        let total = chunks.fold(ErrorSum::default(), |total, chunk| {
            let larger = if chunk.largest > total.largest {
                chunk
            } else {
                total
            };
            ErrorSum {
                sum: total.sum + chunk.sum,
                ..larger
            }
        });
        Self {
            largest: total.largest,
            row: total.row,
            mean: (total.sum / rows.max(1) as f64) as f32,
        }
    }
}

/// Whether the iteration begins with a force.
pub(crate) fn wants_force(solve: Res<SolverState>) -> bool {
    solve.wants_force
}
