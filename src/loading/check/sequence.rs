//! All checks of a scene in their order.

use super::{
    bodies, body_shapes, carried, emitter_places, emitters, forces, gauges, motions, numbers,
    periodic, pressure,
    problem::Problem,
    size::{self, Size},
    solids, stability,
};
use crate::scene::Scene;

/// From the single numbers to what they make together; each check relies on those before it. Says what room the scene
/// needs.
pub(in crate::loading) fn check(scene: &Scene) -> Result<Size, Problem> {
    numbers::finite(scene)?;
    numbers::numbers(scene)?;
    pressure::parameters(&scene.pressure)?;
    carried::mass(scene)?;
    body_shapes::shapes(scene)?;
    emitters::fields(scene)?;
    forces::velocity_fields(scene)?;
    forces::body_forces(scene)?;
    solids::shapes(scene)?;
    motions::motions(scene)?;
    motions::slip(scene)?;
    stability::least_time_step(scene)?;
    gauges::gauges(scene)?;
    periodic::axes_and_walls(scene)?;
    let meshes = solids::meshes(scene)?;
    let size = size::count(scene, &meshes)?;
    carried::coordinates(scene, &meshes)?;
    motions::courses(scene, &meshes)?;
    let bodies = bodies::places(scene, &meshes)?;
    emitter_places::places(scene, &meshes, &bodies)?;
    Ok(size)
}
