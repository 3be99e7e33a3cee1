//! Density of a scene's fluid at its start: `check` prints it, and too dense a start is refused.
//!
//! Fluid that is compressed at the start explodes: at 1.5 times its rest density no method finds a pressure. The check
//! of positions covers only lattices and solids without meshes. This one also finds particles that are too near to each
//! other or to walls for other reasons, such as thin parts of meshes and walls side by side.

use glam::Vec3;

use super::{
    error::{InstallError, StartDensity},
    start_errors::{allowed, errors, nearest},
};
use crate::{
    index::BoundarySamples,
    loading::Size,
    scene::{Scene, shapes::ParticleSeed},
    state::Execution,
};

/// Scenes with more fluid or boundary particles than this are processed slab by slab, but for periodic ones.
const MOST_AT_ONCE: f64 = 1e6;

/// Whether a scene of this size is processed as a whole.
pub(super) fn is_small(scene: &Scene, size: &Size) -> bool {
    // Slabs do not see across a seam.
    size.fluid.max(size.boundary) <= MOST_AT_ONCE || scene.period().is_any()
}

/// Initial density of a scene's fluid among its walls. Refuses compressed fluid unless jitter may be the cause.
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
    let solver = scene.pressure.solver();
    let energy = errors
        .iter()
        .map(|(_, error)| solver.energy_of_error(scene, *error));
    let energy: f64 = energy.sum();
    let walls = walls.map_or(&[][..], BoundarySamples::points);
    let particles = (seeds.iter().map(|seed| seed.position))
        .chain(walls.iter().map(|sample| sample.truncate()));
    let found = StartDensity {
        max_error,
        place,
        nearest: nearest(scene, place, particles),
        mean_error: (sum / errors.len().max(1) as f64) as f32,
        mean_energy: energy / errors.len().max(1) as f64,
    };
    allowed(scene, found)
}
