//! Points spread evenly over a set of candidates: an advancing front, which packs them nearly as a lattice.
//!
//! From each accepted point the candidates just beyond the least distance are looked at, and the one that also lies
//! closest to other points is taken next. On flat and curved surfaces nearest neighbours are then 0.90 to 1.16 spacings
//! apart, 0.98 in the mean. Option 2, candidates in random order (Poisson-disk sampling), fills as completely, but has
//! its nearest neighbours anywhere between one and two times the least distance.

use std::collections::HashMap;

use glam::{IVec3, Vec3};

use super::BoundarySample;

/// Points whose normals are further apart are on two sides of a wall and do not know of each other: cosine.
const SAME_SIDE: f32 = -0.3;
/// Points whose normals are nearer face much the same way: cosine.
const FACING: f32 = 0.8;
/// Ends of the rows along two edges whose normals are further apart lie on two sides of a rim: cosine. Those of the
/// edges and corners of a block are 0.5 and nearer, those on both sides of a rim 0 along it and 0.33 at its corners.
const SAME_EDGE: f32 = 0.4;
/// How far beyond the least distance a candidate is looked at, as a part of it.
const REACH: f32 = 1.35;

/// Accepted samples, and the candidates that are left.
pub(super) struct Front {
    /// Least distance of two samples on one side \[m].
    distance: f32,
    accepted: Vec<BoundarySample>,
    cells: HashMap<IVec3, Vec<u32>>,
}

impl Front {
    pub(super) fn new(distance: f32) -> Self {
        Self {
            distance,
            accepted: Vec::new(),
            cells: HashMap::new(),
        }
    }

    pub(super) fn into_samples(self) -> Vec<BoundarySample> {
        self.accepted
    }

    fn cell(&self, point: Vec3) -> IVec3 {
        (point / (REACH * self.distance)).floor().as_ivec3()
    }

    /// Accepted samples whose normals are as near as `same`, a cosine, within `REACH` of the least distance: their
    /// distances \[m].
    fn near(&self, sample: &BoundarySample, same: f32) -> impl Iterator<Item = f32> {
        let reach = REACH * self.distance;
        around(self.cell(sample.position))
            .filter_map(|cell| self.cells.get(&cell))
            .flatten()
            .map(|&k| &self.accepted[k as usize])
            .filter(move |other| other.normal.dot(sample.normal) > same)
            .map(move |other| other.position.distance(sample.position))
            .filter(move |&distance| distance < reach)
    }

    /// Whether an accepted sample that faces the same way is within a distance of at most `REACH` \[m].
    pub(super) fn covers(&self, point: Vec3, normal: Vec3, distance: f32) -> bool {
        around(self.cell(point))
            .filter_map(|cell| self.cells.get(&cell))
            .flatten()
            .map(|&k| &self.accepted[k as usize])
            .any(|other| {
                other.normal.dot(normal) > 0.3
                    && other.position.distance_squared(point) < distance * distance
            })
    }

    pub(super) fn accept(&mut self, sample: BoundarySample) {
        let cell = self.cell(sample.position);
        let row = self.accepted.len() as u32;
        self.cells.entry(cell).or_default().push(row);
        self.accepted.push(sample);
    }

    /// Takes a sample of an edge in unless one that faces as it does is nearer than `part` of the least distance. The
    /// two edges of a rim that is little thicker than two layers lie that near, and each has a row of its own.
    pub(super) fn offer_of_edge(&mut self, sample: BoundarySample, part: f32) -> bool {
        self.offer_among(sample, part, SAME_EDGE)
    }

    /// Takes a sample in unless one of its side is nearer than nine tenths of the least distance.
    pub(super) fn offer(&mut self, sample: BoundarySample) -> bool {
        self.offer_among(sample, 0.9, SAME_SIDE)
    }

