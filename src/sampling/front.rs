//! Distributes points evenly over a set of candidates: an advancing front, which packs them nearly as a lattice.
//!
//! The front looks at candidates slightly beyond the least distance from each accepted point, and accepts the one that
//! is also closest to other points. On flat and curved surfaces nearest neighbours are then 0.90 to 1.16 spacings
//! apart, 0.98 on average. Option 2, candidates in random order (Poisson-disk sampling), covers as completely, but its
//! nearest neighbours lie anywhere between one and two least distances.

use std::collections::HashMap;

use glam::{IVec3, Vec3};

use super::BoundarySample;

/// Samples whose normals differ more lie on two sides of a wall and ignore each other: cosine.
const SAME_SIDE: f32 = -0.3;
/// Samples whose normals differ less face approximately the same way: cosine.
const FACING: f32 = 0.8;
/// If their normals differ more, the ends of the rows along two edges lie on two sides of a rim: cosine. It is at least
/// 0.5 for the edges and corners of a block; for the two sides of a rim it is 0 along the rim and 0.33 at its corners.
const SAME_EDGE: f32 = 0.4;
/// Largest distance of candidates that are considered \[least distances].
const REACH: f32 = 1.35;

/// Accepted samples, and the remaining candidates.
pub(super) struct Front {
    /// Least distance between two samples on one side \[m].
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

    /// Distances \[m] of the accepted samples within `REACH` least distances whose normals differ by at most `same`, a
    /// cosine.
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

    /// Whether an accepted sample that faces the same way is within `distance`, at most `REACH` \[m].
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

    /// Accepts a sample of an edge unless a sample that faces as it does is closer than `part` of the least distance.
    /// The two edges of a rim little thicker than two layers are that close to each other, and each has a row of its
    /// own.
    pub(super) fn offer_of_edge(&mut self, sample: BoundarySample, part: f32) -> bool {
        self.offer_among(sample, part, SAME_EDGE)
    }

    /// Accepts a sample unless a sample of its side is closer than 0.9 least distances.
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

    /// Whether an accepted sample faces approximately the same way and is within `distance`, measured along its face:
    /// at most slightly more than the least distance \[m].
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

    /// Fills the surface with candidates, starting beside the accepted samples. `right` must approve each of them.
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
            // No candidate is left beside the accepted samples: continue on another part of the surface.
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

    /// The candidate of a ring that is closest to its two nearest accepted samples and not too close to any. Those that
    /// are too close are removed from the ring.
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
