//! Points near the faces of periodic axes, once more beyond the opposite ones.

use glam::Vec4;

use crate::scene::Period;

/// Points are indexed beyond a face up to a little more than the support radius, for rounding.
const SAFETY: f32 = 1.0 + 1e-4;

/// Points, and behind them their images beyond the faces.
#[derive(Debug)]
pub struct Images {
    /// The box that repeats.
    pub(crate) period: Period,
    /// Depth of the layer of images \[m].
    reach: f32,
    points: Vec<Vec4>,
    /// Rows that the images belong to.
    sources: Vec<u32>,
    rows: u32,
}

impl Images {
    pub(crate) fn new(period: Period, support_radius: f32) -> Self {
        Self {
            period,
            reach: SAFETY * support_radius,
            points: Vec::new(),
            sources: Vec::new(),
            rows: 0,
        }
    }

    /// Takes points in the box that repeats, and adds their images: axis after axis, so that those in edges and corners
    /// have theirs.
    pub(crate) fn take(&mut self, points: &[Vec4]) {
        self.points.clear();
        self.points.extend_from_slice(points);
        self.sources.clear();
        self.rows = points.len() as u32;
        for axis in 0..3 {
            let Some([low, high]) = self.period.faces(axis) else {
                continue;
            };
            let length = self.period.length[axis];
            for place in 0..self.points.len() {
                let point = self.points[place];
                let shift = if point[axis] < low + self.reach {
                    length
                } else if point[axis] > high - self.reach {
                    -length
                } else {
                    continue;
                };
                let mut image = point;
                image[axis] += shift;
                self.points.push(image);
                self.sources.push(self.source(place as u32));
            }
        }
    }

    /// All points with their images.
    pub(crate) fn points(&self) -> &[Vec4] {
        &self.points
    }

    /// The row of a point or of what it is the image of.
    #[inline]
    pub(crate) fn source(&self, place: u32) -> u32 {
        match place.checked_sub(self.rows) {
            Some(image) => self.sources[image as usize],
            None => place,
        }
    }

    /// Puts the rows of what they belong to in the place of images.
    #[inline]
    pub(crate) fn resolve(&self, places: &mut [u32]) {
        for place in places {
            *place = self.source(*place);
        }
    }

    /// Memory held \[bytes].
    pub(super) fn bytes(&self) -> usize {
        self.points.capacity() * size_of::<Vec4>() + self.sources.capacity() * size_of::<u32>()
    }
}
