//! Height and front: the extent of the largest connected part of the fluid.

use glam::Vec3;
use rayon::prelude::*;

use super::moment::{Moment, Probe};
use crate::scene::Bounds;

/// Level in a column.
pub(super) struct Height {
    pub(super) at: Vec3,
    pub(super) radius: f32,
}

impl Probe for Height {
    fn read(&self, moment: &Moment, rows: &mut Vec<u32>, values: &mut Vec<Option<f64>>) {
        let material = &moment.state.material;
        let up = (-material.gravity).try_normalize().unwrap_or(Vec3::Y);
        let (mut low, mut high) = moment.extent();
        let reach = moment.reach(self.radius);
        // A column along a coordinate axis has a tight box.
        let aside = |axis: &usize| up[*axis] == 0.0;
        if (0..3).filter(aside).count() == 2 {
            for axis in (0..3).filter(aside) {
                let at = self.at[axis];
                (low[axis], high[axis]) = (at - reach[axis], at + reach[axis]);
            }
        }
        moment.fluid().rows_in(low, high, rows);
        let places = &moment.state.places.0;
        let mut heights: Vec<f32> = rows
            .iter()
            .filter_map(|&row| {
                let offset = places[row as usize].truncate() - self.at;
                let offset = material.period.nearest(offset);
                let height = offset.dot(up);
                let aside = offset - height * up;
                (aside.length_squared() <= self.radius * self.radius).then_some(height)
            })
            .collect();
        heights.sort_unstable_by(f32::total_cmp);
        let top = end_of_largest_part(&heights, material.kernel.support_radius);
        let level = |top: f32| f64::from(top + self.at.dot(up) + 0.5 * material.spacing);
        values.push(top.map(level));
    }
}

/// The farthest point along a direction.
pub(super) struct Front {
    pub(super) from: Vec3,
    /// Unit vector.
    pub(super) direction: Vec3,
    pub(super) within: Option<Bounds>,
}

impl Probe for Front {
    fn read(&self, moment: &Moment, _: &mut Vec<u32>, values: &mut Vec<Option<f64>>) {
        let material = &moment.state.material;
        let counts = |x: &Vec3| {
            self.within
                .is_none_or(|Bounds { min, max }| x.cmpge(min).all() && x.cmple(max).all())
        };
        let along = |x: Vec3| (x - self.from).dot(self.direction);
        let places = moment.places();
        let end = moment.state.execution.install(|| {
            let ways = places.par_iter().map(|x| x.truncate()).filter(counts);
            let mut ways: Vec<f32> = ways.map(along).collect();
            ways.par_sort_unstable_by(f32::total_cmp);
            end_of_largest_part(&ways, material.kernel.support_radius)
        });
        values.push(end.map(|end| f64::from(end + 0.5 * material.spacing)));
    }
}

/// The end of the largest part of a sorted list, of the first one if several are equal. Parts are separated by more
/// than `gap`.
fn end_of_largest_part(sorted: &[f32], gap: f32) -> Option<f32> {
    let parts = sorted.chunk_by(|a, b| b - a <= gap);
    let larger = |a: &'_ [f32], b: &'_ [f32]| b.len() > a.len();
    let largest = parts.reduce(|best, part| if larger(best, part) { part } else { best });
    largest.and_then(|part| part.last().copied())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_thrown_ahead_or_left_behind_is_not_the_front() {
        let body = [0.0, 0.1, 0.2, 0.3];
        assert_eq!(end_of_largest_part(&[], 0.2), None);
        assert_eq!(end_of_largest_part(&body, 0.2), Some(0.3));
        let ahead = [&body[..], &[0.6, 0.7]].concat();
        assert_eq!(end_of_largest_part(&ahead, 0.2), Some(0.3));
        let behind = [&[-1.0, -0.9], &body[..]].concat();
        assert_eq!(end_of_largest_part(&behind, 0.2), Some(0.3));
    }
}
