//! Geometry of a uniform grid without bounds (paper eq. 2).

use glam::{IVec3, Vec4};

use crate::{scene::Dimension, simd::Cube};

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

    /// The points that are certainly in `cell`, by a test in `f32`: all but those so near its border that rounding
    /// might decide. Two million cells from the origin there are none.
    #[inline(always)]
    pub(super) fn interior(&self, cell: IVec3) -> Cube {
        // Four roundings of half a last place each, of the edge, the product, the centre and the distance from it; as
        // much is kept in reserve for the cell itself.
        let center = cell.as_vec3() + 0.5;
        let border = 2.0 * f32::EPSILON * (center.abs().max_element() + 2.0);
        let size = self.cell_size as f32;
        Cube {
            center: (center * size).to_array(),
            half: (0.5 - border) * size,
        }
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
