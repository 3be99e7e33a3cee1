//! The part of a picture in which a solid may be visible.

use std::ops::Range;

use glam::Vec2;

use super::projection::Projection;
use super::solid::Solid;

/// The samples in which a solid may be visible.
pub(super) struct Window {
    pub(super) columns: Range<usize>,
    pub(super) rows: Range<usize>,
}

impl Window {
    pub(super) fn new(
        projection: &Projection,
        solid: &Solid,
        (width, height): (usize, usize),
    ) -> Self {
        let corners = solid.corners().map(|corner| projection.project(corner));
        let mut window = Self {
            columns: 0..width,
            rows: 0..height,
        };
        // If a corner is behind the eye, the extent in the picture is unknown.
        if corners.iter().all(|corner| projection.sees(corner.depth)) {
            let (mut low, mut high) = (Vec2::INFINITY, Vec2::NEG_INFINITY);
            for corner in corners {
                low = low.min(corner.at);
                high = high.max(corner.at);
            }
            // The casts turn negative numbers into 0.
            window.columns = low.x as usize..(high.x.ceil() as usize).min(width);
            window.rows = low.y as usize..(high.y.ceil() as usize).min(height);
        }
        window
    }

    /// Whether a sample is in it.
    pub(super) fn contains(&self, at: Vec2) -> bool {
        self.columns.contains(&(at.x as usize)) && self.rows.contains(&(at.y as usize))
    }
}
