//! Volumes of the samples of walls that move past each other.
//!
//! Each wall is rigid: by itself its samples keep their volumes. Those that another wall is near to are summed anew.

use glam::{IVec3, Vec3, Vec4};

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
    /// Where they are near; none with periodic axes, where the box has to do.
    beside: Option<Beside>,
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

/// Cells with a point in them or beside them. It may name others, never fewer: a cell is a bit of a table, found by a
/// hash. The box around a tank holds all that is in the tank, of which little is near its walls.
#[derive(Debug, Clone)]
struct Beside {
    /// Cells per length \[m⁻¹].
    per_length: f32,
    bits: Vec<u64>,
}

impl Beside {
    /// Part of the support radius that cells are longer by, for rounding.
    const SAFETY: f32 = 1e-3;

    fn new(support_radius: f32, points: impl Iterator<Item = Vec3>) -> Self {
        let per_length = 1.0 / (support_radius * (1.0 + Self::SAFETY));
        let mut cells: Vec<IVec3> = points
            .map(|x| (x * per_length).floor().as_ivec3())
            .collect();
        cells.sort_unstable_by_key(|cell| cell.to_array());
        cells.dedup();
        // Of 27 cells around each most are around others, too: one bit in eight is set at most.
        let words = (4 * cells.len()).next_power_of_two();
        let mut beside = Self {
            per_length,
            bits: vec![0; words],
        };
        let steps = || -1..=1;
        for cell in cells {
            for offset in steps().flat_map(|x| steps().map(move |y| (x, y))) {
                for z in steps() {
                    let (word, bit) = beside.place(cell + IVec3::new(offset.0, offset.1, z));
                    beside.bits[word] |= bit;
                }
            }
        }
        beside
    }

    /// Where the bit of a cell is.
    #[inline]
    fn place(&self, cell: IVec3) -> (usize, u64) {
        let [x, y, z] = cell.to_array().map(|x| x as u32 as u64);
        let mixed = x.wrapping_mul(0x9e37_79b9_7f4a_7c15)
            ^ y.wrapping_mul(0xc2b2_ae3d_27d4_eb4f)
            ^ z.wrapping_mul(0x1656_67b1_9e37_79f9);
        let hash = (mixed ^ (mixed >> 29)).wrapping_mul(0xbf58_476d_1ce4_e5b9) >> 32;
        let bit = hash as usize & (64 * self.bits.len() - 1);
        (bit / 64, 1 << (bit % 64))
    }

    #[inline]
    fn is_near(&self, point: Vec3) -> bool {
        let (word, bit) = self.place((point * self.per_length).floor().as_ivec3());
        self.bits[word] & bit != 0
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
        let stand = groups.iter().zip(places).filter(|(group, _)| **group == 0);
        let stand = stand.map(|(_, (_, place))| place.truncate());
        let beside = (!period.is_any()).then(|| Beside::new(scene.support_radius(), stand));
        Ok(Some(Self {
            rule,
            groups,
            alone,
            standing,
            beside,
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
        for (point, &alone) in packed.iter_mut().zip(&self.alone) {
            point.w = alone;
        }
        let near = self.near_others(packed, &boxes);
        let volumes = self.rule.of_rows(&**index, packed, &near, execution);
        for (&row, volume) in near.iter().zip(volumes) {
            packed[row as usize].w = volume;
        }
        for (ahead, now) in ahead.iter_mut().zip(&*packed) {
            ahead.w = now.w;
        }
    }

    /// Rows of the samples that another group may be near to.
    fn near_others(&self, packed: &[Vec4], boxes: &[Around]) -> Vec<u32> {
        let is_near = |point: Vec3, group: u32| {
            let mut others = (0..).zip(boxes).filter(|(other, _)| *other != group);
            others.any(|(other, around)| {
                around.is_within(point, self.support_radius)
                    && (other > 0
                        || self
                            .beside
                            .as_ref()
                            .is_none_or(|cells| cells.is_near(point)))
            })
        };
        let rows = (0..).zip(packed).zip(&self.groups);
        rows.filter(|&((_, point), &group)| is_near(point.truncate(), group))
            .map(|((row, _), _)| row)
            .collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A plate across a tank: every sample near a wall is found, and few others.
    #[test]
    fn those_beside_a_wall_are_found_and_few_others() {
        let grid = |n: [i32; 3], at: Vec3| {
            let points = (0..n[0]).flat_map(move |x| (0..n[1]).map(move |y| (x, y)));
            points.flat_map(move |(x, y)| {
                (0..n[2]).map(move |z| at + 0.02 * IVec3::new(x, y, z).as_vec3())
            })
        };
        let floor: Vec<Vec3> = grid([100, 1, 40], Vec3::new(-0.3, -0.01, -0.05)).collect();
        let plate: Vec<Vec3> = grid([1, 60, 40], Vec3::new(0.4, 0.013, -0.05)).collect();
        let beside = Beside::new(0.04, floor.iter().copied());
        let mut found = 0;
        for point in &plate {
            let near = floor.iter().any(|wall| wall.distance(*point) <= 0.04);
            let named = beside.is_near(*point);
            assert!(named || !near, "{point} is near");
            found += usize::from(named);
        }
        // Two rows are near; cells of two rows each name up to four, and a hash some more.
        assert!(found < plate.len() / 6, "{found} of {}", plate.len());
    }
}
