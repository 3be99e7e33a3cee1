//! Order along the Z-curve (paper 4.3.1): keys by bit interleaving (Pascucci & Frank 2001). For comparison with it, the
//! order by the cells' hash.

use glam::{IVec3, Vec4};
use rayon::prelude::*;

use super::{Grid, hash::CellHash};
use crate::{
    scene::RowOrder,
    state::{CHUNK, Execution},
};

/// Bits of one coordinate in a key.
const BITS: u32 = 21;

/// Key of a cell along the Z-curve, relative to `origin`. Cells more than 2²¹ away share keys with others, which only
/// reduces locality.
#[inline]
pub fn key(cell: IVec3, origin: IVec3) -> u64 {
    let spread = |x: i32| {
        let mut v = u64::from(x as u32) & ((1 << BITS) - 1);
        v = (v | v << 32) & 0x001f_0000_0000_ffff;
        v = (v | v << 16) & 0x001f_0000_ff00_00ff;
        v = (v | v << 8) & 0x100f_00f0_0f00_f00f;
        v = (v | v << 4) & 0x10c3_0c30_c30c_30c3;
        (v | v << 2) & 0x1249_2492_4924_9249
    };
    let [x, y, z] = cell.to_array();
    let [ox, oy, oz] = origin.to_array();
    spread(x.wrapping_sub(ox)) | spread(y.wrapping_sub(oy)) << 1 | spread(z.wrapping_sub(oz)) << 2
}

/// A (cell key, row) pair, as the paper's handle.
pub type Handle = (u64, u32);

/// Hash values per point: the table of compact hashing.
const HASHES_PER_POINT: f32 = 2.0;

/// The least coordinates of the cells of points: where the curve begins.
pub fn origin(points: &[Vec4], grid: &Grid, execution: &Execution) -> IVec3 {
    let least = |least: IVec3, &point: &Vec4| least.min(grid.cell_of(point));
    let chunks = points.par_chunks(CHUNK);
    let chunks = chunks.map(|points| points.iter().fold(IVec3::MAX, least));
    execution.install(|| chunks.reduce(|| IVec3::MAX, IVec3::min))
}

/// Fills `handles` with the rows of `points` in an order of their cells; rows of one cell keep their order.
pub fn sort_handles(
    points: &[Vec4],
    (grid, by): (&Grid, RowOrder),
    execution: &Execution,
    handles: &mut Vec<Handle>,
) {
    let origin = origin(points, grid, execution);
    let hash = CellHash::for_points(points.len(), HASHES_PER_POINT);
    let key = |cell| match by {
        RowOrder::ZCurve => key(cell, origin),
        RowOrder::CellIndex => u64::from(hash.of(cell)),
    };
    sort_by(points, |point| key(grid.cell_of(point)), execution, handles);
}

/// Fills `handles` with the rows of `points` along the curve from an origin; rows of one cell keep their order.
pub(crate) fn sort_handles_from(
    points: &[Vec4],
    (grid, origin): (&Grid, IVec3),
    execution: &Execution,
    handles: &mut Vec<Handle>,
) {
    let key = |point| key(grid.cell_of(point), origin);
    sort_by(points, key, execution, handles);
}

fn sort_by(
    points: &[Vec4],
    key: impl Fn(Vec4) -> u64 + Sync,
    execution: &Execution,
    handles: &mut Vec<Handle>,
) {
    let rows = points.par_iter().enumerate();
    let keyed = rows.map(|(row, &point)| (key(point), row as u32));
    execution.install(|| {
        keyed.collect_into_vec(handles);
        if !handles.is_sorted() {
            handles.par_sort_unstable();
        }
    });
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn visits_the_cells_of_a_cube_before_those_of_the_next() {
        let order: Vec<u64> = (0..8)
            .map(|k| key(IVec3::new(k & 1, k >> 1 & 1, k >> 2), IVec3::ZERO))
            .collect();
        assert_eq!(order, [0, 1, 2, 3, 4, 5, 6, 7]);
        assert_eq!(key(IVec3::new(-4, -4, -4), IVec3::splat(-4)), 0);
        assert_eq!(key(IVec3::new(2, 0, 0), IVec3::ZERO), 8);
    }
}
