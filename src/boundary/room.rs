//! Fluid that walls have closed in: no step solves what has no solution, so the cause is named.
//!
//! The density of a body of fluid with a free surface is on average below that at rest, because kernels at the surface
//! reach into the air. If the average over connected fluid is above, it has no surface left, and a wall that goes on
//! moves into an incompressible body.

use std::collections::HashMap;

use bevy_ecs::prelude::*;
use glam::Vec4;

use super::moving::MovingWalls;
use crate::{
    index::BoundarySamples,
    state::{Clock, Densities, Failure, FailureCause, Material, Positions, SolverState},
};

/// Particles nearer than this are of one body \[spacings]: less than the thinnest wall between two.
const NEAR: f32 = 1.5;
/// A body has this many particles at least: a few that are squeezed into a corner have no surface either.
const FEWEST: usize = 30;
/// Steps between two looks at fluid that is compressed by more than [`SUSPECT`] \[-] somewhere.
const EVERY: u64 = 10;
const SUSPECT: f32 = 0.02;
/// Mean compression that no method leaves of itself \[-].
const COMPRESSED: f64 = 0.01;

/// What a body of fluid without room was found to be.
#[derive(Debug, Clone, PartialEq)]
struct Body {
    particles: usize,
    compression: f64,
    walls: Vec<u32>,
}

type Fluid<'w> = (Res<'w, Positions>, Res<'w, Densities>, Res<'w, Material>);
type Walls<'w> = (Res<'w, MovingWalls>, Res<'w, BoundarySamples>);

/// Names the cause of a failure, if it is that walls have left no room (phase `Observe`, with walls in motion).
pub fn explain_no_room(mut failure: ResMut<Failure>, fluid: Fluid, walls: Walls) {
    if !failure.depends_on_the_time_step() {
        return;
    }
    if let Some(cause) = no_room(&fluid, &walls, 0.0) {
        failure.explain(cause);
    }
}

/// Ends a run in which walls compress a fluid that has no room left, before its steps become ever shorter (phase
/// `Integrate`, with walls in motion and a method that iterates).
pub fn look_for_room(
    mut failure: ResMut<Failure>,
    fluid: Fluid,
    walls: Walls,
    solve: Res<SolverState>,
    clock: Res<Clock>,
) {
    if !clock.step.is_multiple_of(EVERY) || solve.error.largest < SUSPECT {
        return;
    }
    if let Some(cause) = no_room(&fluid, &walls, COMPRESSED) {
        failure.record(cause, None);
    }
}

fn no_room(
    (positions, densities, material): &Fluid,
    walls: &Walls,
    least: f64,
) -> Option<FailureCause> {
    let rows = positions.rows();
    let (points, densities) = (&positions.0[..rows], densities.0.get(..rows)?);
    let body = tightest(points, densities, material, walls, least)?;
    Some(FailureCause::NoRoom {
        walls: body.walls,
        particles: body.particles,
        compression: body.compression as f32,
    })
}

/// The body with the largest mean compression above `least` that a moving wall touches.
fn tightest(
    points: &[Vec4],
    densities: &[f32],
    material: &Material,
    (walls, samples): &Walls,
    least: f64,
) -> Option<Body> {
    let near = NEAR * material.spacing;
    let cells = Cells::new(points, near);
    let bodies = bodies(points, &cells);
    let mut sums: HashMap<u32, (usize, f64)> = HashMap::new();
    for (&body, &density) in bodies.iter().zip(densities) {
        let sum = sums.entry(body).or_default();
        sum.0 += 1;
        sum.1 += f64::from(density / material.rest_density) - 1.0;
    }
    let mut tight: Vec<(f64, u32, usize)> = sums
        .into_iter()
        .filter(|(_, (count, sum))| *count >= FEWEST && *sum > least * *count as f64)
        .map(|(body, (count, sum))| (sum / count as f64, body, count))
        .collect();
    tight.sort_by(|a, b| b.0.total_cmp(&a.0).then(a.1.cmp(&b.1)));
    tight
        .into_iter()
        .find_map(|(compression, body, particles)| {
            let touches = |place: Vec4| {
                let of_body = |row: &u32| {
                    let distance = points[*row as usize].truncate().distance(place.truncate());
                    bodies[*row as usize] == body && distance < near
                };
                cells.around(place).any(|row| of_body(&row))
            };
            let walls = walls.boundaries_in_motion(samples, touches);
            (!walls.is_empty()).then_some(Body {
                particles,
                compression,
                walls,
            })
        })
}

/// Rows by cell.
struct Cells {
    edge: f32,
    rows: HashMap<[i32; 3], Vec<u32>>,
}

impl Cells {
    fn new(points: &[Vec4], edge: f32) -> Self {
        let mut rows: HashMap<[i32; 3], Vec<u32>> = HashMap::new();
        for (row, point) in (0..).zip(points) {
            rows.entry(cell(*point, edge)).or_default().push(row);
        }
        Self { edge, rows }
    }

    /// Rows in the cell of a point and those around it.
    fn around(&self, point: Vec4) -> impl Iterator<Item = u32> {
        let middle = cell(point, self.edge);
        (0..27).flat_map(move |k: i32| {
            let offset = [k % 3 - 1, k / 3 % 3 - 1, k / 9 - 1];
            let cell = [0, 1, 2].map(|axis| middle[axis].saturating_add(offset[axis]));
            self.rows.get(&cell).into_iter().flatten().copied()
        })
    }
}

fn cell(point: Vec4, edge: f32) -> [i32; 3] {
    (point.truncate() / edge).floor().as_ivec3().to_array()
}

/// The body of each row, by the number of its first row.
fn bodies(points: &[Vec4], cells: &Cells) -> Vec<u32> {
    let mut of = vec![u32::MAX; points.len()];
    let mut open = Vec::new();
    for first in 0..points.len() as u32 {
        if of[first as usize] != u32::MAX {
            continue;
        }
        of[first as usize] = first;
        open.push(first);
        while let Some(row) = open.pop() {
            let point = points[row as usize];
            for other in cells.around(point) {
                let other_point = points[other as usize];
                let is_near = other_point.truncate().distance(point.truncate()) < cells.edge;
                if is_near && of[other as usize] == u32::MAX {
                    of[other as usize] = first;
                    open.push(other);
                }
            }
        }
    }
    of
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Two blocks of unlike size, farther apart than particles in them.
    #[test]
    fn what_is_connected_is_one_body() {
        let block = |origin: f32, count: u8| {
            let place = move |k: u8| {
                let (x, y) = (f32::from(k % 4), f32::from(k / 4));
                Vec4::new(origin + 0.1 * x, 0.1 * y, 0.0, 0.0)
            };
            (0..count).map(place)
        };
        let points: Vec<Vec4> = block(0.0, 16).chain(block(0.5, 8)).collect();
        let of = bodies(&points, &Cells::new(&points, 0.15));
        assert!(of[..16].iter().all(|body| *body == 0), "{of:?}");
        assert!(of[16..].iter().all(|body| *body == 16), "{of:?}");
        let of = bodies(&points, &Cells::new(&points, 0.25));
        assert!(of.iter().all(|body| *body == 0), "{of:?}");
    }
}
