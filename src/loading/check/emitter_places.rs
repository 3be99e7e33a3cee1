//! Room behind the faces of emitters, where their layers wait.

use std::collections::HashMap;

use glam::{DVec3, I64Vec3};
use smallvec::SmallVec;

use super::bodies::{box_in, length, point, sticks_out};
use super::carried;
use super::problem::{Checked, Problem, ensure};
use super::proper::axes;

use crate::filling::{self, Obstacle};
use crate::mesh::{Mesh, TOLERANCE};
use crate::sampling::layer_depth;
use crate::scene::shapes::{Inlet, tolerance};
use crate::scene::{BoundaryShape, Dimension, Emitter, Scene};

/// The particles that wait behind the face of an emitter when it starts.
struct Waiting {
    path: String,
    inlet: Inlet,
    points: Vec<DVec3>,
    /// The box around their centres \[m].
    low: DVec3,
    high: DVec3,
    /// Room around a centre \[m].
    half: f64,
    tolerance: f64,
}

impl Waiting {
    fn new(scene: &Scene, index: usize, emitter: &Emitter) -> Self {
        let inlet = Inlet::new(emitter, scene);
        let even = Emitter {
            jitter: None,
            ..emitter.clone()
        };
        let all = u64::from(inlet.waiting) * inlet.points.len() as u64;
        let mut points = Vec::new();
        let start = f64::from(emitter.start);
        inlet.for_each(&even, 0..all, start, |point| points.push(point));
        let empty = (DVec3::INFINITY, DVec3::NEG_INFINITY);
        let (low, high) = (points.iter()).fold(empty, |(low, high), x| (low.min(*x), high.max(*x)));
        let spacing = f64::from(scene.spacing);
        Self {
            path: format!("emitters.{index}.shape"),
            half: 0.5 * inlet.nearest,
            inlet,
            points,
            low,
            high,
            tolerance: spacing * tolerance(low.abs().max(high.abs()).max_element(), spacing),
        }
    }

    /// A problem of particles that need their place.
    fn problem(&self, what: &str, at: DVec3, dimension: Dimension) -> Problem {
        let behind = f64::from(self.inlet.waiting) * self.inlet.pitch;
        Problem::new(
            &self.path,
            format!(
                "the fluid that waits behind the face, {} layers of {behind:.4} m in all, {what}, most at {}; move \
                 the emitter, or make room behind it",
                self.inlet.waiting,
                point(at, dimension)
            ),
        )
    }
}

/// There is room behind every face, in the domain and in no wall, fluid or box that removes.
pub(super) fn places(scene: &Scene, meshes: &[Option<Mesh>]) -> Checked {
    let numbered = scene.emitters.iter().enumerate();
    let waiting: Vec<Waiting> = numbered
        .map(|(index, emitter)| Waiting::new(scene, index, emitter))
        .collect();
    for (index, here) in waiting.iter().enumerate() {
        carried::of_one(scene, here.path.clone(), [here.low, here.high])?;
        in_domain(scene, here)?;
        clear_of_outflow(scene, here)?;
        clear_of_walls(scene, meshes, here)?;
        clear_of_fluid(scene, meshes, here)?;
        for (other, there) in waiting[..index].iter().enumerate() {
            apart(scene, (here, index), (there, other))?;
        }
    }
    Ok(())
}

fn in_domain(scene: &Scene, here: &Waiting) -> Checked {
    let Some(domain) = scene.domain else {
        return Ok(());
    };
    let (min, max) = (domain.min.as_dvec3(), domain.max.as_dvec3());
    let over = sticks_out(here.half, scene, (here.low, here.high), (min, max, false));
    ensure(over.depth <= here.tolerance, &here.path, || {
        format!(
            "the fluid that waits behind the face sticks out of the domain by {} at its {} side; move the emitter, \
             or widen `domain`",
            length(over.depth, scene.spacing.into()),
            over.side
        )
    })
}

fn clear_of_outflow(scene: &Scene, here: &Waiting) -> Checked {
    for (index, bounds) in scene.outflow.iter().enumerate() {
        let (min, max) = (bounds.min.as_dvec3(), bounds.max.as_dvec3());
        let inside = |x: &&DVec3| x.cmpge(min).all() && x.cmple(max).all();
        if let Some(&at) = here.points.iter().find(inside) {
            let what = format!("is in the box `outflow.{index}`, which removes it");
            return Err(here.problem(&what, at, scene.dimension));
        }
    }
    Ok(())
}

