//! Walls that go round a periodic axis: rows of samples that meet their own images at the spacing.

use glam::Vec3;

use crate::scene::Period;

/// Samples along an axis.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Row {
    /// Coordinate of the first \[m].
    pub(super) first: f32,
    /// Distance between two \[m].
    pub(super) step: f32,
    pub(super) count: i32,
}

/// The rows of a wall that reaches from `low` to `high` \[m], along each axis that it goes round.
pub(super) fn rows(period: &Period, low: Vec3, high: Vec3, spacing: f32) -> [Option<Row>; 3] {
    let round = period.goes_round(low, high);
    [0, 1, 2].map(|axis| {
        let [first, last] = period.faces(axis).filter(|_| round.test(axis))?;
        let length = last - first;
        let count = (length / spacing - 1e-3).ceil().max(1.0);
        let step = length / count;
        Some(Row {
            first: first + 0.5 * step,
            step,
            count: count as i32,
        })
    })
}

/// The row of a straight line through `center` along the unit vector `along` that ends `half_size` \[m] from it, as
/// distances from the center; none if it goes round no axis.
pub(super) fn along(
    period: &Period,
    (center, along, half_size): (Vec3, Vec3, f32),
    spacing: f32,
) -> Option<Row> {
    let reach = half_size * along.abs();
    let rows = rows(period, center - reach, center + reach, spacing);
    let axis = (0..3).find(|&axis| rows[axis].is_some())?;
    let row = rows[axis]?;
    let (from, sign) = (row.first - center[axis], along[axis].signum());
    Some(Row {
        first: sign * from,
        step: sign * row.step,
        ..row
    })
}
