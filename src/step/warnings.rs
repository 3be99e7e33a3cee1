//! What a scene may have, but looks like a slip: told before it runs, with the number that would do.

use glam::Vec3;

use crate::{
    loading::Size,
    registry::Stages,
    scene::{Scene, SceneError, TimeStep},
    time_step,
};

/// Lengths from which a scene looks as if it were in millimetres: spacing and extent [m].
const LARGE_SPACING: f32 = 1.0;
const LARGE_EXTENT: f64 = 500.0;

/// Three tenths of the speed of sound in water, from which on it cannot be taken for incompressible [m/s].
const FASTEST: f32 = 0.3 * 1480.0;

/// What looks like a slip in a scene. Fails as [`Scene::check`] does.
pub fn warnings(scene: &Scene) -> Result<Vec<String>, SceneError> {
    Ok(of_size(scene, &scene.checked_size()?))
}

/// The speed that water reaches which falls through the whole height of a box [m/s].
pub(super) fn fall(scene: &Scene, low: Vec3, high: Vec3) -> f32 {
    let along = scene.gravity.normalize_or_zero();
    let height = along.abs().dot((high - low).max(Vec3::ZERO));
    let start = scene.max_initial_speed();
    (2.0 * scene.gravity.length() * height + start * start).sqrt()
}

pub(super) fn of_size(scene: &Scene, size: &Size) -> Vec<String> {
    let mut warnings = Vec::new();
    let extent = (size.whole_box.1 - size.whole_box.0).max_element();
    if scene.spacing >= LARGE_SPACING || extent >= LARGE_EXTENT {
        warnings.push(format!(
            "the scene is {extent} m long at a spacing of {} m; lengths are in metres, so if these are millimetres, write {} and \
             {}",
            scene.spacing,
            1e-3 * extent,
            1e-3 * scene.spacing,
        ));
    }
    let (low, high) = size.fluid_box;
    let fall = fall(scene, low.as_vec3(), high.as_vec3());
    let start = scene.max_initial_speed();
    if start > FASTEST {
        warnings.push(format!(
            "a body starts at {start} m/s; all methods take the fluid for incompressible, which water is up to {FASTEST} m/s, \
             three tenths of its speed of sound"
        ));
    }
    if let TimeStep::Fixed(dt) = scene.time_step {
        let [speed, _] = time_step::motion_limits(0.5, scene.support_radius(), fall, 0.0);
        let certain = Stages::default().certain_limits(scene);
        let expected = ("the fall through the fluid's height", speed.1);
        let least = certain
            .into_iter()
            .chain([expected])
            .min_by(|a, b| a.1.total_cmp(&b.1));
        if let Some((name, limit)) = least.filter(|(_, limit)| dt > *limit) {
            warnings.push(format!(
                "the time step is {dt:e} s; {name} allows {limit:.2e} s at most, so write `time_step: Fixed({:.0e})`, or `Cfl()`",
                0.5 * limit
            ));
        }
    }
    warnings
}
