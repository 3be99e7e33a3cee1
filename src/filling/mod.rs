//! Fills the bodies of a scene with particles on a square or cubic lattice, with an optional jitter, and leaves out
//! what boundaries have no room for.
//!
//! Everything is computed in f64 and rounded once: the same scene gives the same particles, for any number of threads.

mod last;
mod obstacle;
mod thin;

use glam::DVec2;
use thin::ThinMeshes;

pub(crate) use obstacle::Obstacle;

use crate::mesh::Mesh;
use crate::scene::shapes::{Displacement, Lattice, ParticleSeed, tolerance};
use crate::scene::{Dimension, FluidBody, Scene, Shape};

/// The particles of all bodies of a scene that [`Scene::check`] accepts: body after body, within a body along x
/// first, then y, then z (along a cylinder's axis last), or in the order of a file.
pub fn fluid_particles(scene: &Scene) -> Vec<ParticleSeed> {
    let mut seeds = Vec::new();
    Filling::new(scene).for_each(|seed| seeds.push(seed));
    seeds
}

/// The surfaces of the boundaries that have one; one that cannot be read counts for nothing: the scene's check names
/// it.
fn meshes(scene: &Scene) -> Vec<Option<Mesh>> {
    let boundaries = scene.boundaries.iter();
    boundaries
        .map(|boundary| boundary.mesh(scene.spacing)?.ok())
        .collect()
}

/// The bodies' lattices, cut where they want that; `meshes` are the surfaces of the boundaries.
pub(crate) fn lattices<'a>(
    scene: &'a Scene,
    meshes: &'a [Option<Mesh>],
) -> Box<dyn Iterator<Item = Lattice> + 'a> {
    let whole = |body: &FluidBody| Lattice::of(body, scene.spacing, scene.dimension);
    if !scene.bodies.iter().any(|body| body.cut) {
        return Box::new(scene.bodies.iter().map(whole));
    }
    let make = || {
        let thin = ThinMeshes::new(scene, meshes);
        let of_body = |body: &FluidBody| match body.cut {
            true => cut(whole(body), scene, meshes).cut(|point| thin.leave_room(point)),
            false => whole(body),
        };
        scene.bodies.iter().map(of_body).collect()
    };
    Box::new(last::of(scene, make).into_iter())
}

/// A lattice without the points that boundaries have no room for, apart from those beside thin meshes.
fn cut(lattice: Lattice, scene: &Scene, meshes: &[Option<Mesh>]) -> Lattice {
    let period = scene.period();
    let walls: Vec<_> = (scene.boundaries.iter())
        .map(|boundary| period.unrolled(boundary))
        .collect();
    let obstacles = walls.iter().zip(meshes);
    let obstacles: Vec<_> = obstacles
        .filter_map(|(wall, mesh)| Obstacle::new(wall, mesh.as_ref(), scene))
        .collect();
    let spacing = f64::from(scene.spacing);
    let room = (0.5 - tolerance(0.0, spacing)) * spacing;
    lattice.cut(|point| {
        obstacles
            .iter()
            .all(|obstacle| obstacle.distance(point) >= room)
    })
}

/// The bodies of a scene with their lattices made.
pub(crate) struct Filling<'a> {
    scene: &'a Scene,
    lattices: Vec<Lattice>,
}

impl<'a> Filling<'a> {
    pub(crate) fn new(scene: &'a Scene) -> Self {
        let is_cut = scene.bodies.iter().any(|body| body.cut);
        let meshes = if is_cut { meshes(scene) } else { Vec::new() };
        Self {
            scene,
            lattices: lattices(scene, &meshes).collect(),
        }
    }

    /// Calls `visit` with each particle that [`fluid_particles`] would return, without storing them.
    pub(crate) fn for_each(&self, mut visit: impl FnMut(ParticleSeed)) {
        for number in 0..self.lattices.len() {
            self.for_each_of(number, &mut visit);
        }
    }

    /// The same for one of its bodies.
    pub(crate) fn for_each_of(&self, number: usize, mut visit: impl FnMut(ParticleSeed)) {
        let (body, lattice) = (&self.scene.bodies[number], &self.lattices[number]);
        let spacing = f64::from(self.scene.spacing);
        let velocity_at = body.velocities();
        let period = self.scene.period();
        let mut displace = Displacement::new(body.jitter, spacing, self.scene.dimension);
        let mut number = 0;
        lattice.for_each(|point| {
            let position = point + displace.next();
            visit(ParticleSeed {
                position: period.wrap_exactly(position).as_vec3(),
                velocity: (velocity_at(position) + lattice.velocity(number)).as_vec3(),
            });
            number += 1;
        });
    }
}

