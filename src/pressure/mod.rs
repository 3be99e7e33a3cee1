//! Pressure: one file a method, over the same force.
//!
//! Every method writes the pressure term `p/ρ²` beside the positions and leaves the rest to [`pressure_force`].

pub mod force;
pub mod pcisph;
pub mod state_equation;

use bevy_ecs::prelude::*;

pub use force::pressure_force;

use crate::{
    column::{Positions, Pressures},
    execution::{ChunkResults, Execution},
};

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
    /// Sets the pressure [Pa] and the pressure term of every row from its density [kg/m³], and measures the densities
    /// against the rest density.
    fn update(
        &mut self,
        densities: &[f32],
        pressures: &mut Pressures,
        positions: &mut Positions,
        rest_density: f32,
        execution: &Execution,
        // From row, density and old pressure to pressure and pressure term.
        new_pressure: impl Fn(usize, f32, f32) -> (f32, f32) + Sync,
    ) {
        let rows = densities.len();
        let columns = (&mut positions.0[..rows], &mut pressures.0[..rows]);
        let chunks = self.chunks.reset(rows);
        execution.map_chunks(columns, chunks, |first, positions, pressures| {
            let mut result = ErrorSum::default();
            let columns = positions.iter_mut().zip(pressures).zip(&densities[first..]);
            for (row, ((position, pressure), &rho)) in (first..).zip(columns) {
                (*pressure, position.w) = new_pressure(row, rho, *pressure);
                let error = (rho / rest_density - 1.0).max(0.0);
                if error > result.largest {
                    (result.largest, result.row) = (error, row);
                }
                result.sum += f64::from(error);
            }
            result
        });
        let total = self
            .chunks
            .iter()
            .fold(ErrorSum::default(), |total, chunk| {
                let larger = if chunk.largest > total.largest {
                    chunk
                } else {
                    &total
                };
                ErrorSum {
                    sum: total.sum + chunk.sum,
                    ..*larger
                }
            });
        self.error = DensityError {
            largest: total.largest,
            row: total.row,
            mean: (total.sum / rows.max(1) as f64) as f32,
        };
    }
}
