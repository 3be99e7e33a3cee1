//! Bodies of fluid: room for every particle.
//!
//! Fluid that starts in a wall, or in other fluid, explodes in the first steps. Option 1: delete such particles.
//! Option 2: refuse the scene and say where. We use 2: a scene with fewer particles than its author thinks is a wrong
//! result that nobody sees. What counts is the particles before jitter, each with half a spacing of room around it.

use std::collections::HashMap;

use glam::{DVec3, I64Vec3};
use smallvec::SmallVec;

use super::boxes::Boxes;
use super::periodic;
use super::problem::{Checked, Problem, ensure};
use super::proper::{AXIS_NAMES, axes};

use crate::filling::{self, Obstacle};
use crate::mesh::{Mesh, TOLERANCE};
use crate::sampling::layer_depth;
use crate::scene::shapes::{Lattice, tolerance};
use crate::scene::{BoundaryShape, Dimension, Frame, Scene, Shape};

/// The particles of one body: their lattice, and the box around their centres \[m].
pub(super) struct Particles {
    path: String,
    pub(super) lattice: Lattice,
    min: DVec3,
    max: DVec3,
    /// What distances may miss by, for rounding \[m].
    tolerance: f64,
}

/// Checks where the fluid is. Returns the particles of every body.
pub(super) fn places(scene: &Scene, meshes: &[Option<Mesh>]) -> Result<Vec<Particles>, Problem> {
    let spacing = f64::from(scene.spacing);
    let mut bodies = Vec::with_capacity(scene.bodies.len());
    let lattices = filling::lattices(scene, meshes);
    for ((index, body), lattice) in scene.bodies.iter().enumerate().zip(lattices) {
        let path = format!("bodies.{index}.shape");
        let (mut min, mut max) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
        lattice.for_each(|point| {
            min = min.min(point);
            max = max.max(point);
        });
        ensure(min.x <= max.x, &path, || {
            if body.cut {
                return "the body holds no particle: boundaries leave no room in it; move it, or leave it out"
                    .to_owned();
            }
            format!(
                "the body holds no particle: it is thinner than the spacing of {} m; make it larger or the spacing \
                 smaller",
                scene.spacing
            )
        })?;
        let body = Particles {
            path,
            lattice,
            min,
            max,
            tolerance: spacing * tolerance(min.abs().max(max.abs()).max_element(), spacing),
        };
        in_domain(scene, &body)?;
        if matches!(scene.bodies[index].shape, Shape::Particles(_)) {
            not_crowded(scene, &body)?;
        }
        periodic::meets_itself(scene, &body.path, (body.min, body.max))?;
        bodies.push(body);
    }
    let unrolled = periodic::unrolled(scene);
    let scene = unrolled.as_ref().unwrap_or(scene);
    let surroundings = Surroundings::new(scene, meshes, &bodies);
    for body in &bodies {
        in_a_tank(scene, body, &surroundings)?;
        clear_of_obstacles(scene, body, &surroundings)?;
    }
    all_apart(&bodies, spacing)?;
    Ok(bodies)
}

/// Particles \[-] in a cube of a spacing from which a file is refused: the pairs of many more take all time and memory
/// before their density is known.
const CROWD: u32 = 64;

/// The particles of a file do not lie in one place by the dozen.
fn not_crowded(scene: &Scene, body: &Particles) -> Checked {
    let spacing = f64::from(scene.spacing);
    let mut cells: HashMap<I64Vec3, u32> = HashMap::new();
    let (mut most, mut at) = (0, DVec3::ZERO);
    body.lattice.for_each(|x| {
        let count = cells.entry((x / spacing).floor().as_i64vec3()).or_default();
        *count += 1;
        if *count > most {
            (most, at) = (*count, x);
        }
    });
    ensure(most < CROWD, &body.path, || {
        format!(
            "{most} particles of the file lie within a spacing of {} m at {}, where a fluid has one; the spacing, or \
             the `scale` of the file, is another one",
            scene.spacing,
            point(at, scene.dimension)
        )
    })
}

/// Tanks and obstacles of a scene, to be found by their places.
struct Surroundings<'a> {
    obstacles: Vec<(usize, Obstacle<'a>)>,
    near_obstacles: Boxes,
    tanks: usize,
    near_tanks: Boxes,
}

