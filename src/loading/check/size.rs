//! How many particles a scene asks for, and where: told before memory is taken for any.
//!
//! Shapes are counted by their lattices, not by volume or area: a needle has particles along all of its length.

use glam::{DVec3, Vec3};

use super::emitters;
use super::problem::{Checked, Problem, ensure};
use super::proper::axes;
use crate::filling;
use crate::mesh::Mesh;
use crate::sampling;
use crate::scene::shapes::{Inlet, wall_axes};
use crate::scene::{BoundaryShape, Dimension, FluidBody, Scene, Shape};

/// More particles than any machine this is meant for holds; a larger number is a slip in the units.
const MAX_PARTICLES: f64 = 200e6;

/// Columns, index and about 30 neighbours a particle \[bytes]; for orientation only.
const BYTES_A_PARTICLE: f64 = 500.0;

/// What the message offers instead.
const PLENTY: f64 = 10e6;

/// Room that a run needs.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Size {
    /// Fluid particles, at most or, for bodies that boundaries cut, roughly.
    pub(crate) fluid: f64,
    /// Particles that emitters add until the end, at most.
    pub(crate) emitted: f64,
    /// Boundary particles, at most or, for meshes, roughly.
    pub(crate) boundary: f64,
    /// Candidates that the samples of the largest mesh are chosen from.
    pub(crate) candidates: f64,
    /// Whether there are meshes, whose particles are estimated.
    pub(crate) is_estimate: bool,
    /// The box around the fluid \[m].
    pub(crate) fluid_box: (DVec3, DVec3),
    /// The box around fluid and boundaries \[m].
    pub(crate) whole_box: (DVec3, DVec3),
}

/// Counts, and refuses what no machine holds.
pub(super) fn count(scene: &Scene, meshes: &[Option<Mesh>]) -> Result<Size, Problem> {
    let size = measure(scene, meshes)?;
    enough_for_all(scene, &size)?;
    Ok(size)
}

fn measure(scene: &Scene, meshes: &[Option<Mesh>]) -> Result<Size, Problem> {
    let empty = (DVec3::INFINITY, DVec3::NEG_INFINITY);
    let join = |a: (DVec3, DVec3), b: (DVec3, DVec3)| (a.0.min(b.0), a.1.max(b.1));
    let spacing = f64::from(scene.spacing);
    let mut size = Size {
        fluid: 0.0,
        emitted: 0.0,
        boundary: 0.0,
        candidates: 0.0,
        is_estimate: false,
        fluid_box: empty,
        whole_box: empty,
    };
    for (index, body) in scene.bodies.iter().enumerate() {
        let expected = filling::expected(body, scene, meshes);
        size.fluid += expected.map_err(|message| {
            let field = match body.shape {
                Shape::Mesh(_) | Shape::Particles(_) => ".file",
                _ => "",
            };
            Problem::new(format!("bodies.{index}.shape{field}"), message)
        })?;
        size.fluid_box = join(size.fluid_box, box_of_body(body));
    }
    size.whole_box = size.fluid_box;
    // Particles are half a spacing within.
    let half = DVec3::splat(0.5 * spacing).min(0.5 * (size.fluid_box.1 - size.fluid_box.0));
    size.fluid_box = (size.fluid_box.0 + half, size.fluid_box.1 - half);
    for emitter in &scene.emitters {
        let around = Inlet::new(emitter, scene).bounds();
        size.fluid_box = join(size.fluid_box, around);
        size.whole_box = join(size.whole_box, around);
    }
    size.emitted = emitters::expected(scene, size.fluid);
    let depth = if scene.boundaries.is_empty() {
        0.0
    } else {
        sampling::layer_depth(scene)
    };
    let layers = sampling::layer_depths(scene).count() as f64;
    for (shape, mesh) in scene.boundaries.iter().zip(meshes) {
        match mesh {
            Some(mesh) => {
                let (samples, candidates) = sampling::expected_of_mesh(mesh, scene.spacing);
                size.boundary += layers * samples;
                size.candidates = size.candidates.max(candidates);
                size.is_estimate = true;
                size.whole_box = join(size.whole_box, mesh.bounds());
            }
            None => {
                let count = |depth| sampling::count(shape, scene.dimension, scene.spacing, depth);
                size.boundary += sampling::layer_depths(scene).map(count).sum::<f64>();
                let around = box_of_boundary(shape, scene.dimension, f64::from(depth));
                size.whole_box = join(size.whole_box, around);
            }
        }
    }
    Ok(size)
}

