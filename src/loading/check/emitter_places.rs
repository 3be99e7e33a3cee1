//! Room behind the faces of emitters, where their layers wait.

use std::collections::HashMap;

use glam::{DVec3, I64Vec3};
use smallvec::SmallVec;

use super::bodies::{Particles, box_in, length, point, sticks_out};
use super::carried;
use super::periodic;
use super::problem::{Checked, Problem, ensure};
use super::proper::axes;

use crate::filling::Obstacle;
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
        // Later ones come in when the layer before them has moved by half of their distance: half of it deeper.
        let last = all - inlet.points.len() as u64..all;
        let deeper = 0.5 * inlet.pitch * inlet.normal;
        inlet.for_each(&even, last, start, |point| points.push(point - deeper));
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
pub(super) fn places(scene: &Scene, meshes: &[Option<Mesh>], bodies: &[Particles]) -> Checked {
    let unrolled = periodic::unrolled(scene);
    let scene = unrolled.as_ref().unwrap_or(scene);
    let numbered = scene.emitters.iter().enumerate();
    let waiting: Vec<Waiting> = numbered
        .map(|(index, emitter)| Waiting::new(scene, index, emitter))
        .collect();
    for (index, here) in waiting.iter().enumerate() {
        carried::of_one(scene, here.path.clone(), [here.low, here.high])?;
        in_domain(scene, here)?;
        clear_of_outflow(scene, here)?;
        clear_of_walls(scene, meshes, here)?;
        clear_of_fluid(scene, bodies, here)?;
        clear_of_itself(scene, here, index)?;
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
        let period = scene.period();
        let inside = |x: &&DVec3| period.contains(bounds, x.as_vec3());
        if let Some(&at) = here.points.iter().find(inside) {
            let what = format!("is in the box `outflow.{index}`, which removes it");
            return Err(here.problem(&what, at, scene.dimension));
        }
    }
    Ok(())
}

/// Images that may meet anything else of the scene: how far each is from the fluid as the scene places it \[m].
fn images(scene: &Scene, here: &Waiting) -> Vec<DVec3> {
    let period = scene.period();
    let middle = 0.5 * (here.low + here.high);
    let mut images = vec![period.wrap_exactly(middle) - middle];
    for axis in (0..3).filter(|axis| period.axes().test(*axis)) {
        let mut length = DVec3::ZERO;
        length[axis] = f64::from(period.length[axis]);
        let beside = |image: &DVec3| [*image, *image - length, *image + length];
        images = images.iter().flat_map(beside).collect();
    }
    images
}

fn clear_of_walls(scene: &Scene, meshes: &[Option<Mesh>], here: &Waiting) -> Checked {
    for (index, (boundary, mesh)) in scene.boundaries.iter().zip(meshes).enumerate() {
        let obstacle = Obstacle::new(boundary, mesh.as_ref(), scene);
        for image in images(scene, here) {
            match &obstacle {
                None => in_no_wall_of_a_tank(scene, boundary, here, (index, image))?,
                Some(obstacle) => clear_of_solid(scene, boundary, obstacle, here, (index, image))?,
            }
        }
    }
    Ok(())
}

fn in_no_wall_of_a_tank(
    scene: &Scene,
    tank: &BoundaryShape,
    here: &Waiting,
    (index, image): (usize, DVec3),
) -> Checked {
    let BoundaryShape::Tank { min, max, open, .. } = *tank else {
        return Ok(());
    };
    let spacing = f64::from(scene.spacing);
    let thickness = 2.0 * f64::from(layer_depth(scene));
    let (min, max) = (min.as_dvec3(), max.as_dvec3());
    let half = here.half;
    let frame = tank.frame();
    let sticks = |offset: DVec3| {
        let points = here.points.iter().map(|x| x + offset);
        let (low, high) = box_in(&frame, |visit| points.clone().for_each(visit));
        let over = sticks_out(half, scene, (low, high), (min, max, open));
        let outside = (0..axes(scene.dimension)).any(|axis| {
            let lid = if open && axis == 1 { 0.0 } else { thickness };
            high[axis] + half <= min[axis] - thickness + here.tolerance
                || low[axis] - half >= max[axis] + lid - here.tolerance
        });
        (over.depth > here.tolerance && !outside).then_some(over)
    };
    if let Some(over) = sticks(image) {
        let message = format!(
            "the fluid that waits behind the face sticks out of the tank `boundaries.{index}` by {} at its {} side; \
             move the emitter (outside it must be {} away, as thick as the tank's walls are)",
            length(over.depth, spacing),
            over.side,
            length(thickness, spacing)
        );
        return Err(Problem::new(&here.path, message));
    }
    // What enters first needs room in front of the face, too. A wall that moves may be away by then.
    let ahead = here.inlet.pitch * here.inlet.normal;
    match sticks(image + ahead).filter(|_| tank.motion().is_none()) {
        None => Ok(()),
        Some(over) => Err(Problem::new(
            &here.path,
            format!(
                "the fluid that enters meets the tank `boundaries.{index}` right before the face: its first layer \
                 sticks out by {} at its {} side; move the emitter back, or turn its normal",
                length(over.depth, spacing),
                over.side
            ),
        )),
    }
}

