//! Boxes that are found by their places: what lies near one of a hundred thousand is asked without going through all.

use glam::DVec3;

use crate::mesh::Bvh;

/// Boxes by number, in a tree.
pub(super) struct Boxes {
    /// None if no box has bounds.
    tree: Option<Bvh>,
    /// Numbers and corners of the boxes of the tree \[m].
    bounded: Vec<(usize, (DVec3, DVec3))>,
    /// Those without bounds.
    endless: Vec<usize>,
}

impl Boxes {
    /// Of numbers with the corners of their boxes \[m]; none for what has no bounds.
    pub(super) fn new(boxes: Vec<(usize, Option<(DVec3, DVec3)>)>) -> Self {
        let (mut bounded, mut endless) = (Vec::new(), Vec::new());
        for (number, corners) in boxes {
            match corners {
                Some(corners) => bounded.push((number, corners)),
                None => endless.push(number),
            }
        }
        let corners: Vec<_> = bounded.iter().map(|of| of.1).collect();
        Self {
            tree: (!corners.is_empty()).then(|| Bvh::of_boxes(&corners)),
            bounded,
            endless,
        }
    }

    /// Numbers below `end` of the boxes that a box touches, ascending.
    pub(super) fn near(&self, low: DVec3, high: DVec3, end: usize) -> Vec<usize> {
        let found = self.tree.as_ref().map(|tree| tree.near(low, high));
        let found = found.unwrap_or_default().into_iter();
        let touched = found.map(|place| self.bounded[place]).filter(|of| {
            let (min, max) = of.1;
            min.cmple(high).all() && max.cmpge(low).all()
        });
        let numbers = touched.map(|of| of.0);
        let endless = self.endless.iter().copied();
        let mut near: Vec<usize> = numbers
            .chain(endless)
            .filter(|&number| number < end)
            .collect();
        near.sort_unstable();
        near
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The tree finds what a search through all boxes finds.
    #[test]
    fn boxes_are_found_as_by_going_through_all() {
        let part = |k: usize, of: f64| (of * (k as f64 + 0.5)).sin();
        let corners = |k: usize| {
            let low = DVec3::new(part(k, 1.1), part(k, 2.3), part(k, 3.7));
            let size = DVec3::new(part(k, 5.1), part(k, 6.7), part(k, 7.9)).abs();
            (low, low + 0.3 * size)
        };
        for count in [0, 1, 4, 5, 300] {
            let all: Vec<_> = (0..count)
                .map(|k| (k, (k % 7 != 3).then(|| corners(k))))
                .collect();
            let boxes = Boxes::new(all.clone());
            for asked in 0..100 {
                let (low, high) = corners(1000 + asked);
                let touches = |of: &(usize, Option<(DVec3, DVec3)>)| {
                    let (min, max) = of.1.unwrap_or((low, high));
                    of.0 < 200 && min.cmple(high).all() && max.cmpge(low).all()
                };
                let expected: Vec<usize> = (all.iter().filter(|of| touches(of)))
                    .map(|of| of.0)
                    .collect();
                assert_eq!(boxes.near(low, high, 200), expected);
            }
        }
    }
}
