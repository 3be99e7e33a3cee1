//! Contact, the last resort at a wall: no particle passes the layer of samples.
//!
//! Pressure keeps the fluid away from a wall, but an isolated particle has no pressure there: its density, wall
//! included, is below the rest density until it lies in the wall, so spray would leak. After integration a particle
//! that is more than [`PENETRATION`] behind the face of a wall, where fluid under pressure does not get, is therefore
//! moved back along the normal and loses its velocity into the wall; the velocity along the wall stays. A moving wall
//! acts from its position at the end of the step and gives the particle its own velocity along the normal. A sample
//! acts on the particles within [`SIDEWAYS`] of it, measured along the face, that were in front of it at the start of
//! the step. Those behind it are on the other side of a thin wall, and it would pull them through.

use bevy_ecs::prelude::*;
use glam::{Mat3, Vec3, Vec4};
use smallvec::SmallVec;

use crate::{
    index::BoundarySamples,
    pairs::Pairs,
    scene::Period,
    state::{Material, PredictedPositions, Velocities},
};

/// Largest distance of a particle behind the face of a wall \[spacings].
const PENETRATION: f32 = 0.25;
/// Distance along the face up to which a sample acts \[spacings]. The centre of four samples is 0.71 from them, the
/// last row of a face beside a tank's edge 0.83. The second row around a convex edge must not act on the other side;
/// its distance is at least 1.2.
const SIDEWAYS: f32 = 1.15;
/// Distance along the face up to which a sample acts between itself and a concave edge of its face \[spacings]. Where
/// two faces meet in an acute angle, the samples of their edge lie far behind it, and the next of a face up to 1.5 from
/// them.
const TO_EDGE: f32 = 2.0;
/// Largest number of samples that act on one particle: three faces meet in a corner, and samples in its edges have
/// normals between theirs.
const CORRECTIONS: usize = 8;
/// Tolerated distance of a particle behind a face \[spacings].
const ROUNDING: f32 = 1e-4;

/// Moves particles that are too close to a wall back (phase `Integrate`).
///
/// In a corner the faces act together: the particle moves to the nearest position in front of all of them. One face
/// after the other would move it from side to side in an acute corner and leave it behind the last one. If there is no
/// such position, the particle returns to where it was at the start of the step.
pub fn keep_outside(
    mut predicted: ResMut<PredictedPositions>,
    mut velocities: ResMut<Velocities>,
    boundary: Res<BoundarySamples>,
    material: Res<Material>,
    pairs: Pairs,
) {
    let rows = pairs.positions().rows();
    let wall = Wall {
        clearance: boundary.layer_depth - PENETRATION * material.spacing,
        boundary: &boundary,
        spacing: material.spacing,
        period: material.period,
    };
    let columns = (&mut predicted.0[..rows], &mut velocities.0[..rows]);
    let start = &pairs.positions().0;
    pairs.update_near_boundary(columns, |row, samples, position, velocity| {
        wall.keep_outside(start[row].truncate(), samples, position, velocity)
    });
}

struct Wall<'a> {
    boundary: &'a BoundarySamples,
    /// Smallest distance from the layer of samples \[m].
    clearance: f32,
    spacing: f32,
    period: Period,
}