fn clear_of_solid(
    scene: &Scene,
    boundary: &BoundaryShape,
    obstacle: &Obstacle,
    here: &Waiting,
    (index, image): (usize, DVec3),
) -> Checked {
    let spacing = f64::from(scene.spacing);
    let ahead = here.inlet.pitch * here.inlet.normal;
    let is_near = obstacle.bounds().is_none_or(|(low, high)| {
        let (first, last) = (
            here.low.min(here.low + ahead),
            here.high.max(here.high + ahead),
        );
        let near = (first + image - spacing).cmple(high) & (last + image + spacing).cmpge(low);
        near.all()
    });
    if !is_near {
        return Ok(());
    }
    let seam = if obstacle.is_mesh() {
        TOLERANCE * spacing
    } else {
        0.0
    };
    let nearest = |offset: DVec3| {
        let distances = here
            .points
            .iter()
            .map(|&x| (obstacle.distance(x + offset), x + offset));
        distances.min_by(|a, b| a.0.total_cmp(&b.0))
    };
    let overlap = |(distance, at)| {
        let depth = here.half - distance;
        (depth > here.tolerance + seam).then(|| (length(depth, spacing), at))
    };
    if let Some((depth, at)) = nearest(image).and_then(overlap) {
        let what = format!(
            "overlaps the {} `boundaries.{index}` by {depth}{}",
            obstacle.name,
            obstacle.counts_as(spacing)
        );
        return Err(here.problem(&what, at, scene.dimension));
    }
    // A wall that moves may be away when the fluid enters.
    match nearest(image + ahead).and_then(overlap) {
        Some((depth, at)) if boundary.motion().is_none() => Err(Problem::new(
            &here.path,
            format!(
                "the fluid that enters meets the {} `boundaries.{index}` right before the face: its first layer \
                 overlaps it by {depth}, most at {}; move the emitter back, or turn its normal",
                obstacle.name,
                point(at, scene.dimension)
            ),
        )),
        _ => Ok(()),
    }
}

/// Bodies are no nearer than particles of the layers are to each other.
fn clear_of_fluid(scene: &Scene, bodies: &[Particles], here: &Waiting) -> Checked {
    let spacing = f64::from(scene.spacing);
    let near = Near::new(&here.points, spacing);
    for (index, body) in bodies.iter().enumerate() {
        for image in images(scene, here) {
            let (mut nearest, mut at) = (f64::INFINITY, DVec3::ZERO);
            let (low, high) = (here.low + image - spacing, here.high + image + spacing);
            body.lattice.for_each_near(low, high, |x| {
                let distance = near.distance(x - image);
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
    }
    Ok(())
}

/// A face that reaches round a periodic axis fills it with whole cells.
fn clear_of_itself(scene: &Scene, here: &Waiting, index: usize) -> Checked {
    let near = Near::new(&here.points, f64::from(scene.spacing));
    let images = images(scene, here);
    for image in images.iter().skip(1).map(|image| *image - images[0]) {
        overlap(scene, (here, &near, index), (here, index), image)?;
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
    if (is_far && !scene.period().is_any()) || ends_before(a, b) || ends_before(b, a) {
        return Ok(());
    }
    let near = Near::new(&there.points, spacing);
    let (first, second) = (images(scene, here), images(scene, there));
    for image in first.iter().map(|image| *image - second[0]) {
        overlap(scene, (there, &near, other), (here, index), image)?;
    }
    Ok(())
}

/// No particle of one emitter, moved to an image, is nearer to one of another than their layers are.
fn overlap(
    scene: &Scene,
    (there, near, other): (&Waiting, &Near, usize),
    (here, index): (&Waiting, usize),
    image: DVec3,
) -> Checked {
    let distances = here.points.iter().map(|&x| (near.distance(x + image), x));
    let nearest = distances.min_by(|a, b| a.0.total_cmp(&b.0));
    let least = here.inlet.nearest.min(there.inlet.nearest);
    match nearest {
        Some((distance, at)) if distance < least - here.tolerance => {
            let whose = if index == other {
                "its own image".to_owned()
            } else {
                format!("that of `emitters.{other}`")
            };
            let what = format!(
                "overlaps {whose}: two particles are {} apart",
                length(distance, scene.spacing.into())
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
