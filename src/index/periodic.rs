//! Periodic axes for every structure: points near a face are indexed once more beyond the opposite one.
//!
//! A structure knows nothing of it: it sorts points and their images, and returns both as candidates. The search lists
//! the rows that images belong to, and gives none to images. So scenes without periodic axes pay nothing, cells need
//! not divide the period, and no column has rows for images. Why not otherwise stands in
//! `docs/decisions/periodic_axes.md`.

use glam::{IVec3, Vec4};

use super::{
    entries::{Entries, Run},
    grid::Grid,
    structure::SpatialIndex,
};
use crate::{
    scene::Period,
    state::{DomainTooLarge, Execution},
};

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
    fn new(period: Period, support_radius: f32) -> Self {
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
    fn take(&mut self, points: &[Vec4]) {
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
    fn source(&self, place: u32) -> u32 {
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
}

/// A structure of points and their images.
pub(super) struct PeriodicIndex {
    structure: Box<dyn SpatialIndex>,
    images: Images,
}

impl PeriodicIndex {
    pub(super) fn new(structure: Box<dyn SpatialIndex>, period: Period) -> Self {
        let images = Images::new(period, structure.grid().support_radius);
        Self { structure, images }
    }

    fn named(&self, result: Result<(), DomainTooLarge>) -> Result<(), DomainTooLarge> {
        result.map_err(|error| DomainTooLarge {
            row: self.images.source(error.row as u32) as usize,
            ..error
        })
    }
}

impl SpatialIndex for PeriodicIndex {
    fn update(&mut self, points: &[Vec4], execution: &Execution) -> Result<(), DomainTooLarge> {
        self.images.take(points);
        let result = self.structure.update(&self.images.points, execution);
        self.named(result)
    }

    fn rebuild(&mut self, points: &[Vec4], execution: &Execution) -> Result<(), DomainTooLarge> {
        self.images.take(points);
        let result = self.structure.rebuild(&self.images.points, execution);
        self.named(result)
    }

    fn grid(&self) -> &Grid {
        self.structure.grid()
    }

    fn images(&self) -> Option<&Images> {
        Some(&self.images)
    }

    fn partitions(&self) -> usize {
        self.structure.partitions()
    }

    fn partition_len(&self, partition: usize) -> usize {
        self.structure.partition_len(partition)
    }

    fn next_cell(&self, partition: usize, from: usize) -> Option<(IVec3, &[u32])> {
        self.structure.next_cell(partition, from)
    }

    fn entries(&self) -> &Entries {
        self.structure.entries()
    }

    fn runs(&self, center: IVec3, out: &mut Vec<Run>) {
        self.structure.runs(center, out);
    }

    fn runs_around(&self, partition: usize, center: IVec3, out: &mut Vec<Run>) {
        self.structure.runs_around(partition, center, out);
    }

    fn prefetch_around(&self, partition: usize) {
        self.structure.prefetch_around(partition);
    }

    fn bytes(&self) -> usize {
        let images = &self.images;
        self.structure.bytes()
            + images.points.capacity() * size_of::<Vec4>()
            + images.sources.capacity() * size_of::<u32>()
    }
}
