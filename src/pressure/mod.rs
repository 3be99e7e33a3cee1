//! Pressure: one file a method, over the same force.
//!
//! Every method writes the pressure term `p/ρ²` beside the positions and leaves the rest to [`pressure_force`].

pub mod force;
pub mod pcisph;
pub mod state_equation;

use bevy_ecs::prelude::*;
use rayon::prelude::*;

pub use force::pressure_force;

use crate::execution::{CHUNK, ChunkResults, Execution};

/// How well the last step's pressure solve did.
#[derive(Resource, Debug, Default)]
pub struct PressureSolve {
    /// Iterations done; 0 for methods that do not iterate.
    pub iterations: u32,
    /// Density error that remains.
    pub error: DensityError,
    chunks: ChunkResults<ErrorSum>,
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
}

impl PressureSolve {
    /// Measures `densities` against the rest density, both [kg/m³].
    pub fn measure(&mut self, densities: &[f32], rest_density: f32, execution: &Execution) {
        let chunks = self.chunks.reset(densities.len());
        execution.install(|| {
            chunks
                .par_iter_mut()
                .zip(densities.par_chunks(CHUNK))
                .enumerate()
                .for_each(|(chunk, (result, densities))| {
                    for (k, rho) in densities.iter().enumerate() {
                        let error = (rho / rest_density - 1.0).max(0.0);
                        if error > result.largest {
                            (result.largest, result.row) = (error, chunk * CHUNK + k);
                        }
                        result.sum += f64::from(error);
                    }
                });
        });
        let mut total = ErrorSum::default();
        for chunk in self.chunks.iter() {
            if chunk.largest > total.largest {
                (total.largest, total.row) = (chunk.largest, chunk.row);
            }
            total.sum += chunk.sum;
        }
        self.error = DensityError {
            largest: total.largest,
            row: total.row,
            mean: (total.sum / densities.len().max(1) as f64) as f32,
        };
    }
}
