//! How dense a scene's fluid is at its start: what `check` prints, and what is refused.
//!
//! Fluid that is compressed at the start explodes: at half as much again as its rest density no method finds a
//! pressure. The check of places knows about lattices and plain solids alone. What else can bring particles near to
//! each other, or walls near to them (thin parts of meshes, walls that lie side by side), shows here.

use glam::Vec4;

use super::error::{InstallError, LARGEST_ERROR, StartDensity};
use crate::{
    density::DensitySum,
    index::{self, BoundarySamples},
    loading::Size,
    neighbours::Search,
    pairs::{self, Places, Source},
    scene::{Scene, shapes::ParticleSeed},
    state::{Execution, Material, SENTINEL},
};

/// Scenes with more particles, of the fluid or of walls, are not asked: it would take memory and time that a run alone
/// should take.
const MOST_PARTICLES: f64 = 1e6;

/// Whether a scene of this size is asked.
pub(super) fn is_asked(size: &Size) -> bool {
    size.fluid.max(size.boundary) <= MOST_PARTICLES
}

/// Of a scene's fluid among its walls. Refuses fluid that starts compressed, unless jitter may be why.
pub(super) fn of(
    scene: &Scene,
    seeds: &[ParticleSeed],
    walls: Option<&BoundarySamples>,
    execution: &Execution,
) -> Result<StartDensity, InstallError> {
    let mut points: Vec<Vec4> = seeds.iter().map(|seed| seed.position.extend(0.0)).collect();
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
    let errors = || {
        densities
            .iter()
            .map(|density| (density / material.rest_density - 1.0).max(0.0))
    };
    let (row, max_error) = errors().enumerate().fold(
        (0, 0.0),
        |best: (usize, f32), (row, error)| if error > best.1 { (row, error) } else { best },
    );
    let sum: f64 = errors().map(f64::from).sum();
    let found = StartDensity {
        max_error,
        place: points[row].truncate(),
        mean_error: (sum / densities.len() as f64) as f32,
    };
    let has_jitter = scene.bodies.iter().any(|body| body.jitter.is_some());
    if max_error > LARGEST_ERROR && !has_jitter {
        return Err(InstallError::Compressed(found));
    }
    Ok(found)
}