fn clear_of_walls(scene: &Scene, meshes: &[Option<Mesh>], here: &Waiting) -> Checked {
    let spacing = f64::from(scene.spacing);
    let thickness = 2.0 * f64::from(layer_depth(scene));
    for (index, (boundary, mesh)) in scene.boundaries.iter().zip(meshes).enumerate() {
        if let BoundaryShape::Tank { min, max, open, .. } = *boundary {
            let (min, max) = (min.as_dvec3(), max.as_dvec3());
            let frame = boundary.frame();
            let (low, high) = box_in(&frame, |visit| here.points.iter().copied().for_each(visit));
            let over = sticks_out(here.half, scene, (low, high), (min, max, open));
            let half = here.half;
            let outside = (0..axes(scene.dimension)).any(|axis| {
                let lid = if open && axis == 1 { 0.0 } else { thickness };
                high[axis] + half <= min[axis] - thickness + here.tolerance
                    || low[axis] - half >= max[axis] + lid - here.tolerance
            });
            ensure(over.depth <= here.tolerance || outside, &here.path, || {
                format!(
                    "the fluid that waits behind the face sticks out of the tank `boundaries.{index}` by {} at its {} \
                     side; move the emitter (outside it must be {} away, as thick as the tank's walls are)",
                    length(over.depth, spacing),
                    over.side,
                    length(thickness, spacing)
                )
            })?;
            continue;
        }
        let Some(obstacle) = Obstacle::new(boundary, mesh.as_ref(), scene) else {
            continue;
        };
        let is_near = obstacle.bounds().is_none_or(|(low, high)| {
            let near = (here.low - spacing).cmple(high) & (here.high + spacing).cmpge(low);
            near.all()
        });
        if !is_near {
            continue;
        }
        let distances = here.points.iter().map(|&x| (obstacle.distance(x), x));
        let nearest = distances.min_by(|a, b| a.0.total_cmp(&b.0));
        let seam = if obstacle.is_mesh() {
            TOLERANCE * spacing
        } else {
            0.0
        };
        if let Some((distance, at)) = nearest
            && here.half - distance > here.tolerance + seam
        {
            let what = format!(
                "overlaps the {} `boundaries.{index}` by {}{}",
                obstacle.name,
                length(here.half - distance, spacing),
                obstacle.counts_as(spacing)
            );
            return Err(here.problem(&what, at, scene.dimension));
        }
    }
    Ok(())
}

/// Bodies are no nearer than particles of the layers are to each other.
fn clear_of_fluid(scene: &Scene, meshes: &[Option<Mesh>], here: &Waiting) -> Checked {
    let spacing = f64::from(scene.spacing);
    let near = Near::new(&here.points, spacing);
    for (index, body) in scene.bodies.iter().enumerate() {
        let lattice = filling::lattice(body, scene, meshes);
        let (mut nearest, mut at) = (f64::INFINITY, DVec3::ZERO);
        let (low, high) = (here.low - spacing, here.high + spacing);
        lattice.for_each_near(low, high, |x| {
            let distance = near.distance(x);
            if distance < nearest {
                (nearest, at) = (distance, x);
            }
        });
        if nearest < here.inlet.nearest - here.tolerance {
            let what = format!(
                "overlaps the fluid of `bodies.{index}`: two particles are {} apart",
                length(nearest, spacing)
            );
            return Err(here.problem(&what, at, scene.dimension));
        }
    }
    Ok(())
}

/// Two emitters that run at the same time have places of their own.
fn apart(
    scene: &Scene,
    (here, index): (&Waiting, usize),
    (there, other): (&Waiting, usize),
) -> Checked {
    let spacing = f64::from(scene.spacing);
    let (a, b) = (&scene.emitters[index], &scene.emitters[other]);
    let ends_before = |a: &Emitter, b: &Emitter| a.end.is_some_and(|end| end <= b.start);
    let is_far = (here.low - spacing).cmpgt(there.high).any()
        || (here.high + spacing).cmplt(there.low).any();
    if is_far || ends_before(a, b) || ends_before(b, a) {
        return Ok(());
    }
    let near = Near::new(&there.points, spacing);
    let distances = here.points.iter().map(|&x| (near.distance(x), x));
    let nearest = distances.min_by(|a, b| a.0.total_cmp(&b.0));
    let least = here.inlet.nearest.min(there.inlet.nearest);
    match nearest {
        Some((distance, at)) if distance < least - here.tolerance => {
            let what = format!(
                "overlaps that of `emitters.{other}`: two particles are {} apart",
                length(distance, spacing)
            );
            Err(here.problem(&what, at, scene.dimension))
        }
        _ => Ok(()),
    }
}

/// Points in cells as large as the spacing.
struct Near {
    cells: HashMap<I64Vec3, SmallVec<[DVec3; 2]>>,
    spacing: f64,
}

impl Near {
    fn new(points: &[DVec3], spacing: f64) -> Self {
        let mut cells: HashMap<I64Vec3, SmallVec<[DVec3; 2]>> = HashMap::new();
        for &x in points {
            let cell = (x / spacing).floor().as_i64vec3();
            cells.entry(cell).or_default().push(x);
        }
        Self { cells, spacing }
    }

    /// Distance from a point to the nearest one within a spacing \[m]; infinite without one.
    fn distance(&self, x: DVec3) -> f64 {
        let cell = (x / self.spacing).floor().as_i64vec3();
        let offset = |k: i64| I64Vec3::new(k % 3 - 1, k / 3 % 3 - 1, k / 9 - 1);
        let around = (0..27).filter_map(|k| self.cells.get(&(cell + offset(k))));
        let distances = around.flatten().map(|other| other.distance(x));
        distances.fold(f64::INFINITY, f64::min)
    }
}
