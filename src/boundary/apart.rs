//! Volumes of the samples of walls that move past each other.
//!
//! Each wall is rigid: by itself its samples keep their volumes. Those that another wall is near to are summed anew.

use glam::{Vec3, Vec4};

use super::volume::VolumeRule;
use crate::{
    index::{self, BoundarySamples},
    scene::{Period, Scene},
    state::{DomainTooLarge, Execution, SENTINEL},
};

/// Walls of which each is rigid, and where one comes near to another.
#[derive(Debug, Clone)]
pub(super) struct Apart {
    rule: VolumeRule,
    /// Group of each sample: 0 for those that stand, from 1 on a course.
    groups: Vec<u32>,
    /// Volumes of the samples in the company of their own group alone \[m³; m² in 2-D].
    alone: Vec<f32>,
    /// Box around those that stand \[m].
    standing: Around,
    /// The box before anything is in it.
    nothing: Around,
    support_radius: f32,
}

/// A box \[m].
#[derive(Debug, Clone, Copy)]
struct Around {
    low: Vec3,
    high: Vec3,
}

impl Around {
    /// A box without points, but without end along periodic axes: what is beyond a face is near.
    fn nothing(period: &Period) -> Self {
        let low = Vec3::select(period.axes(), Vec3::NEG_INFINITY, Vec3::INFINITY);
        Self { low, high: -low }
    }

    fn include(&mut self, point: Vec3) {
        (self.low, self.high) = (self.low.min(point), self.high.max(point));
    }

    fn is_within(&self, point: Vec3, reach: f32) -> bool {
        point.cmpge(self.low - reach).all() && point.cmple(self.high + reach).all()
    }
}

impl Apart {
    /// From the course of each sample and its place \[m], at time 0 for those that move. None if all move as one.
    pub(super) fn new(
        scene: &Scene,
        places: &[(Option<u32>, Vec4)],
        execution: &Execution,
    ) -> Result<Option<Self>, DomainTooLarge> {
        let group = |(course, _): &(Option<u32>, Vec4)| course.map_or(0, |course| course + 1);
        let groups: Vec<u32> = places.iter().map(group).collect();
        if groups.windows(2).all(|pair| pair[0] == pair[1]) {
            return Ok(None);
        }
        let (rule, period) = (VolumeRule::new(scene), scene.period());
        let mut alone = vec![0.0; groups.len()];
        let nothing = Around::nothing(&period);
        let mut standing = nothing;
        for wanted in 0..=groups.iter().copied().max().unwrap_or_default() {
            let rows = (0..groups.len()).filter(|&row| groups[row] == wanted);
            let rows: Vec<usize> = rows.collect();
            if rows.is_empty() {
                continue;
            }
            let wrapped = |&row: &usize| period.wrap(places[row].1.truncate()).extend(0.0);
            let mut packed: Vec<Vec4> = rows.iter().map(wrapped).collect();
            let mut index = index::build(scene);
            index.rebuild(&packed, execution)?;
            packed.push(SENTINEL);
            let volumes = rule.volumes(&*index, &packed, execution);
            for (&row, volume) in rows.iter().zip(volumes) {
                alone[row] = volume;
                if wanted == 0 {
                    standing.include(places[row].1.truncate());
                }
            }
        }
        Ok(Some(Self {
            rule,
            groups,
            alone,
            standing,
            nothing,
            support_radius: scene.support_radius(),
        }))
    }

    /// Puts the volumes where the samples are. A sample that no other wall is near to has that which it has alone:
    /// volumes follow from the places alone, not from where walls were before.
    pub(super) fn put_volumes(
        &self,
        boundary: &mut BoundarySamples,
        courses: usize,
        execution: &Execution,
    ) {
        let BoundarySamples {
            packed,
            ahead,
            index,
            ..
        } = boundary;
        let mut boxes = vec![self.nothing; courses + 1];
        boxes[0] = self.standing;
        for (point, &group) in packed.iter_mut().zip(&self.groups) {
            if group > 0 {
                boxes[group as usize].include(point.truncate());
            }
        }
        let mut near = Vec::new();
        let rows = packed.iter_mut().zip(&self.groups).zip(&self.alone);
        for (row, ((point, &group), &alone)) in (0..).zip(rows) {
            point.w = alone;
            let mut others = (0..).zip(&boxes).filter(|(other, _)| *other != group);
            if others.any(|(_, other)| other.is_within(point.truncate(), self.support_radius)) {
                near.push(row);
            }
        }
        let volumes = self.rule.of_rows(&**index, packed, &near, execution);
        for (&row, volume) in near.iter().zip(volumes) {
            packed[row as usize].w = volume;
        }
        for (ahead, now) in ahead.iter_mut().zip(&*packed) {
            ahead.w = now.w;
        }
    }
}
