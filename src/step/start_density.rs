//! How dense a scene's fluid is at its start: what `check` prints, and what is refused.
//!
//! Fluid that is compressed at the start explodes: at half as much again as its rest density no method finds a
//! pressure. The check of places knows about lattices and plain solids alone. What else can bring particles near to
//! each other, or walls near to them (thin parts of meshes, walls that lie side by side), shows here.

use glam::{Vec3, Vec4};

use super::{install::InstallError, start_slabs};
use crate::{
    boundary::{self, BoundarySample, BoundarySamples},
    column::SENTINEL,
    density::DensitySum,
    execution::Execution,
    index,
    material::Material,
    neighbours::Search,
    pairs::{self, Places, Source},
    scene::{Scene, Size, shapes::ParticleSeed},
};

/// Scenes with more particles, of the fluid or of walls, are asked slab by slab.
const MOST_AT_ONCE: f64 = 1e6;

/// Candidates of a mesh up to which its samples are made to ask alone: 2 GB for the time of it.
const MOST_CANDIDATES: f64 = 36e6;

/// The largest error that is let through. Lattices in corners have 0.008, with a support of four spacings 0.08, beside
/// meshes 0.02; half a plate of 0.8 spacings has 0.15.
pub(super) const LARGEST_ERROR: f32 = 0.1;

/// How far the density of the fluid is above the rest density at the start.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct StartDensity {
    /// Largest `max(0, (ρ − ρ0)/ρ0)` [-].
    pub max_error: f32,
    /// The particle that has it [m].
    pub place: Vec3,
    /// Mean over all particles of the same [-].
    pub mean_error: f32,
}

/// Whether a scene of this size is small enough to be asked at once.
pub(super) fn is_small(size: &Size) -> bool {
    size.fluid.max(size.boundary) <= MOST_AT_ONCE
}

/// Of a scene's fluid among its walls. Refuses fluid that starts compressed, unless jitter may be why.
pub(super) fn of(
    scene: &Scene,
    seeds: &[ParticleSeed],
    walls: Option<&BoundarySamples>,
    execution: &Execution,
) -> Result<StartDensity, InstallError> {
    let points = seeds.iter().map(|seed| seed.position.extend(0.0)).collect();
    let errors = errors(scene, points, walls, execution)?;
    let larger = |best: (Vec3, f32), next: &(Vec3, f32)| if next.1 > best.1 { *next } else { best };
    let first = errors.first().copied().unwrap_or_default();
    let (place, max_error) = errors.iter().fold(first, larger);
    let sum: f64 = errors.iter().map(|(_, error)| f64::from(*error)).sum();
    let found = StartDensity {
        max_error,
        place,
        mean_error: (sum / errors.len().max(1) as f64) as f32,
    };
    allowed(scene, found)
}

/// Of a large scene, whose walls' samples are known or not, with the memory of a part of it. None where only a run
/// should take the time and memory to sample its meshes.
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
        None if size.candidates > 0.0 => Some(boundary::sample(scene)?),
        _ => None,
    };
    let known = known.or(sampled.as_deref());
    let count = start_slabs::count(scene, size, known)?;
    let found = start_slabs::of(scene, size.fluid_box, known, count, execution)?;
    allowed(scene, found).map(Some)
}

fn allowed(scene: &Scene, found: StartDensity) -> Result<StartDensity, InstallError> {
    let has_jitter = scene.bodies.iter().any(|body| body.jitter.is_some());
    if found.max_error > LARGEST_ERROR && !has_jitter {
        return Err(InstallError::Compressed(found));
    }
    Ok(found)
}

/// Places [m] with their compression `max(0, (ρ − ρ0)/ρ0)` [-] among each other and walls.
pub(super) fn errors(
    scene: &Scene,
    mut points: Vec<Vec4>,
    walls: Option<&BoundarySamples>,
    execution: &Execution,
) -> Result<Vec<(Vec3, f32)>, InstallError> {
    let material = Material::new(scene);
    let mut index = index::build(scene);
    index
        .rebuild(&points, execution)
        .map_err(InstallError::Fluid)?;
    let mut densities = vec![0.0; points.len()];
    points.push(SENTINEL);
    let fluid = Search::among_themselves(&*index, &points[..densities.len()]);
    let among_walls = walls.map(|walls| Search {
        among: &*walls.index,
        among_points: walls.points(),
        same: false,
        ..fluid
    });
    let places = Places {
        fluid: &points,
        boundary: walls.map_or(&[SENTINEL], |walls| &walls.packed),
        kernel: &material.kernel,
    };
    let source = Source::OnTheSpot(fluid, among_walls);
    pairs::sum(
        &DensitySum::anywhere(&material),
        source,
        places,
        &mut densities,
        execution,
    );
    let error = |density: f32| (density / material.rest_density - 1.0).max(0.0);
    let places = points.iter().map(|x| x.truncate());
    Ok(places.zip(densities.into_iter().map(error)).collect())
}