impl Wall<'_> {
    fn keep_outside(&self, start: Vec3, samples: &[u32], position: &mut Vec4, velocity: &mut Vec4) {
        let wished = position.truncate();
        let mut faces: SmallVec<[Face; CORRECTIONS]> = SmallVec::new();
        let mut way = Vec3::ZERO;
        // The wall that it is deepest in, at first: where that carries what it holds, and how fast.
        let (mut back, mut carried) = (start, Vec3::ZERO);
        while let Some((depth, sample)) = self.deepest(start, samples, wished + way) {
            let normal = self.boundary.normals[sample];
            let velocity_of_wall = self.boundary.velocity(sample);
            if faces.is_empty() {
                let place = self.boundary.packed[sample].truncate();
                back = start
                    + self
                        .period
                        .nearest(self.boundary.place_ahead(sample) - place);
                carried = velocity_of_wall;
            }
            let depth = depth + normal.dot(way);
            if faces.len() == CORRECTIONS {
                way = back - wished;
                break;
            }
            faces.push(Face {
                normal,
                depth,
                speed: normal.dot(velocity_of_wall),
            });
            // At most as far as back to its start, plus the way out of the wall if that start was inside.
            let longest = back.distance(wished) + faces[0].depth;
            let found = shortest_way(&faces, ROUNDING * self.spacing);
            match found.filter(|found| found.length() <= longest + ROUNDING * self.spacing) {
                Some(found) => way = found,
                None => {
                    way = back - wished;
                    break;
                }
            }
        }
        if faces.is_empty() {
            return;
        }
        *position += way.extend(0.0);
        faces.retain(|face| face.normal.dot(way) < face.depth + ROUNDING * self.spacing);
        *velocity += change_along(&faces, velocity.truncate(), carried).extend(0.0);
    }

    /// How far a point \[m] that came from `start` is beyond the clearance of one of the `samples` at the end of the
    /// step, and that sample.
    fn deepest(&self, start: Vec3, samples: &[u32], point: Vec3) -> Option<(f32, usize)> {
        let (clearance, sideways) = (self.clearance, SIDEWAYS * self.spacing);
        let mut deepest = None;
        // The deepest one that is too far to act, but for an edge.
        let mut far: Option<(f32, usize)> = None;
        for &sample in samples {
            // A stale list may contain samples that no longer exist.
            let Some(&normal) = self.boundary.normals.get(sample as usize) else {
                continue;
            };
            let place = self.boundary.packed[sample as usize].truncate();
            let ahead = self.boundary.place_ahead(sample as usize);
            let offset = self.period.nearest(point - ahead);
            let height = offset.dot(normal);
            let along = offset.length_squared() - height * height;
            let depth = clearance - height;
            if depth > deepest.map_or(0.0, |(depth, _)| depth)
                && along < sideways * sideways
                && self.period.nearest(start - place).dot(normal) >= 0.0
            {
                deepest = Some((depth, sample as usize));
            } else if depth > far.map_or(ROUNDING * self.spacing, |(depth, _)| depth)
                && (sideways * sideways..(TO_EDGE * self.spacing).powi(2)).contains(&along)
                && self.period.nearest(start - place).dot(normal) >= 0.0
                && self.reaches_edge(samples, sample as usize, offset - height * normal)
            {
                far = Some((depth, sample as usize));
            }
        }
        deepest.or(far)
    }

    /// Whether a place on the face of a sample, `beside` it \[m], lies between it and a sample of a concave edge of
    /// that face.
    fn reaches_edge(&self, samples: &[u32], sample: usize, beside: Vec3) -> bool {
        let (place, normal) = (
            self.boundary.place_ahead(sample),
            self.boundary.normals[sample],
        );
        samples.iter().any(|&edge| {
            let Some(&of_edge) = self.boundary.normals.get(edge as usize) else {
                return false;
            };
            let to_edge = self
                .period
                .nearest(self.boundary.place_ahead(edge as usize) - place);
            let length = to_edge.length();
            let along = beside.dot(to_edge) / length;
            // On the face, of another direction, and behind the sample as it sees it: the fluid is in the angle.
            to_edge.dot(normal).abs() < 0.1 * self.spacing
                && of_edge.dot(normal) < 0.95
                && to_edge.dot(of_edge) < -0.1 * length
                && along > 0.0
                && along < length
                && beside.length_squared() - along * along < (0.75 * self.spacing).powi(2)
        })
    }
}

/// A face that is to be obeyed.
#[derive(Debug, Clone, Copy)]
struct Face {
    /// Unit vector away from it.
    normal: Vec3,
    /// How far to go along it \[m]; for velocities how much to gain \[m/s].
    depth: f32,
    /// How fast it moves along that \[m/s].
    speed: f32,
}

/// The shortest way that leads as far as each face asks, `normal·way ≥ depth`, the last one among those that are just
/// obeyed; none if there is no such way, but for nearly parallel faces.
fn shortest_way(faces: &[Face], tolerance: f32) -> Option<Vec3> {
    let (last, others) = faces.split_last()?;
    let leads = |way: &Vec3| {
        faces
            .iter()
            .all(|face| face.normal.dot(*way) >= face.depth - tolerance)
    };
    let alone = last.depth * last.normal;
    if last.depth >= 0.0 && leads(&alone) {
        return Some(alone);
    }
    // A way along normals, none of them backwards, is the shortest that just obeys their faces.
    let of_two = |other: &Face| {
        let likeness = last.normal.dot(other.normal);
        let square = 1.0 - likeness * likeness;
        let a = last.depth - likeness * other.depth;
        let b = other.depth - likeness * last.depth;
        let way = (a * last.normal + b * other.normal) / square;
        (square > 1e-4 && a >= 0.0 && b >= 0.0).then_some(way)
    };
    if let Some(way) = others.iter().filter_map(of_two).find(leads) {
        return Some(way);
    }
    let of_three = |first: &Face, second: &Face| {
        let normals = Mat3::from_cols(last.normal, first.normal, second.normal);
        if normals.determinant().abs() < 1e-3 {
            return None;
        }
        let inverse = normals.inverse();
        let way = inverse.transpose() * Vec3::new(last.depth, first.depth, second.depth);
        ((inverse * way).min_element() >= 0.0).then_some(way)
    };
    let mut pairs = (0..others.len()).flat_map(|k| (0..k).map(move |l| (l, k)));
    pairs.find_map(|(l, k)| of_three(&others[l], &others[k]).filter(leads))
}

