//! Emitters, boxes that remove, and what is outside the domain.

use std::collections::HashMap;

use glam::{DVec3, I64Vec3};
use smallvec::SmallVec;

use super::bodies::{length, point, sticks_out};
use super::carried;
use super::problem::{Checked, Problem, ensure};
use super::proper::{axes, box_is_proper, is_flat, radius_is_proper};
use super::solids::Obstacle;
use crate::mesh::Mesh;
use crate::sampling::layer_depth;
use crate::scene::shapes::{Inlet, Lattice, rectangle_axes, tolerance};
use crate::scene::{
    BoundaryShape, Dimension, Emitter, EmitterShape, Outside, Scene, TimeStep,
};

/// Most particles of a layer: a larger number is a slip in the units.
const LARGEST_LAYER: f64 = 1e7;

/// Each field of the emitters, and boxes that remove.
pub(super) fn fields(scene: &Scene) -> Checked {
    for (index, emitter) in scene.emitters.iter().enumerate() {
        of_one(scene, emitter, &format!("emitters.{index}"))?;
    }
    for (index, bounds) in scene.outflow.iter().enumerate() {
        let path = format!("outflow.{index}");
        box_is_proper(&path, bounds.min, bounds.max, scene.dimension)?;
    }
    let has_domain = scene.outside == Outside::Stop || scene.domain.is_some();
    ensure(has_domain, "outside", || {
        "nothing is outside of a scene without a `domain`; write `domain: (min: …, max: …)`, or leave `outside` out"
            .to_owned()
    })
}

fn of_one(scene: &Scene, emitter: &Emitter, path: &str) -> Checked {
    let field = |name: &str| format!("{path}.{name}");
    face(scene, &emitter.shape, &field("shape"))?;
    let &Emitter {
        speed, start, end, ..
    } = emitter;
    ensure(speed > 0.0, field("speed"), || {
        format!("the speed is {speed} m/s; it must be above 0 (the normal says where to)")
    })?;
    ensure(start >= 0.0, field("start"), || {
        format!("the fluid enters from {start} s on; it must not be before 0")
    })?;
    ensure(end.is_none_or(|end| end > start), field("end"), || {
        format!(
            "the last of the fluid enters at {} s and the first at {start} s; `end` must be above `start`",
            end.unwrap_or_default()
        )
    })?;
    ensure(emitter.limit != Some(0), field("limit"), || {
        "at most 0 particles enter; the least is 1 (left out, there is no limit)".to_owned()
    })?;
    let amplitude = emitter.jitter.map_or(0.0, |jitter| jitter.amplitude);
    ensure(
        (0.0..0.5).contains(&amplitude),
        field("jitter.amplitude"),
        || {
            format!(
                "the amplitude of the jitter is {amplitude} spacings; it must be from 0 to below 0.5, where \
                 particles could meet"
            )
        },
    )?;
    let limit = 0.5 * scene.support_radius();
    if let TimeStep::Fixed(dt) = scene.time_step {
        ensure(speed * dt <= limit, "time_step", || {
            format!(
                "the fluid of `{path}` enters at {speed} m/s, {:.3e} m in a step of {dt:e} s; it may move half the \
                 support radius, {limit:.3e} m: `Fixed({:.0e})` would do, or `Cfl()`",
                speed * dt,
                0.8 * limit / speed
            )
        })?;
    }
    let inlet = Inlet::new(emitter, scene);
    ensure(!inlet.points.is_empty(), field("shape"), || {
        format!(
            "the face is too small for a particle: it must be at least half a spacing, {} m, wide; make it larger or \
             the spacing smaller",
            0.5 * scene.spacing
        )
    })?;
    ensure(
        inlet.particles(emitter, f64::MAX) > 0,
        field("end"),
        || {
            format!(
                "not one layer of {:.3e} m enters from {start} to {} s at {speed} m/s; `end` must be later",
                inlet.pitch,
                end.unwrap_or_default()
            )
        },
    )
}