    fn offer_among(&mut self, sample: BoundarySample, part: f32, same: f32) -> bool {
        let free = (self.near(&sample, same)).all(|near| near >= part * self.distance);
        if free {
            self.accept(sample);
        }
        free
    }

    /// Whether an accepted sample faces much the same way as one and lies, along its face, within a distance of at most
    /// the least distance or a little more \[m].
    pub(super) fn speaks_for(&self, sample: &BoundarySample, distance: f32) -> bool {
        around(self.cell(sample.position))
            .filter_map(|cell| self.cells.get(&cell))
            .flatten()
            .map(|&k| &self.accepted[k as usize])
            .filter(|other| other.normal.dot(sample.normal) > FACING)
            .any(|other| {
                let offset = other.position - sample.position;
                let height = offset.dot(sample.normal);
                offset.length_squared() - height * height < distance * distance
            })
    }

    /// Fills up with candidates, starting beside what is accepted. `right` is asked before one is taken.
    pub(super) fn advance(
        &mut self,
        candidates: &[BoundarySample],
        right: impl Fn(&BoundarySample) -> bool,
    ) {
        let mut alive = vec![true; candidates.len()];
        let mut cells: HashMap<IVec3, Vec<u32>> = HashMap::new();
        for (k, candidate) in candidates.iter().enumerate() {
            let cell = self.cell(candidate.position);
            cells.entry(cell).or_default().push(k as u32);
        }
        let mut from = 0;
        let mut seed = 0;
        let mut ring = Vec::new();
        loop {
            while from < self.accepted.len() {
                let sample = self.accepted[from];
                from += 1;
                ring.clear();
                for cell in around(self.cell(sample.position)) {
                    let Some(rows) = cells.get_mut(&cell) else {
                        continue;
                    };
                    rows.retain(|&k| alive[k as usize]);
                    for &mut k in rows {
                        let candidate = &candidates[k as usize];
                        if candidate.normal.dot(sample.normal) <= SAME_SIDE {
                            continue;
                        }
                        let distance = candidate.position.distance(sample.position);
                        if distance < self.distance {
                            alive[k as usize] = false;
                        } else if distance < REACH * self.distance {
                            ring.push((k, distance));
                        }
                    }
                }
                while let Some(best) = self.best(candidates, &mut alive, &mut ring) {
                    alive[best as usize] = false;
                    let candidate = candidates[best as usize];
                    if right(&candidate) {
                        self.accept(candidate);
                    }
                }
            }
            // Nothing is left beside what is there: another part of the surface.
            while seed < candidates.len() {
                let sample = candidates[seed];
                if alive[seed] && right(&sample) && self.offer_among(sample, 1.0, SAME_SIDE) {
                    break;
                }
                seed += 1;
            }
            if seed == candidates.len() {
                return;
            }
        }
    }

    /// The candidate of a ring that lies closest to the two accepted samples nearest to it, and not too close to any;
    /// those that do leave the ring.
    fn best(
        &self,
        candidates: &[BoundarySample],
        alive: &mut [bool],
        ring: &mut Vec<(u32, f32)>,
    ) -> Option<u32> {
        let mut best: Option<(f32, u32)> = None;
        ring.retain(|&(k, distance)| {
            if !alive[k as usize] {
                return false;
            }
            let (mut first, mut second) = (f32::INFINITY, REACH * self.distance);
            for near in self.near(&candidates[k as usize], SAME_SIDE) {
                if near < first {
                    second = second.min(first);
                    first = near;
                } else {
                    second = second.min(near);
                }
            }
            if first < self.distance {
                alive[k as usize] = false;
                return false;
            }
            let cost = distance + second;
            if best.is_none_or(|best| (cost, k) < best) {
                best = Some((cost, k));
            }
            true
        });
        best.map(|(_, k)| k)
    }
}

fn around(cell: IVec3) -> impl Iterator<Item = IVec3> {
    (0..27).map(move |k| cell + IVec3::new(k % 3 - 1, k / 3 % 3 - 1, k / 9 - 1))
}
