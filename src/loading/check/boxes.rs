//! Boxes that are found by their places: what lies near one of a hundred thousand is asked without going through all.

use glam::DVec3;
use rstar::primitives::{GeomWithData, Rectangle};
use rstar::{AABB, RTree};

/// Boxes by number, in an R-tree.
pub(super) struct Boxes {
    tree: RTree<GeomWithData<Rectangle<[f64; 3]>, usize>>,
    /// Those without bounds.
    endless: Vec<usize>,
}

impl Boxes {
    /// Of numbers with the corners of their boxes \[m]; none for what has no bounds.
    pub(super) fn new(boxes: Vec<(usize, Option<(DVec3, DVec3)>)>) -> Self {
        let (mut bounded, mut endless) = (Vec::new(), Vec::new());
        for (number, corners) in boxes {
            match corners {
                Some((low, high)) => {
                    let rectangle = Rectangle::from_corners(low.to_array(), high.to_array());
                    bounded.push(GeomWithData::new(rectangle, number));
                }
                None => endless.push(number),
            }
        }
        Self {
            tree: RTree::bulk_load(bounded),
            endless,
        }
    }

    /// Numbers below `end` of the boxes that a box touches, ascending.
    pub(super) fn near(&self, low: DVec3, high: DVec3, end: usize) -> Vec<usize> {
        let place = AABB::from_corners(low.to_array(), high.to_array());
        let touched = self.tree.locate_in_envelope_intersecting(place);
        let numbers = touched.map(|found| found.data);
        let endless = self.endless.iter().copied();
        let mut near: Vec<usize> = numbers
            .chain(endless)
            .filter(|&number| number < end)
            .collect();
        near.sort_unstable();
        near
    }
}
