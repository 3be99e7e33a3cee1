//! Pressure: one file a method, over the same force.
//!
//! Every method writes the pressure term `p/ρ²` beside the positions and leaves the rest to [`pressure_force`]. Those
//! that iterate do so in [`solve`], from what [`warm_start`] gives them; [`implicit`] is what the two have in common
//! whose densities are predicted from velocities, and [`response`] how strongly a particle answers its own pressure.
//! The first force may come along with viscosity ([`first_force`]). [`recovery`] says how much of the compression that
//! a step finds it removes, and [`initial`] what the first step starts from.
//!
//! | method | file | solves for | iterates over |
//! | --- | --- | --- | --- |
//! | SESPH | [`state_equation`] | nothing: pressure is a function of density | – |
//! | PCISPH | [`pcisph`] | densities at predicted positions | one stiffness, a full lattice's |
//! | IISPH | [`iisph`] | densities predicted from velocities | every particle's own stiffness |
//! | DFSPH | [`dfsph`] | no compression in the velocities, then as IISPH | as IISPH |

pub mod dfsph;
pub mod first_force;
pub mod fluid_share;
pub mod force;
pub mod iisph;
pub mod implicit;
pub mod initial;
pub mod pcisph;
pub mod recovery;
pub mod response;
pub mod solve;
pub mod state_equation;
pub mod warm_start;

use bevy_ecs::prelude::*;

use glam::Vec4;

pub use force::pressure_force;

use crate::state::{ChunkResults, Execution, Material};

/// How well the last step's pressure solve did.
#[derive(Resource, Debug, Default)]
pub struct PressureSolve {
    /// Iterations done; 0 for methods that do not iterate.
    pub iterations: u32,
    /// Iterations of the divergence solve; 0 for methods without one.
    pub divergence_iterations: u32,
    /// Whether the force of the pressure terms beside the positions is to be summed: not before the first correction of
    /// a cold start, and not where it is known.
    wants_force: bool,
    /// Density error that remains.
    pub error: DensityError,
    /// What a solve has to get right: the part of it that this step has to remove, and where pressures may be too high
    /// also the density that is missing in particles that have one.
    residual: DensityError,
    /// Whether pressures may be too high.
    both_ways: bool,
    /// How far the last iteration went along them in all.
    progress: f64,
    chunks: ChunkResults<(ErrorSum, ErrorSum)>,
}

/// Compression `max(0, (ρ − ρ0)/ρ0)` [-] over all particles.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct DensityError {
    /// Largest.
    pub largest: f32,
    /// The row that has it.
    pub row: usize,
    /// Mean.
    pub mean: f32,
}

/// Largest error and sum of errors of one chunk of rows.
#[derive(Debug, Clone, Copy, Default)]
struct ErrorSum {
    largest: f32,
    row: usize,
    sum: f64,
    progress: f64,
}

/// What a method makes of a row.
struct Corrected {
    /// The pressure term `p/ρ²`.
    term: f32,
    /// `(ρ − ρ0)/ρ0` [-], counted if positive.
    error: f32,
    /// What of it the step has to remove [-].
    excess: f32,
    /// How far the correction went along that, where the method wants to know.
    progress: f32,
}

/// `|Σ_j ∇W_ij|² + Σ_j |∇W_ij|²` of a particle in a full lattice.
fn lattice_response(material: &Material) -> f64 {
    let gradients = || {
        let lattice = material
            .kernel
            .lattice(material.dimension, material.spacing);
        lattice.map(|x| material.kernel.gradient(x).as_dvec3())
    };
    let sum: glam::DVec3 = gradients().sum();
    let squares: f64 = gradients().map(|gradient| gradient.length_squared()).sum();
    sum.length_squared() + squares
}

impl PressureSolve {
    /// Before the first iteration of a solve, which begins with a force if there is a pressure.
    fn begin(&mut self, has_pressure: bool, overshoots: bool) {
        (self.iterations, self.wants_force) = (0, has_pressure);
        self.both_ways = has_pressure || overshoots;
    }

    /// Sets the pressure term beside every position, and what the method keeps of it, and measures the errors.
    fn update<K: Send>(
        &mut self,
        positions: &mut [Vec4],
        kept: &mut [K],
        execution: &Execution,
        // From row, old term and what the method keeps of it.
        correct: impl Fn(usize, f32, &mut K) -> Corrected + Sync,
    ) {
        let rows = kept.len();
        let columns = (&mut positions[..rows], kept);
        let both_ways = self.both_ways;
        let chunks = self.chunks.reset(rows);
        execution.map_chunks(columns, chunks, |first, positions, kept| {
            let mut result = <(ErrorSum, ErrorSum)>::default();
            for (row, (position, kept)) in (first..).zip(positions.iter_mut().zip(kept)) {
                let had_pressure = position.w > 0.0;
                let corrected = correct(row, position.w, kept);
                position.w = corrected.term;
                result.0.progress += f64::from(corrected.progress);
                let compression = corrected.error.max(0.0);
                result.0.add(compression, row);
                let missed = if both_ways && had_pressure {
                    corrected.excess.abs()
                } else {
                    // What is under the limit in all may grow up to it.
                    corrected.excess.min(corrected.error).max(0.0)
                };
                result.1.add(missed, row);
            }
            result
        });
        let chunks = || self.chunks.iter();
        self.error = DensityError::fold(chunks().map(|chunk| chunk.0), rows);
        self.residual = DensityError::fold(chunks().map(|chunk| chunk.1), rows);
        self.progress = chunks().map(|chunk| chunk.0.progress).sum();
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