/// Most particles of a body, told without making its lattice. Shapes are counted by their lattices, not by volume or
/// area: a needle has particles along all of its length. Fails for a mesh that is too large to be filled.
fn most(body: &FluidBody, scene: &Scene) -> Result<f64, String> {
    let spacing = f64::from(scene.spacing);
    let exponent = i32::from(u8::from(scene.dimension));
    match &body.shape {
        Shape::Mesh(file) => {
            let mesh = file
                .mesh(scene.spacing)
                .map_err(|error| error.to_string())?;
            let (low, high) = mesh.bounds();
            let cells = ((high - low) / spacing).ceil();
            let rows = cells.y * cells.z;
            if rows > MOST_ROWS {
                return Err(format!(
                    "the body has {:.0} million rows of the lattice; at most {:.0} million are looked through: enlarge \
                     the spacing, or `scale` is meant smaller",
                    rows / 1e6,
                    MOST_ROWS / 1e6
                ));
            }
            let surface = mesh.area() / spacing.powi(2);
            Ok((mesh.volume() / spacing.powi(3) + surface).min(cells.element_product()))
        }
        Shape::Particles(file) => Ok(file.particles()?.positions.len() as f64),
        shape => {
            let all = Lattice::new(shape, spacing, scene.dimension).most();
            let filled = volume(shape, scene.dimension) / spacing.powi(exponent);
            let is_round = radius(shape) / spacing > ROUND;
            Ok(if is_round { 1.05 * filled } else { all })
        }
    }
}

/// Particles of a body, told without making its lattice: [`most`], or of one that boundaries cut the share that they
/// leave of a coarser lattice.
pub(crate) fn expected(
    body: &FluidBody,
    scene: &Scene,
    meshes: &[Option<Mesh>],
) -> Result<f64, String> {
    let most = most(body, scene)?;
    if !body.cut {
        return Ok(most);
    }
    let coarser = (most / TRIED)
        .max(1.0)
        .powf(1.0 / f64::from(u8::from(scene.dimension)));
    let tried = Lattice::of(
        body,
        (coarser * f64::from(scene.spacing)) as f32,
        scene.dimension,
    );
    let count = |lattice: &Lattice| {
        let mut points = 0.0;
        lattice.for_each(|_| points += 1.0);
        points
    };
    let all = count(&tried);
    // Where a needle falls between the points of the coarser lattice, all of it counts.
    if all < 0.1 * TRIED.min(most) {
        return Ok(most);
    }
    Ok(most * count(&cut(tried, scene, meshes)) / all)
}

/// Points of a cut body that are tried to find how much of it is left.
const TRIED: f64 = 1e5;

/// Rows of a lattice that are looked through at most.
const MOST_ROWS: f64 = 200e6;

/// Round shapes of so many points across hold their volume in points; smaller ones up to all of their lattice.
const ROUND: f64 = 20.0;

fn radius(shape: &Shape) -> f64 {
    match *shape {
        Shape::Sphere { radius, .. } | Shape::Cylinder { radius, .. } => radius.into(),
        _ => 0.0,
    }
}

/// Volume of a shape \[m³; m² in 2-D]; 0 for what a file says.
pub(crate) fn volume(shape: &Shape, dimension: Dimension) -> f64 {
    use std::f64::consts::PI;
    match (shape, dimension) {
        (&Shape::Box { min, max }, _) => {
            let size = max.as_dvec3() - min.as_dvec3();
            match dimension {
                Dimension::Two => DVec2::new(size.x, size.y).element_product(),
                Dimension::Three => size.element_product(),
            }
        }
        (&Shape::Sphere { radius, .. }, Dimension::Two) => PI * f64::from(radius).powi(2),
        (&Shape::Sphere { radius, .. }, Dimension::Three) => {
            4.0 / 3.0 * PI * f64::from(radius).powi(3)
        }
        (Shape::Mesh(_) | Shape::Particles(_), _) => 0.0,
        (&Shape::Cylinder { start, end, radius }, _) => {
            PI * f64::from(radius).powi(2) * (end.as_dvec3() - start.as_dvec3()).length()
        }
    }
}
