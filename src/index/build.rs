//! Builds the structure that a scene selects. No other place distinguishes structures.

use glam::DVec3;

use super::{
    brute_force, compact_hashing, domain,
    grid::Grid,
    index_sort,
    periodic::PeriodicIndex,
    spatial_hashing,
    structure::{SpatialIndex, Structure},
    uniform_grid, z_index_sort,
};
use crate::{
    scene::{BoundaryHandling, IndexStructure, Scene},
    state::DomainTooLarge,
};

fn row(structure: IndexStructure) -> &'static Structure {
    match structure {
        IndexStructure::UniformGrid => &uniform_grid::ROW,
        IndexStructure::IndexSort => &index_sort::ROW,
        IndexStructure::ZIndexSort => &z_index_sort::ROW,
        IndexStructure::SpatialHashing => &spatial_hashing::ROW,
        IndexStructure::CompactHashing => &compact_hashing::ROW,
        IndexStructure::BruteForce => &brute_force::ROW,
    }
}

fn grid(scene: &Scene) -> Grid {
    Grid::new(
        scene.dimension,
        scene.search_radius(),
        scene.index.cell_size,
    )
}

/// The structure of a scene's fluid.
pub fn build(scene: &Scene) -> Box<dyn SpatialIndex> {
    let dimension = i32::from(u8::from(scene.dimension));
    with_per_cell(scene, cell(scene).powi(dimension))
}

/// The structure of its walls. Samples of one layer are on surfaces: fewer in a cell than of the fluid.
pub(crate) fn build_for_walls(scene: &Scene) -> Box<dyn SpatialIndex> {
    if scene.boundary_handling() == BoundaryHandling::Layers {
        return build(scene);
    }
    let dimension = i32::from(u8::from(scene.dimension));
    with_per_cell(scene, cell(scene).powi(dimension - 1))
}

/// Edge of a cell \[spacings].
fn cell(scene: &Scene) -> f32 {
    scene.index.cell_size * scene.search_radius() / scene.spacing
}

fn with_per_cell(scene: &Scene, per_cell: f32) -> Box<dyn SpatialIndex> {
    let structure = (row(scene.index.structure).build)(grid(scene), per_cell);
    let period = scene.period();
    if period.is_any() {
        Box::new(PeriodicIndex::new(structure, period))
    } else {
        structure
    }
}

/// Memory of the structure's tables for all cells of a box, used or empty \[bytes]. The corners of the box are in
/// metres. Fails if there are too many cells.
pub(crate) fn table_bytes(scene: &Scene, low: DVec3, high: DVec3) -> Result<u64, DomainTooLarge> {
    let Some(table) = row(scene.index.structure).table else {
        return Ok(0);
    };
    let grid = grid(scene);
    let (mut low, mut high) = (low, high);
    for axis in 0..3 {
        if let Some(faces) = scene.period().faces(axis) {
            // With the images beyond both faces.
            let reach = f64::from(grid.support_radius);
            (low[axis], high[axis]) = (f64::from(faces[0]) - reach, f64::from(faces[1]) + reach);
        }
    }
    let cell = |corner: DVec3| grid.cell_of(corner.as_vec3().extend(0.0));
    let cells = domain::needed(&grid, cell(low), cell(high), table)?;
    Ok(4 * table(cells))
}

/// Memory of the structure besides these tables \[bytes per particle].
pub(crate) fn bytes_per_particle(scene: &Scene) -> f64 {
    let bytes = row(scene.index.structure).bytes_per_particle;
    let reach = 2.0 * f64::from(scene.search_radius());
    let period = scene.period();
    if !period.is_any() {
        return bytes;
    }
    // Points and images, and the row of each of these.
    let with_images: f64 = (0..3)
        .filter_map(|axis| period.faces(axis))
        .map(|[low, high]| 1.0 + reach / f64::from(high - low))
        .product();
    (bytes + 16.0) * with_images + 4.0 * (with_images - 1.0)
}
