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
    images::Images,
    structure::SpatialIndex,
};
use crate::{
    scene::Period,
    state::{DomainTooLarge, Execution},
};

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
        let result = self.structure.update(self.images.points(), execution);
        self.named(result)
    }

    fn rebuild(&mut self, points: &[Vec4], execution: &Execution) -> Result<(), DomainTooLarge> {
        self.images.take(points);
        let result = self.structure.rebuild(self.images.points(), execution);
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
        self.structure.bytes() + self.images.bytes()
    }
}
