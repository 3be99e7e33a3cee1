//! Initial compression of particles, and how much of it is accepted.

use glam::{Vec3, Vec4};

use super::error::{Burst, Crowd, InstallError, LARGEST_ERROR, StartDensity};
use crate::{
    density::DensitySum,
    index::{self, BoundarySamples},
    neighbours::Search,
    pairs::{self, Points, Source},
    scene::Scene,
    state::{Execution, Material, SENTINEL},
};

/// Refuses compressed fluid unless jitter may be the cause.
pub(super) fn allowed(scene: &Scene, found: StartDensity) -> Result<StartDensity, InstallError> {
    let jitters = scene.bodies.iter().filter_map(|body| body.jitter);
    let amplitude = jitters.fold(0.0, |most: f32, jitter| most.max(jitter.amplitude));
    if found.max_error > LARGEST_ERROR && amplitude == 0.0 {
        return Err(InstallError::Compressed(found));
    }
    let limit = scene.limits.compression;
    if found.max_error > limit {
        return Err(InstallError::Crowded(Crowd {
            start: found,
            limit,
            amplitude,
        }));
    }
    match burst(scene, &found) {
        Some(burst) if burst.ratio() > LARGEST_BURST => Err(InstallError::Bursts(burst)),
        _ => Ok(found),
    }
}

/// Mean speed over the largest one expected from which fluid that bursts is refused \[-]: single particles are then
/// more than twice as fast as anything that the scene is about.
const LARGEST_BURST: f32 = 0.7;

/// Compression \[-] from which PCISPH throws particles apart: blocks with a jitter of 0.3 to 0.4 spacings had 1 to 14
/// times their energy from falls then.
const CROWDED: f32 = 0.35;

/// A warning for a start that positions which are predicted throw apart.
pub(super) fn thrown(scene: &Scene, found: &StartDensity) -> Option<String> {
    let iterations = scene.pressure.iterations()?;
    (!iterations.is_linear && found.max_error > CROWDED).then(|| {
        format!(
            "the fluid starts up to {:.0} % above its rest density, and PCISPH throws such particles apart; a smaller \
             `jitter.amplitude`, or a method that works density errors off (`pressure: Dfsph`)",
            100.0 * found.max_error
        )
    })
}

/// What an equation of state makes of the density errors of a start. None without one, and in a scene that expects no
/// speed.
pub(super) fn burst(scene: &Scene, found: &StartDensity) -> Option<Burst> {
    let sound_speed = scene.pressure.solver().sound_speed(scene)?;
    let expected = scene.expected_speed();
    let burst = Burst {
        mean_error: found.mean_error,
        sound_speed,
        speed: (2.0 * found.mean_energy).sqrt() as f32,
        expected,
    };
    (expected > 0.0).then_some(burst)
}

/// Distance from a particle's place to the nearest other of some places \[spacings]; infinite if there is none.
pub(super) fn nearest(scene: &Scene, place: Vec3, others: impl Iterator<Item = Vec3>) -> f32 {
    // Of those in one place all but the first are others.
    let mut is_found = false;
    let period = scene.period();
    let squares = others.map(|other| period.nearest(other - place).length_squared());
    let squares = squares.filter(|&square| square > 0.0 || std::mem::replace(&mut is_found, true));
    squares.fold(f32::INFINITY, f32::min).sqrt() / scene.spacing
}

/// Positions \[m] and compression `max(0, (ρ − ρ0)/ρ0)` \[-] of particles, due to each other and to walls.
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
    let places = Points {
        fluid: &points,
        boundary: walls.map_or(&[SENTINEL], |walls| &walls.packed),
        kernel: &material.kernel,
        period: material.period,
    };
    let source = Source::Recomputed(fluid, among_walls);
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
