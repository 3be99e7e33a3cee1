//! Geometry of a uniform grid without bounds (paper eq. 2).

use glam::{IVec3, Vec4};

use crate::{scene::Dimension, simd::Cube};

/// Cells of edge d ≤ h, counted from the origin; coordinates may be negative.
#[derive(Debug, Clone, PartialEq)]
pub struct Grid {
    /// Support radius h \[m], or the search radius of lists that are kept.
    pub support_radius: f32,
    /// Cell edge d \[m].
    pub cell_size: f64,
    inverse_size: f64,
    /// Number of cells that the support radius reaches along x, y and z.
    pub reach: IVec3,
    /// Offsets of the cells within reach of a cell, including the cell itself.
    pub neighbourhood: Vec<IVec3>,
}

/// Cells are larger than requested by this factor, so that a pair accepted by the distance test in `f32` always lies
/// within the neighbourhood despite rounding.
const SAFETY: f64 = 1.0 + 1e-6;

impl Grid {
    /// Cells of `cell_size` support radii; smaller cells increase the reach.
    pub fn new(dimension: Dimension, support_radius: f32, cell_size: f32) -> Self {
        // 1/3 in f32 is slightly more than a third, which must not add a layer of cells.
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

    /// The region whose points are certainly in `cell` by a test in `f32`: the cell without the zone at its border
    /// where rounding decides. The region is empty two million cells from the origin.
    #[inline(always)]
    pub(super) fn interior(&self, cell: IVec3) -> Cube {
        // Four rounding errors of half a unit in the last place: edge, product, centre and distance. The same amount
        // is reserved for the computation of the cell itself.
        let center = cell.as_vec3() + 0.5;
        let border = 2.0 * f32::EPSILON * (center.abs().max_element() + 2.0);
        let size = self.cell_size as f32;
        Cube {
            center: (center * size).to_array(),
            half: (0.5 - border) * size,
        }
    }

    /// The cell of a point, computed in `f64`: ten kilometres from the origin a product in `f32` is off by a hundredth
    /// of a cell. Points that are not finite get an arbitrary cell and have no neighbours.
    #[inline(always)]
    pub fn cell_of(&self, point: Vec4) -> IVec3 {
        // Explicit rounding down: without SSE 4.1, which the build target may lack, `floor` is a function call.
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
