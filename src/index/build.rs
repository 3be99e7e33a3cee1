//! The structure of a scene.

use glam::DVec3;

use super::{
    brute_force::BruteForce,
    compact_hashing::CompactHashing,
    domain,
    grid::Grid,
    index_sort::IndexSort,
    spatial_hashing::SpatialHashing,
    structure::SpatialIndex,
    uniform_grid::UniformGrid,
    z_index_sort::{self, ZIndexSort},
};
use crate::{
    scene::{self, IndexStructure, Scene},
    state::DomainTooLarge,
};

/// The structure of a scene.
pub fn build(scene: &Scene) -> Box<dyn SpatialIndex> {
    let scene::Index {
        structure,
        cell_size,
    } = scene.index;
    let grid = Grid::new(scene.dimension, scene.support_radius(), cell_size);
    let particles_a_cell = (cell_size * scene.support).powi(u8::from(scene.dimension).into());
    match structure {
        IndexStructure::UniformGrid => Box::new(UniformGrid::new(grid)),
        IndexStructure::IndexSort => Box::new(IndexSort::new(grid)),
        IndexStructure::ZIndexSort => Box::new(ZIndexSort::new(grid)),
        IndexStructure::SpatialHashing => Box::new(SpatialHashing::new(grid, particles_a_cell)),
        IndexStructure::CompactHashing => Box::new(CompactHashing::new(grid, particles_a_cell)),
        IndexStructure::BruteForce => Box::new(BruteForce::new(grid)),
    }
}

/// What the tables of a scene's structure take for the cells of a box, used or not [bytes]. Fails if they are too many;
/// the corners of the box are in metres.
pub(crate) fn table_bytes(scene: &Scene, low: DVec3, high: DVec3) -> Result<u64, DomainTooLarge> {
    let table_size: domain::TableSize = match scene.index.structure {
        IndexStructure::UniformGrid | IndexStructure::IndexSort => domain::unpadded,
        IndexStructure::ZIndexSort => z_index_sort::padded,
        IndexStructure::SpatialHashing
        | IndexStructure::CompactHashing
        | IndexStructure::BruteForce => return Ok(0),
    };
    let grid = Grid::new(
        scene.dimension,
        scene.support_radius(),
        scene.index.cell_size,
    );
    let cell = |corner: DVec3| grid.cell_of(corner.as_vec3().extend(0.0));
    let cells = domain::needed(&grid, cell(low), cell(high), table_size)?;
    Ok(4 * table_size(cells))
}