fn enough_for_all(scene: &Scene, size: &Size) -> Checked {
    let (fluid, solid) = (size.fluid, size.boundary);
    let total = fluid + solid;
    ensure(total <= MAX_PARTICLES, "spacing", || {
        let dimension = axes(scene.dimension) as i32;
        // A needle's particles go with its length, so less than this would do; it is enough in any case.
        let exponent = if fluid >= solid {
            dimension
        } else {
            dimension - 1
        };
        let better = f64::from(scene.spacing) * (total / PLENTY).powf(1.0 / f64::from(exponent));
        // In three digits, as people write it.
        let better: f64 = format!("{better:.2e}").parse().unwrap_or(better);
        format!(
            "a spacing of {} m makes about {:.0} million particles ({:.0} million of them boundary), which need about \
             {:.0} GB; at most {:.0} million are possible; a spacing of {better} m makes about {:.0} million, or \
             the scene is meant smaller than from {} to {} m",
            scene.spacing,
            total / 1e6,
            solid / 1e6,
            total * BYTES_A_PARTICLE / 1e9,
            MAX_PARTICLES / 1e6,
            PLENTY / 1e6,
            size.whole_box.0.as_vec3(),
            size.whole_box.1.as_vec3(),
        )
    })?;
    ensure(total + size.emitted <= MAX_PARTICLES, "emitters", || {
        format!(
            "emitters add {:.0} million particles until the end at {} s; at most {:.0} million are possible: give them \
             an `end` or a `limit`, or a `domain` beside `outflow`, which holds no more than fills it",
            size.emitted / 1e6,
            scene.duration,
            MAX_PARTICLES / 1e6
        )
    })?;
    ensure(size.candidates <= 36.0 * MAX_PARTICLES, "spacing", || {
        format!(
            "a mesh is sampled with {:.0} million candidates at a spacing of {} m; enlarge the spacing, or cut \
             triangles that are long and thin",
            size.candidates / 1e6,
            scene.spacing
        )
    })
}

/// The box around a body \[m]; that of a file which cannot be read is empty.
pub(super) fn box_of_body(body: &FluidBody) -> (DVec3, DVec3) {
    let (low, high) = match body.shape {
        Shape::Box { min, max } => (min.as_dvec3(), max.as_dvec3()),
        Shape::Sphere { center, radius } => {
            let (center, radius) = (center.as_dvec3(), f64::from(radius));
            (center - radius, center + radius)
        }
        Shape::Cylinder { start, end, radius } => {
            let (start, end, radius) = (start.as_dvec3(), end.as_dvec3(), f64::from(radius));
            (start.min(end) - radius, start.max(end) + radius)
        }
        Shape::Mesh(_) | Shape::Particles(_) => {
            (body.shape.extent_of_file()).unwrap_or((DVec3::INFINITY, DVec3::NEG_INFINITY))
        }
    };
    body.frame().bounds(low, high)
}

/// The samples of a wall lie `depth` \[m] behind its face.
pub(super) fn box_of_boundary(
    shape: &BoundaryShape,
    dimension: Dimension,
    depth: f64,
) -> (DVec3, DVec3) {
    let (low, high) = match *shape {
        BoundaryShape::Tank { min, max, .. } => (min.as_dvec3() - depth, max.as_dvec3() + depth),
        BoundaryShape::Box { min, max, .. } => (min.as_dvec3(), max.as_dvec3()),
        BoundaryShape::Sphere { center, radius, .. } => {
            let (center, radius) = (center.as_dvec3(), f64::from(radius));
            (center - radius, center + radius)
        }
        BoundaryShape::Plane {
            center,
            normal,
            half_size,
            ..
        } => {
            let (along, across) = wall_axes(normal, dimension);
            let across = match dimension {
                Dimension::Two => Vec3::ZERO,
                Dimension::Three => across,
            };
            let reach = f64::from(half_size) * (along.abs() + across.abs()).as_dvec3();
            let center = center.as_dvec3();
            (center - reach, center + reach)
        }
        // Their triangles say.
        BoundaryShape::Mesh(_) | BoundaryShape::Revolution(_) | BoundaryShape::Terrain(_) => {
            return (DVec3::INFINITY, DVec3::NEG_INFINITY);
        }
    };
    shape.frame().bounds(low, high)
}