/// The least change of a velocity \[m/s] that leaves none into a face, seen from that; where there is no other, the one
/// to the velocity of the wall.
fn change_along(faces: &[Face], velocity: Vec3, of_wall: Vec3) -> Vec3 {
    let tolerance = 1e-5 * velocity.length().max(of_wall.length());
    let mut held: SmallVec<[Face; CORRECTIONS]> = SmallVec::new();
    let mut change = Vec3::ZERO;
    loop {
        let inwards = |face: &Face| face.speed - face.normal.dot(velocity + change);
        let worst = faces
            .iter()
            .max_by(|a, b| inwards(a).total_cmp(&inwards(b)));
        let Some(worst) = worst.filter(|worst| inwards(worst) > tolerance) else {
            return change;
        };
        let normal = worst.normal;
        held.push(Face {
            normal,
            depth: worst.speed - normal.dot(velocity),
            speed: worst.speed,
        });
        match shortest_way(&held, tolerance) {
            Some(found) if held.len() <= faces.len() => change = found,
            _ => return of_wall - velocity,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::shapes::split_mix;

    /// Against a search: no place that obeys all faces is nearer.
    #[test]
    fn the_shortest_way_out_of_a_corner_obeys_every_face() {
        let mut state = 5;
        let mut unit = || (split_mix(&mut state) >> 40) as f32 / (1 << 23) as f32 - 1.0;
        let mut found = 0;
        for _ in 0..300 {
            // Faces that all see one place, so that there is a way.
            let free = Vec3::new(unit(), unit(), unit());
            let mut faces: SmallVec<[Face; CORRECTIONS]> = SmallVec::new();
            let all: Vec<Face> = (0..5)
                .filter_map(|_| {
                    let normal = Vec3::new(unit(), unit(), unit()).try_normalize()?;
                    let depth = normal.dot(free) - unit().abs();
                    Some(Face {
                        normal,
                        depth,
                        speed: 0.0,
                    })
                })
                .collect();
            let mut way = Vec3::ZERO;
            let obeyed = loop {
                let missing = |face: &Face| face.depth - face.normal.dot(way);
                let worst = all
                    .iter()
                    .max_by(|a, b| missing(a).total_cmp(&missing(b)))
                    .expect("faces");
                if missing(worst) <= 1e-4 {
                    break true;
                }
                faces.push(*worst);
                match shortest_way(&faces, 1e-5) {
                    Some(next) if faces.len() < 20 => way = next,
                    _ => break false,
                }
            };
            if !obeyed {
                continue;
            }
            found += 1;
            assert!(
                way.length() <= free.length() + 1e-3,
                "{way} is farther than {free}"
            );
        }
        assert!(found > 280, "a way was found in {found} of 300 corners");
    }

    #[test]
    fn a_velocity_into_an_acute_edge_is_lost_but_not_that_along_it() {
        let (sin, cos) = 5f32.to_radians().sin_cos();
        let faces = [1.0, -1.0].map(|side| Face {
            normal: Vec3::new(sin, side * cos, 0.0),
            depth: 0.0,
            speed: 0.0,
        });
        let velocity = Vec3::new(-3.0, 0.5, 2.0);
        let left = velocity + change_along(&faces, velocity, Vec3::ZERO);
        assert!(left.distance(Vec3::new(0.0, 0.0, 2.0)) < 1e-4, "{left}");
        let outwards = Vec3::new(3.0, 0.0, 2.0);
        assert_eq!(change_along(&faces, outwards, Vec3::ZERO), Vec3::ZERO);
    }
}
