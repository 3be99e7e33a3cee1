//! The box of cells that a dense structure covers (paper eq. 2): K × L × M cells around all points.

use glam::{IVec3, Vec4};
use rayon::prelude::*;

use super::Grid;
use crate::state::{CHUNK, DomainTooLarge, Execution, MAX_CELLS};

/// A box of cells.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(super) struct Domain {
    /// First cell.
    pub(super) origin: IVec3,
    /// Cells along x, y and z; zero before the first points.
    pub(super) size: [u32; 3],
}

/// Number of table entries for a box of cells; padding to powers of two can make it more than the product.
pub(super) type TableSize = fn([u64; 3]) -> u64;

/// Cells of a table without padding.
pub(super) fn unpadded([x, y, z]: [u64; 3]) -> u64 {
    x.saturating_mul(y).saturating_mul(z)
}

/// Number of cells along x, y and z between two cells. Fails if a table cannot hold them; the error's row is 0.
pub(super) fn needed(
    grid: &Grid,
    low: IVec3,
    high: IVec3,
    table_size: TableSize,
) -> Result<[u64; 3], DomainTooLarge> {
    // Cell coordinates wrap around for points that are too far away.
    let extent = |axis: usize| {
        let cells = i64::from(high[axis]) - i64::from(low[axis]) + 1;
        u64::try_from(cells).unwrap_or(u32::MAX.into())
    };
    let cells = [0, 1, 2].map(extent);
    if table_size(cells) > MAX_CELLS {
        return Err(DomainTooLarge {
            cells,
            cell_size: grid.cell_size,
            row: 0,
        });
    }
    Ok(cells)
}

impl Domain {
    /// Ensures that the box covers all finite `points`. Returns whether the box changed. A box that fits is kept
    /// unless it is eight times too large, and a new box has a margin, so that keys stay comparable between steps.
    pub(super) fn fit(
        &mut self,
        grid: &Grid,
        points: &[Vec4],
        table_size: TableSize,
        execution: &Execution,
    ) -> Result<bool, DomainTooLarge> {
        let (low, high) = bounds(points, execution);
        let (low, high) = if low.x > high.x {
            (IVec3::ZERO, IVec3::ZERO)
        } else {
            (grid.cell_of(low), grid.cell_of(high))
        };
        let needed = needed(grid, low, high, table_size).map_err(|error| DomainTooLarge {
            row: outermost(points),
            ..error
        })?;
        let covers = [low, high]
            .iter()
            .all(|&cell| self.relative(cell).is_some());
        let size = self.size.map(u64::from);
        if covers && table_size(size) / 8 <= table_size(needed) {
            return Ok(false);
        }
        // An axis with one cell, such as z in 2-D, gets no margin.
        let margin = needed.map(|cells| if cells > 1 { 2 + cells / 16 } else { 0 });
        let roomy: [u64; 3] = std::array::from_fn(|axis| needed[axis] + 2 * margin[axis]);
        let margin = if table_size(roomy) > MAX_CELLS {
            [0; 3]
        } else {
            margin
        };
        let axis = |axis: usize| low[axis].saturating_sub(margin[axis] as i32);
        self.origin = IVec3::new(axis(0), axis(1), axis(2));
        self.size = std::array::from_fn(|axis| (needed[axis] + 2 * margin[axis]) as u32);
        Ok(true)
    }

    /// Coordinates of a cell relative to the first cell, if the cell is in the box.
    #[inline]
    fn relative(&self, cell: IVec3) -> Option<[u32; 3]> {
        let relative = cell.wrapping_sub(self.origin).to_array().map(|c| c as u32);
        let inside = (0..3).all(|axis| relative[axis] < self.size[axis]);
        inside.then_some(relative)
    }

    /// As [`relative`](Self::relative), but a cell outside maps to the first cell: its points are not finite and have
    /// no neighbours.
    #[inline]
    pub(super) fn place(&self, cell: IVec3) -> [u32; 3] {
        self.relative(cell).unwrap_or_default()
    }

    /// The coordinates within `reach` of `center` along an axis, clipped to the box.
    #[inline]
    pub(super) fn span(&self, center: IVec3, reach: IVec3, axis: usize) -> std::ops::Range<u32> {
        let middle = i64::from(center[axis]) - i64::from(self.origin[axis]);
        let cut = |x: i64| x.clamp(0, i64::from(self.size[axis])) as u32;
        cut(middle - i64::from(reach[axis]))..cut(middle + i64::from(reach[axis]) + 1)
    }

    /// Row-major index of relative coordinates.
    #[inline]
    pub(super) fn row_major(&self, [x, y, z]: [u32; 3]) -> u32 {
        x + self.size[0] * (y + self.size[1] * z)
    }

    /// The cell of a row-major index.
    #[inline]
    pub(super) fn cell(&self, index: u32) -> IVec3 {
        let [width, height, _] = self.size;
        let (x, rest) = (index % width, index / width);
        let relative = IVec3::new(x as i32, (rest % height) as i32, (rest / height) as i32);
        self.origin.wrapping_add(relative)
    }
}

/// Minimum and maximum coordinates of the finite points; an empty box if there are none.
fn bounds(points: &[Vec4], execution: &Execution) -> (Vec4, Vec4) {
    let empty = (Vec4::INFINITY, Vec4::NEG_INFINITY);
    let chunk = |points: &[Vec4]| {
        points.iter().fold(empty, |(low, high), &point| {
            if point.truncate().is_finite() {
                (low.min(point), high.max(point))
            } else {
                (low, high)
            }
        })
    };
    execution.install(|| {
        points
            .par_chunks(CHUNK)
            .map(chunk)
            .reduce(|| empty, |a, b| (a.0.min(b.0), a.1.max(b.1)))
    })
}

/// The finite point farthest from the mean of all points.
fn outermost(points: &[Vec4]) -> usize {
    let finite = || {
        let points = points.iter().map(|point| point.truncate()).enumerate();
        points.filter(|(_, point)| point.is_finite())
    };
    let count = finite().count().max(1) as f64;
    let mean = finite().map(|(_, point)| point.as_dvec3() / count).sum();
    finite()
        .map(|(row, point)| (point.as_dvec3().distance(mean), row))
        .max_by(|a, b| a.0.total_cmp(&b.0))
        .map_or(0, |(_, row)| row)
}