impl<'a> Surroundings<'a> {
    fn new(scene: &Scene, meshes: &'a [Option<Mesh>], bodies: &[Particles]) -> Self {
        let mut obstacles = Vec::new();
        let (mut around, mut tanks) = (Vec::new(), Vec::new());
        let thickness = 2.0 * f64::from(layer_depth(scene)) + f64::from(scene.spacing);
        let empty = (DVec3::INFINITY, DVec3::NEG_INFINITY);
        let (low, high) = (bodies.iter()).fold(empty, |(low, high), body| {
            (low.min(body.min), high.max(body.max))
        });
        let extent = (high - low).length().max(0.0);
        let top = bodies
            .iter()
            .fold(f64::NEG_INFINITY, |top, body| top.max(body.max.y));
        for (index, (boundary, mesh)) in scene.boundaries.iter().zip(meshes).enumerate() {
            let reach = if boundary.frame().is_turned() {
                extent
            } else {
                0.0
            };
            if let BoundaryShape::Tank { min, max, open, .. } = *boundary {
                let (min, mut max) = (min.as_dvec3() - thickness, max.as_dvec3() + thickness);
                // Fluid may stand above its rim. Of a tank that is turned no side is known to be above.
                if open {
                    max.y = max.y.max(top + thickness) + reach;
                }
                tanks.push((index, Some(boundary.frame().bounds(min, max))));
            } else if let Some(obstacle) = Obstacle::new(boundary, mesh.as_ref(), scene) {
                around.push((obstacles.len(), obstacle.bounds()));
                obstacles.push((index, obstacle));
            }
        }
        Self {
            obstacles,
            near_obstacles: Boxes::new(around),
            tanks: tanks.len(),
            near_tanks: Boxes::new(tanks),
        }
    }
}

/// No two bodies overlap or are nearer than a lattice. Each is held against those before it whose boxes are near.
fn all_apart(bodies: &[Particles], spacing: f64) -> Checked {
    let boxes = bodies.iter().map(|body| Some((body.min, body.max)));
    let boxes = Boxes::new(boxes.enumerate().collect());
    for (second, body) in bodies.iter().enumerate() {
        for first in boxes.near(body.min - spacing, body.max + spacing, second) {
            apart(&bodies[first], first, body, spacing)?;
        }
    }
    Ok(())
}

/// How far a body reaches beyond a box, at the worst side.
pub(super) struct Excess {
    /// \[m]; negative if the body is inside.
    pub(super) depth: f64,
    pub(super) side: String,
}

fn excess(scene: &Scene, around: (DVec3, DVec3), min: DVec3, max: DVec3, open: bool) -> Excess {
    let half = 0.5 * f64::from(scene.spacing);
    sticks_out(half, scene, around, (min, max, open))
}

/// The box around points \[m] in the axes of a shape as it is written.
pub(super) fn box_in(
    frame: &Frame,
    for_each: impl FnOnce(&mut dyn FnMut(DVec3)),
) -> (DVec3, DVec3) {
    let (mut min, mut max) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
    for_each(&mut |point| {
        let point = frame.local(point);
        (min, max) = (min.min(point), max.max(point));
    });
    (min, max)
}

/// How far particles with centres in one box, each with half a cell around it, reach beyond another box, which may be
/// open upwards.
pub(super) fn sticks_out(
    half: f64,
    scene: &Scene,
    (low, high): (DVec3, DVec3),
    (min, max, open): (DVec3, DVec3, bool),
) -> Excess {
    let mut worst = Excess {
        depth: f64::NEG_INFINITY,
        side: String::new(),
    };
    for axis in 0..axes(scene.dimension) {
        let lower = (min[axis] - (low[axis] - half), '−');
        let upper = ((high[axis] + half) - max[axis], '+');
        for (depth, sign) in [lower, upper] {
            let missing = open && axis == 1 && sign == '+';
            if !missing && depth > worst.depth {
                worst = Excess {
                    depth,
                    side: format!("{sign}{}", AXIS_NAMES[axis]),
                };
            }
        }
    }
    worst
}

fn in_domain(scene: &Scene, body: &Particles) -> Checked {
    let Some(domain) = scene.domain else {
        return Ok(());
    };
    let spacing = f64::from(scene.spacing);
    let (min, max) = (domain.min.as_dvec3(), domain.max.as_dvec3());
    let over = excess(scene, (body.min, body.max), min, max, false);
    ensure(over.depth <= body.tolerance, &body.path, || {
        format!(
            "the fluid sticks out of the domain by {} at its {} side; move or shrink it, or widen `domain`",
            length(over.depth, spacing),
            over.side
        )
    })
}

