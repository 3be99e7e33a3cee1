//! A bounding volume hierarchy (tree of boxes) over triangles, or over boxes.

use glam::DVec3;

use super::triangle::Closest;

/// Triangles in a leaf at most.
const LEAF: usize = 4;

#[derive(Debug, PartialEq)]
struct Node {
    min: DVec3,
    max: DVec3,
    /// Entries of `order` below.
    first: usize,
    count: usize,
    /// The second child; the first follows its parent. 0 in a leaf.
    second: usize,
}

#[derive(Debug, PartialEq)]
pub(crate) struct Bvh {
    nodes: Vec<Node>,
    order: Vec<usize>,
}

impl Bvh {
    /// A tree over at least one triangle. Each node is split at the median triangle along the longest axis of the
    /// centres.
    pub(super) fn new(vertices: &[DVec3], triangles: &[[u32; 3]]) -> Self {
        let boxes: Vec<(DVec3, DVec3)> = triangles
            .iter()
            .map(|corners| {
                let [a, b, c] = corners.map(|corner| vertices[corner as usize]);
                (a.min(b).min(c), a.max(b).max(c))
            })
            .collect();
        Self::of_boxes(&boxes)
    }

    /// A tree over at least one box, given by its corners \[m].
    pub(crate) fn of_boxes(boxes: &[(DVec3, DVec3)]) -> Self {
        let mut tree = Self {
            nodes: Vec::with_capacity(boxes.len()),
            order: (0..boxes.len()).collect(),
        };
        tree.build(boxes, 0, boxes.len());
        tree
    }

    /// Numbers of the boxes whose leaves touch a box \[m].
    pub(crate) fn near(&self, low: DVec3, high: DVec3) -> Vec<usize> {
        let (mut found, mut waiting) = (Vec::new(), vec![0]);
        while let Some(node) = waiting.pop() {
            let here = &self.nodes[node];
            if here.min.cmpgt(high).any() || here.max.cmplt(low).any() {
                continue;
            }
            if here.second == 0 {
                found.extend(&self.order[here.first..here.first + here.count]);
            } else {
                waiting.extend([here.second, node + 1]);
            }
        }
        found
    }

    fn build(&mut self, boxes: &[(DVec3, DVec3)], first: usize, count: usize) -> usize {
        let part = &mut self.order[first..first + count];
        let (mut min, mut max) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
        let (mut low, mut high) = (min, max);
        for &triangle in &*part {
            let (a, b) = boxes[triangle];
            (min, max) = (min.min(a), max.max(b));
            (low, high) = (low.min(a + b), high.max(a + b));
        }
        let index = self.nodes.len();
        if count > LEAF {
            let axis = (high - low).max_position();
            let middle = |triangle: usize| boxes[triangle].0[axis] + boxes[triangle].1[axis];
            part.select_nth_unstable_by(count / 2, |&a, &b| {
                middle(a).total_cmp(&middle(b)).then(a.cmp(&b))
            });
        }
        self.nodes.push(Node {
            min,
            max,
            first,
            count,
            second: 0,
        });
        if count > LEAF {
            self.build(boxes, first, count / 2);
            self.nodes[index].second = self.build(boxes, first + count / 2, count - count / 2);
        }
        index
    }

    pub(super) fn bounds(&self) -> (DVec3, DVec3) {
        (self.nodes[0].min, self.nodes[0].max)
    }

    /// The triangle nearest to a point, and the nearest point on it. `closest` may exclude a triangle by returning
    /// `None`.
    pub(super) fn nearest(
        &self,
        point: DVec3,
        closest: impl Fn(usize) -> Option<Closest>,
    ) -> Option<(usize, Closest)> {
        let mut best = (f64::INFINITY, usize::MAX, None);
        self.nearest_below(0, point, &closest, &mut best);
        let (_, triangle, found) = best;
        found.map(|found| (triangle, found))
    }

    fn nearest_below(
        &self,
        node: usize,
        point: DVec3,
        closest: &impl Fn(usize) -> Option<Closest>,
        best: &mut (f64, usize, Option<Closest>),
    ) {
        let Node {
            first,
            count,
            second,
            ..
        } = self.nodes[node];
        if second == 0 {
            for &triangle in &self.order[first..first + count] {
                let Some(found) = closest(triangle) else {
                    continue;
                };
                let distance = found.at.distance_squared(point);
                if distance < best.0 || (distance == best.0 && triangle < best.1) {
                    *best = (distance, triangle, Some(found));
                }
            }
            return;
        }
        let mut children =
            [node + 1, second].map(|child| (self.nodes[child].distance(point), child));
        if children[1].0 < children[0].0 {
            children.swap(0, 1);
        }
        for (distance, child) in children {
            if distance <= best.0 {
                self.nearest_below(child, point, closest, best);
            }
        }
    }

    /// Calls `visit` with every triangle whose leaf a ray crosses up to depth `end` [lengths of `direction`].
    pub(super) fn visit(
        &self,
        origin: DVec3,
        direction: DVec3,
        end: f64,
        mut visit: impl FnMut(usize),
    ) {
        let inverse = direction.recip();
        let mut node = 0;
        let mut waiting = [0; 64];
        let mut count = 0;
        loop {
            let here = &self.nodes[node];
            if here.is_met(origin, inverse, end) {
                if here.second == 0 {
                    self.order[here.first..here.first + here.count]
                        .iter()
                        .for_each(|&triangle| visit(triangle));
                } else {
                    // Splitting at the median makes the depth of the tree the logarithm of the number of triangles.
                    waiting[count] = here.second;
                    count += 1;
                    node += 1;
                    continue;
                }
            }
            if count == 0 {
                return;
            }
            count -= 1;
            node = waiting[count];
        }
    }
}

impl Node {
    /// Square of the distance of a point \[m²].
    fn distance(&self, point: DVec3) -> f64 {
        (point - point.clamp(self.min, self.max)).length_squared()
    }

    fn is_met(&self, origin: DVec3, inverse: DVec3, end: f64) -> bool {
        let (a, b) = ((self.min - origin) * inverse, (self.max - origin) * inverse);
        let enter = a.min(b).max_element().max(0.0);
        enter <= a.max(b).min_element().min(end)
    }
}
