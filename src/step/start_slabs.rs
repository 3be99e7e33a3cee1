//! Initial density of a large scene, slab by slab: memory is allocated for one slab at a time.
//!
//! A lattice has its rest density wherever it fills the support. So particles deep inside a body are skipped, except
//! near samples of walls and where jitter moves them.

use std::collections::HashSet;

use glam::{DVec3, IVec3, Vec3, Vec4};

use super::{
    error::{InstallError, StartDensity},
    start_errors::{allowed, errors, nearest},
};
use crate::{
    boundary,
    filling::Filling,
    loading::Size,
    sampling::{self, BoundarySample},
    scene::{FluidBody, Scene, Shape},
    state::Execution,
};

/// Approximate number of particles in a slab, 100 bytes each.
const A_SLAB: f64 = 1e6;

/// A mesh with at most this many candidates is sampled just for this check: 200 MB while it lasts.
const MOST_CANDIDATES: f64 = 6e6;

/// Density of a large scene, with the memory for one slab; `walls` are its samples if they exist already. `None` if
/// only a run should spend the time and memory to sample its meshes.
pub(super) fn of_large(
    scene: &Scene,
    size: &Size,
    known: Option<&[BoundarySample]>,
    execution: &Execution,
) -> Result<Option<StartDensity>, InstallError> {
    if known.is_none() && size.candidates > MOST_CANDIDATES {
        return Ok(None);
    }
    let sampled = match known {
        None if size.candidates > 0.0 => Some(sampling::sample(scene)?),
        _ => None,
    };
    let known = known.or(sampled.as_deref());
    let count = count(scene, size, known)?;
    let found = of(scene, size.fluid_box, known, count, execution)?;
    allowed(scene, found).map(Some)
}

/// Number of slabs for a scene of this size.
fn count(
    scene: &Scene,
    size: &Size,
    known: Option<&[BoundarySample]>,
) -> Result<u32, InstallError> {
    let fluid = Slab::around(scene, size.fluid_box);
    let mut walls = 0.0_f64;
    fluid.for_each_wall(scene, known, |_| walls += 1.0)?;
    Ok((size.fluid.max(walls) / A_SLAB).ceil().max(1.0) as u32)
}

/// Density of a scene in `count` slabs across the longest edge of the box around its fluid. Walls are sampled again for
/// every slab unless their samples are given.
fn of(
    scene: &Scene,
    fluid_box: (DVec3, DVec3),
    known: Option<&[BoundarySample]>,
    count: u32,
    execution: &Execution,
) -> Result<StartDensity, InstallError> {
    let (low, high) = fluid_box;
    let extent = high - low;
    let axis = (0..3).fold(0, |best, k| if extent[k] > extent[best] { k } else { best });
    let border = |k: u32| match k {
        0 => f64::NEG_INFINITY,
        _ if k == count => f64::INFINITY,
        _ => low[axis] + extent[axis] * f64::from(k) / f64::from(count),
    };
    let filling = Filling::new(scene);
    let mut found = StartDensity {
        max_error: 0.0,
        place: low.as_vec3(),
        mean_error: 0.0,
        mean_energy: 0.0,
        nearest: f32::INFINITY,
    };
    let solver = scene.pressure.solver();
    let (mut sum, mut energy, mut particles) = (0.0, 0.0, 0_usize);
    for k in 0..count {
        let slab = Slab {
            axis,
            from: border(k),
            to: border(k + 1),
            ..Slab::around(scene, fluid_box)
        };
        let walls = slab.walls(scene, known)?;
        let (points, targets, all) = slab.particles(scene, &filling, &walls);
        particles += all;
        if targets == 0 {
            continue;
        }
        let walls = boundary::pack(scene, &walls, execution)
            .map_err(InstallError::Boundary)
            .map(|samples| (!walls.is_empty()).then_some(samples))?;
        let errors = errors(scene, points, walls.as_ref(), execution)?;
        let before = found.max_error;
        for (place, error) in &errors[..targets] {
            sum += f64::from(*error);
            energy += solver.energy_of_error(scene, *error);
            if *error > found.max_error {
                (found.max_error, found.place) = (*error, *place);
            }
        }
        if found.max_error > before {
            let walls = walls.iter().flat_map(|walls| walls.points());
            let particles = (errors.iter().map(|(place, _)| *place))
                .chain(walls.map(|sample| sample.truncate()));
            found.nearest = nearest(scene, found.place, particles);
        }
    }
    found.mean_error = (sum / particles.max(1) as f64) as f32;
    found.mean_energy = energy / particles.max(1) as f64;
    Ok(found)
}

