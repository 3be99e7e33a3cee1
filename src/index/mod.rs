//! Spatial indices: who may be near whom (paper section 4).
//!
//! One trait, a file for each structure. An index sorts rows into cells; [`crate::neighbours`] asks it for the rows
//! of a cell and for the candidates around it, tests distances and writes lists.

mod brute_force;
mod compact_hashing;
mod grid;
pub mod z_curve;

use bevy_ecs::prelude::*;
use glam::{IVec3, Vec4};

pub use brute_force::BruteForce;
pub use compact_hashing::CompactHashing;
pub use grid::Grid;

use crate::{
    column::Positions,
    execution::Execution,
    scene::{self, IndexStructure, Scene},
    simd::Candidates,
};

/// A structure that sorts points into cells. Rows are indices into the slice of points given last.
pub trait SpatialIndex: Send + Sync + 'static {
    /// Takes over new positions. Rows may have come, gone or changed what they name.
    fn update(&mut self, points: &[Vec4], execution: &Execution);

    /// Takes over positions whose rows were put into another order: builds everything anew.
    fn rebuild(&mut self, points: &[Vec4], execution: &Execution);

    /// The cells' geometry.
    fn grid(&self) -> &Grid;

    /// Number of places that hold points.
    fn cells(&self) -> usize;

    /// Number of points in place `cell`.
    fn cell_len(&self, cell: usize) -> usize;

    /// The `from`-th point of place `cell` and those after it that lie in the same spatial cell, which comes first;
    /// `None` behind the last. A pull and no callback: the search that asks is compiled for an instruction set, and a
    /// callback would not be.
    fn group(&self, cell: usize, from: usize) -> Option<(IVec3, &[u32])>;

    /// Appends every point that lies within reach of spatial cell `center`, each once.
    fn candidates(&self, center: IVec3, points: &[Vec4], out: &mut Candidates);

    /// Memory held [bytes].
    fn bytes(&self) -> usize;
}

/// Index of the fluid particles.
#[derive(Resource)]
pub struct FluidIndex {
    /// The structure that the scene asks for.
    pub structure: Box<dyn SpatialIndex>,
    /// Whether the rows were reordered since the last update.
    pub reordered: bool,
    /// Whether the last update built everything anew.
    pub rebuilt: bool,
}

/// The structure of a scene.
pub fn build(scene: &Scene) -> Box<dyn SpatialIndex> {
    let scene::Index {
        structure,
        cell_size,
    } = scene.index;
    let grid = Grid::new(scene.dimension, scene.support_radius(), cell_size);
    match structure {
        IndexStructure::CompactHashing => {
            let particles_a_cell =
                (cell_size * scene.support).powi(u8::from(scene.dimension).into());
            Box::new(CompactHashing::new(grid, particles_a_cell))
        }
        IndexStructure::BruteForce => Box::new(BruteForce::new(grid)),
    }
}

/// Brings the index up to date with the rows (phase `RebuildIndex`).
pub fn update_index(
    mut index: ResMut<FluidIndex>,
    positions: Res<Positions>,
    execution: Res<Execution>,
) {
    index.rebuilt = std::mem::take(&mut index.reordered);
    if index.rebuilt {
        index.structure.rebuild(positions.points(), &execution);
    } else {
        index.structure.update(positions.points(), &execution);
    }
}

#[cfg(test)]
mod tests;
