//! Geometry of a uniform grid without bounds (paper eq. 2).

use glam::{IVec3, Vec4};

use crate::scene::Dimension;

/// Cells of edge d ≤ h, counted from the origin; coordinates may be negative.
#[derive(Debug, Clone, PartialEq)]
pub struct Grid {
    /// Support radius h [m].
    pub support_radius: f32,
    /// Cell edge d [m].
    pub cell_size: f64,
    inverse_size: f64,
    /// How many cells the support radius reaches along x, y and z.
    pub reach: IVec3,
    /// Cells within reach of a cell, its own included, as offsets.
    pub neighbourhood: Vec<IVec3>,
}

/// Cells are so much larger than asked for: a pair that the distance test in `f32` accepts, rounding and all, is never
/// further apart than the neighbourhood reaches.
const SAFETY: f64 = 1.0 + 1e-6;

impl Grid {
    /// Cells of `cell_size` support radii; the reach grows as they shrink.
    pub fn new(dimension: Dimension, support_radius: f32, cell_size: f32) -> Self {
        // 1/3 in f32 is a little more than a third, which must not cost another layer of cells.
        let reach = (1.0 / f64::from(cell_size) - 1e-6).ceil().max(1.0) as i32;
        let size =
            f64::from(support_radius) * f64::from(cell_size).max(1.0 / f64::from(reach)) * SAFETY;
        let depth = match dimension {
            Dimension::Two => 0,
            Dimension::Three => reach,
        };
        let neighbourhood = (-depth..=depth)
            .flat_map(|z| {
                (-reach..=reach)
                    .flat_map(move |y| (-reach..=reach).map(move |x| IVec3::new(x, y, z)))
            })
            .collect();
        Self {
            support_radius,
            cell_size: size,
            inverse_size: 1.0 / size,
            reach: IVec3::new(reach, reach, depth),
            neighbourhood,
        }
    }

    /// Whether two points are certainly in one cell. A test in `f32`; it says no near the border of a cell and
    /// 8192 cells from the origin, where the product may be off.
    #[inline(always)]
    pub(super) fn surely_alike(&self, a: Vec4, b: Vec4) -> bool {
        /// Adding and subtracting it rounds to whole numbers.
        const ROUND: Vec4 = Vec4::splat(12_582_912.0);
        const MARGIN: f32 = 1.0 / 512.0;
        let inverse_size = self.inverse_size as f32;
        let (a, b) = (a * inverse_size - 0.5, b * inverse_size - 0.5);
        let (cell_a, cell_b) = ((a + ROUND) - ROUND, (b + ROUND) - ROUND);
        let inside = |x: Vec4, cell: Vec4| (x - cell).abs().cmplt(Vec4::splat(0.5 - MARGIN));
        let alike = cell_a.cmpeq(cell_b)
            & inside(a, cell_a)
            & inside(b, cell_b)
            & a.abs().cmplt(Vec4::splat(8192.0));
        alike.bitmask() & 0b111 == 0b111
    }

    /// The cell of a point. In `f64`: ten kilometres from the origin a product in `f32` is off by a hundredth of a
    /// cell. Points that are not finite land in some cell and have no neighbours.
    #[inline(always)]
    pub fn cell_of(&self, point: Vec4) -> IVec3 {
        // Rounding down by hand: without SSE 4.1, which the build target need not have, `floor` is a call.
        let coordinate = |x: f32| {
            let scaled = f64::from(x) * self.inverse_size;
            let toward_zero = scaled as i32;
            toward_zero.wrapping_sub(i32::from(scaled < f64::from(toward_zero)))
        };
        IVec3::new(
            coordinate(point.x),
            coordinate(point.y),
            coordinate(point.z),
        )
    }
}