/// The part of a scene between two planes \[m].
struct Slab {
    axis: usize,
    from: f64,
    to: f64,
    h: f64,
    spacing: f64,
    /// The box around all fluid.
    fluid_box: (DVec3, DVec3),
}

impl Slab {
    /// A slab that contains all fluid of the scene.
    fn around(scene: &Scene, fluid_box: (DVec3, DVec3)) -> Self {
        Self {
            axis: 0,
            from: f64::NEG_INFINITY,
            to: f64::INFINITY,
            h: f64::from(scene.support_radius()),
            spacing: f64::from(scene.spacing),
            fluid_box,
        }
    }

    fn holds(&self, place: Vec3, margin: f64) -> bool {
        let at = f64::from(place[self.axis]);
        at >= self.from - margin && at < self.to + margin
    }

    /// Wall samples that contribute in the slab, and those that determine the volumes of these.
    fn walls(
        &self,
        scene: &Scene,
        known: Option<&[BoundarySample]>,
    ) -> Result<Vec<BoundarySample>, InstallError> {
        let mut walls = Vec::new();
        self.for_each_wall(scene, known, |sample| walls.push(sample))?;
        Ok(walls)
    }

    fn for_each_wall(
        &self,
        scene: &Scene,
        known: Option<&[BoundarySample]>,
        mut visit: impl FnMut(BoundarySample),
    ) -> Result<(), InstallError> {
        let margin = 2.0 * self.h + self.spacing;
        let (low, high) = (self.fluid_box.0 - margin, self.fluid_box.1 + margin);
        let mut take = |sample: BoundarySample| {
            let place = sample.position.as_dvec3();
            let is_near = place.cmpge(low).all() && place.cmple(high).all();
            if is_near && self.holds(sample.position, margin) {
                visit(sample);
            }
        };
        match known {
            Some(samples) => samples.iter().copied().for_each(take),
            None => sampling::for_each_sample(scene, &mut take)?,
        }
        Ok(())
    }

    /// Particles of the slab that may be compressed, followed by their surroundings; the number of the former; and the
    /// number of all particles in the slab.
    fn particles(
        &self,
        scene: &Scene,
        filling: &Filling,
        walls: &[BoundarySample],
    ) -> (Vec<Vec4>, usize, usize) {
        let near_walls = self.near(walls);
        let (mut points, mut others, mut all) = (Vec::new(), Vec::new(), 0);
        let bodies = scene.bodies.iter().enumerate();
        for (number, body) in bodies.filter(|(_, body)| self.reaches(body)) {
            let frame = body.frame();
            filling.for_each_of(number, |seed| {
                let is_own = self.holds(seed.position, 0.0);
                all += usize::from(is_own);
                if !self.holds(seed.position, self.h + self.spacing) {
                    return;
                }
                let is_shaken = body.jitter.is_some();
                let depth = depth(&body.shape, frame.local(seed.position.as_dvec3()));
                let is_near =
                    || !near_walls.is_empty() && near_walls.contains(&self.cell(seed.position));
                // The lattice may end up to one spacing inside the shape.
                let may_be_compressed =
                    is_shaken || depth <= self.h + 2.0 * self.spacing || is_near();
                if is_own && may_be_compressed {
                    points.push(seed.position.extend(0.0));
                } else if may_be_compressed || depth <= 2.0 * self.h + 4.0 * self.spacing {
                    others.push(seed.position.extend(0.0));
                }
            });
        }
        let targets = points.len();
        points.append(&mut others);
        (points, targets, all)
    }

    /// Whether particles of a body may lie in the slab or beside it.
    fn reaches(&self, body: &FluidBody) -> bool {
        let center = body.frame().place(body.shape.center());
        let reach = f64::from(body.shape.reach());
        let margin = reach + self.h + 2.0 * self.spacing;
        center[self.axis] >= self.from - margin && center[self.axis] <= self.to + margin
    }

    fn cell(&self, place: Vec3) -> IVec3 {
        (place / (2.0 * self.h) as f32).floor().as_ivec3()
    }