fn face(scene: &Scene, shape: &EmitterShape, path: &str) -> Checked {
    let field = |name: &str| format!("{path}.{name}");
    let dimension = scene.dimension;
    is_flat(field("center"), shape.center(), dimension)?;
    is_flat(field("normal"), shape.normal(), dimension)?;
    // The square of a length that is too small, or too large, is none.
    ensure(shape.normal().try_normalize().is_some(), field("normal"), || {
        "the normal is zero, or its square is; it must point where the fluid enters to".to_owned()
    })?;
    let spacing = f64::from(scene.spacing);
    let cells = match *shape {
        EmitterShape::Disc { radius, .. } => {
            radius_is_proper(path, radius)?;
            std::f64::consts::PI * (f64::from(radius) / spacing).powi(axes(dimension) as i32 - 1)
        }
        EmitterShape::Rectangle {
            width, height, up, ..
        } => {
            rectangle(dimension, (width, height), path)?;
            let normal = shape.normal().as_dvec3().normalize_or_zero();
            let flat = dimension == Dimension::Two;
            ensure(!flat || up.is_none(), field("up"), || {
                "in 2-D the face is a segment across the normal; leave `up` out".to_owned()
            })?;
            ensure(
                flat || rectangle_axes(normal, up).is_some(),
                field("up"),
                || "it is zero or along the normal; it must point across it, along the height".to_owned(),
            )?;
            let size = f64::from(width) * height.map_or(spacing, f64::from);
            size / (spacing * spacing)
        }
    };
    ensure(cells <= LARGEST_LAYER, path, || {
        format!(
            "a layer holds {cells:.1e} particles; at most {LARGEST_LAYER:.0e} are possible: make the face smaller or \
             the spacing larger"
        )
    })
}

/// A rectangle has a width, and in 3-D a height.
fn rectangle(dimension: Dimension, (width, height): (f32, Option<f32>), path: &str) -> Checked {
    ensure(width > 0.0, format!("{path}.width"), || {
        format!("the width is {width} m; it must be above 0")
    })?;
    match (dimension, height) {
        (Dimension::Two, None) => Ok(()),
        (Dimension::Two, Some(_)) => Err(Problem::new(
            format!("{path}.height"),
            "in 2-D the face is a segment, of which `width` is the length; leave `height` out",
        )),
        (Dimension::Three, None) => Err(Problem::new(
            path,
            "a rectangle in 3-D has a height, too: write `height: …` (m), and `up: (x, y, z)` for its direction",
        )),
        (Dimension::Three, Some(height)) => ensure(height > 0.0, format!("{path}.height"), || {
            format!("the height is {height} m; it must be above 0")
        }),
    }
}

/// Particles that emitters add until the end of a scene, at most. A domain that removes holds no more than fills it.
pub(super) fn expected(scene: &Scene, fluid: f64) -> f64 {
    let end = f64::from(scene.duration);
    let of = |emitter: &Emitter| Inlet::new(emitter, scene).particles(emitter, end) as f64;
    let all: f64 = scene.emitters.iter().map(of).sum();
    let leaves = scene.outside == Outside::Remove || !scene.outflow.is_empty();
    let Some(domain) = scene.domain.filter(|_| leaves) else {
        return all;
    };
    let counts = (domain.max - domain.min).as_dvec3() / f64::from(scene.spacing);
    let room = counts.to_array()[..axes(scene.dimension)].iter().product::<f64>();
    all.min((room - fluid).max(0.0))
}

/// The particles that wait behind the face of an emitter when it starts.
struct Waiting {
    path: String,
    inlet: Inlet,
    points: Vec<DVec3>,
    /// The box around their centres \[m].
    low: DVec3,
    high: DVec3,
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
        clear_of_fluid(scene, here)?;
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
    let over = sticks_out(scene, (here.low, here.high), (min, max), false);
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
            let over = sticks_out(scene, (here.low, here.high), (min, max), open);
            let half = 0.5 * spacing;
            let outside = (0..axes(scene.dimension)).any(|axis| {
                let lid = if open && axis == 1 { 0.0 } else { thickness };
                here.high[axis] + half <= min[axis] - thickness + here.tolerance
                    || here.low[axis] - half >= max[axis] + lid - here.tolerance
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
        let seam = if obstacle.is_mesh() { 0.01 * spacing } else { 0.0 };
        if let Some((distance, at)) = nearest
            && 0.5 * spacing - distance > here.tolerance + seam
        {
            let what = format!(
                "overlaps the {} `boundaries.{index}` by {}{}",
                obstacle.name,
                length(0.5 * spacing - distance, spacing),
                obstacle.counts_as(spacing)
            );
            return Err(here.problem(&what, at, scene.dimension));
        }
    }
    Ok(())
}

/// Bodies are no nearer than particles of the layers are to each other.
fn clear_of_fluid(scene: &Scene, here: &Waiting) -> Checked {
    let spacing = f64::from(scene.spacing);
    let near = Near::new(&here.points, spacing);
    for (index, body) in scene.bodies.iter().enumerate() {
        let lattice = Lattice::new(&body.shape, spacing, scene.dimension);
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
fn apart(scene: &Scene, (here, index): (&Waiting, usize), (there, other): (&Waiting, usize)) -> Checked {
    let spacing = f64::from(scene.spacing);
    let (a, b) = (&scene.emitters[index], &scene.emitters[other]);
    let ends_before = |a: &Emitter, b: &Emitter| a.end.is_some_and(|end| end <= b.start);
    let is_far = (here.low - spacing).cmpgt(there.high).any() || (here.high + spacing).cmplt(there.low).any();
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