/// A body is inside one tank, or there is none; and it lies in no tank's walls, which are as thick as a sheet: their
/// one layer of samples lies in the middle.
fn in_a_tank(scene: &Scene, body: &Particles, around: &Surroundings) -> Checked {
    let spacing = f64::from(scene.spacing);
    let tolerance = body.tolerance;
    let thickness = 2.0 * f64::from(layer_depth(scene));
    let mut inside = false;
    let near = (around.near_tanks).near(body.min, body.max, scene.boundaries.len());
    for index in near {
        let BoundaryShape::Tank { min, max, open, .. } = scene.boundaries[index] else {
            continue;
        };
        let (min, max) = (min.as_dvec3(), max.as_dvec3());
        let frame = scene.boundaries[index].frame();
        let (low, high) = if frame.is_turned() {
            box_in(&frame, |visit| body.lattice.for_each(visit))
        } else {
            (body.min, body.max)
        };
        let over = excess(scene, (low, high), min, max, open);
        if over.depth <= tolerance {
            inside = true;
            continue;
        }
        let separate = (0..axes(scene.dimension)).any(|axis| {
            let upper_wall = if open && axis == 1 { 0.0 } else { thickness };
            let (lower, upper) = (min[axis] - thickness, max[axis] + upper_wall);
            high[axis] + 0.5 * spacing <= lower + tolerance
                || low[axis] - 0.5 * spacing >= upper - tolerance
        });
        ensure(separate, &body.path, || {
            format!(
                "the fluid sticks out of the tank `boundaries.{index}` by {} at its {} side; move or shrink it \
                 (outside it must be {} away, as thick as the tank's walls are)",
                length(over.depth, spacing),
                over.side,
                length(thickness, spacing)
            )
        })?;
    }
    ensure(inside || around.tanks == 0, &body.path, || {
        format!(
            "the fluid, from {} to {}, is outside every tank; move it into one, or remove the tanks",
            point(body.min - 0.5 * spacing, scene.dimension),
            point(body.max + 0.5 * spacing, scene.dimension)
        )
    })
}

fn clear_of_obstacles(scene: &Scene, body: &Particles, around: &Surroundings) -> Checked {
    let spacing = f64::from(scene.spacing);
    let (low, high) = (body.min - spacing, body.max + spacing);
    for number in (around.near_obstacles).near(low, high, around.obstacles.len()) {
        let (index, obstacle) = &around.obstacles[number];
        let (mut nearest, mut at) = (f64::INFINITY, DVec3::ZERO);
        let (low, high) = match obstacle.bounds() {
            Some((min, max)) => (low.max(min - spacing), high.min(max + spacing)),
            None => (low, high),
        };
        body.lattice.for_each_near(low, high, |point| {
            let distance = obstacle.distance(point);
            if distance < nearest {
                (nearest, at) = (distance, point);
            }
        });
        let depth = 0.5 * spacing - nearest;
        // Seams of a mesh may be off by as much.
        let seam = if obstacle.is_mesh() {
            TOLERANCE * spacing
        } else {
            0.0
        };
        ensure(depth <= body.tolerance + seam, &body.path, || {
            format!(
                "the fluid overlaps the {} `boundaries.{index}` by {}, most at {}{}; move one of them, or leave the \
                 place free with two bodies",
                obstacle.name,
                length(depth, spacing),
                point(at, scene.dimension),
                obstacle.counts_as(spacing)
            )
        })?;
    }
    Ok(())
}

/// No particle of one body is nearer than a spacing to one of the other: nearer than in a lattice the fluid would start
/// compressed.
fn apart(first: &Particles, first_index: usize, second: &Particles, spacing: f64) -> Checked {
    let (min, max) = (
        first.min.max(second.min) - spacing,
        first.max.min(second.max) + spacing,
    );
    if min.cmpgt(max).any() {
        return Ok(());
    }
    let common = |point: DVec3| point.cmpge(min).all() && point.cmple(max).all();
    let cell = |point: DVec3| (point / spacing).floor().as_i64vec3();
    let mut cells: HashMap<I64Vec3, SmallVec<[DVec3; 2]>> = HashMap::new();
    first.lattice.for_each_near(min, max, |point| {
        if common(point) {
            cells.entry(cell(point)).or_default().push(point);
        }
    });
    let (mut nearest, mut at) = (f64::INFINITY, DVec3::ZERO);
    second.lattice.for_each_near(min, max, |point| {
        if !common(point) {
            return;
        }
        for offset in 0..27 {
            let offset = I64Vec3::new(offset % 3 - 1, offset / 3 % 3 - 1, offset / 9 - 1);
            for other in cells.get(&(cell(point) + offset)).into_iter().flatten() {
                let distance = point.distance(*other);
                if distance < nearest {
                    (nearest, at) = (distance, point);
                }
            }
        }
    });
    if nearest >= spacing - first.tolerance.max(second.tolerance) {
        return Ok(());
    }
    Err(Problem::new(
        &second.path,
        format!(
            "the fluid overlaps that of `bodies.{first_index}` or is nearer than a lattice: two particles are {} \
             apart at {}; a spacing is needed, so move or shrink one body by {}",
            length(nearest, spacing),
            point(at, Dimension::Three),
            length(spacing - nearest, spacing)
        ),
    ))
}

pub(super) fn length(metres: f64, spacing: f64) -> String {
    format!("{metres:.4} m ({:.2} spacings)", metres / spacing)
}

pub(super) fn point(at: DVec3, dimension: Dimension) -> String {
    match dimension {
        Dimension::Two => format!("({:.4}, {:.4}) m", at.x, at.y),
        Dimension::Three => format!("({:.4}, {:.4}, {:.4}) m", at.x, at.y, at.z),
    }
}