    /// Cells within twice the support of samples: particles there are compressed by samples or are neighbours of such
    /// particles.
    fn near(&self, walls: &[BoundarySample]) -> HashSet<IVec3> {
        let own: HashSet<IVec3> = walls.iter().map(|wall| self.cell(wall.position)).collect();
        let around = |cell: &IVec3| {
            let cell = *cell;
            (0..27).map(move |k| cell + IVec3::new(k % 3 - 1, k / 3 % 3 - 1, k / 9 - 1))
        };
        own.iter().flat_map(around).collect()
    }
}

/// Depth of a point inside a shape as it is written \[m].
fn depth(shape: &Shape, place: DVec3) -> f64 {
    match *shape {
        Shape::Box { min, max } => {
            let mut depths = (place - min.as_dvec3()).min(max.as_dvec3() - place);
            if min.z == max.z {
                depths.z = f64::INFINITY;
            }
            depths.min_element()
        }
        Shape::Sphere { center, radius } => f64::from(radius) - place.distance(center.as_dvec3()),
        Shape::Cylinder { start, end, radius } => {
            let (start, end) = (start.as_dvec3(), end.as_dvec3());
            let axis = (end - start).normalize_or_zero();
            let along = (place - start).dot(axis);
            let aside = (place - start - along * axis).length();
            let ends = along.min(start.distance(end) - along);
            ends.min(f64::from(radius) - aside)
        }
        // All of them may be compressed.
        Shape::Mesh(_) | Shape::Particles(_) => 0.0,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::step::start_density;

    /// Slabs give the same density as the whole: with walls between, around and inside bodies, with meshes, with bodies
    /// that touch.
    #[test]
    fn a_scene_in_slabs_starts_as_dense_as_in_one() {
        let execution = Execution::new(2).expect("threads");
        for (dimension, bodies, walls) in [
            (
                3,
                "(shape: Box(min: (0, 0, 0), max: (1.23, 0.62, 0.6)))",
                "",
            ),
            (
                3,
                "(shape: Box(min: (0, 0, 0), max: (0.6, 0.6, 0.6))), (shape: Box(min: (0.6, 0.02, 0), max: (1.2, 0.6, \
                 0.6)))",
                "Tank(min: (0, 0, 0), max: (1.23, 1, 0.6)), Sphere(center: (0.3, 0.8, 0.3), radius: 0.2)",
            ),
            (
                3,
                "(shape: Sphere(center: (0.4, 0.4, 0.4), radius: 0.4)), (shape: Cylinder(start: (1.3, 0.3, 0.3), end: \
                 (2, 0.3, 0.3), radius: 0.3), jitter: (amplitude: 0.1))",
                "Plane(center: (0, 0, 0), normal: (0, 1, 0), half_size: 3)",
            ),
            (
                2,
                "(shape: Box(min: (0, 0, 0), max: (0.6, 2, 0))), (shape: Sphere(center: (1.1, 0.4, 0), radius: 0.4))",
                "Box(min: (0.6, 0, 0), max: (0.66, 2, 0))",
            ),
        ] {
            let text = format!(
                "(name: \"t\", dimension: {dimension}, spacing: 0.04, bodies: [{bodies}], boundaries: [{walls}])"
            );
            let scene = Scene::parse(&text, "t.ron", &[]).unwrap_or_else(|error| panic!("{error}"));
            let size = scene.checked_size().expect("a scene");
            let samples = sampling::sample(&scene).expect("no file");
            let walls = boundary::pack(&scene, &samples, &execution).expect("an index");
            let walls = (!samples.is_empty()).then_some(&walls);
            let seeds = crate::filling::fluid_particles(&scene);
            let whole = start_density::of(&scene, &seeds, walls, &execution).expect("a start");
            for count in [1, 2, 7, 40] {
                for known in [None, Some(&samples[..])] {
                    let found =
                        of(&scene, size.fluid_box, known, count, &execution).expect("a start");
                    let near = |a: f32, b: f32| (a - b).abs() < 2e-6;
                    assert!(
                        near(found.max_error, whole.max_error)
                            && near(found.mean_error, whole.mean_error),
                        "{count} slabs: {found:?} for {whole:?} of {text}"
                    );
                }
            }
        }
    }
}
