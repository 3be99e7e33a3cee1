//! Warnings: settings that are allowed but probably mistakes. They are given before the run, with a value that would be
//! right.

use super::limits;
use crate::{
    loading::Size,
    scene::{Scene, SceneError},
};

/// Above these lengths a scene was probably written in millimetres: spacing and extent \[m].
const LARGE_SPACING: f32 = 1.0;
const LARGE_EXTENT: f64 = 500.0;

/// 0.3 times the speed of sound in water, above which it cannot be treated as incompressible \[m/s].
const FASTEST: f32 = 0.3 * 1480.0;

/// Settings of a scene that are probably mistakes. Fails as [`Scene::check`] does.
pub fn warnings(scene: &Scene) -> Result<Vec<String>, SceneError> {
    Ok(of_size(scene, &scene.checked_size()?))
}

pub(super) fn of_size(scene: &Scene, size: &Size) -> Vec<String> {
    let mut warnings = Vec::new();
    let extent = (size.whole_box.1 - size.whole_box.0).max_element();
    if scene.spacing >= LARGE_SPACING || extent >= LARGE_EXTENT {
        warnings.push(format!(
            "the scene is {extent} m long at a spacing of {} m; lengths are in metres, so if these are millimetres, \
             write {} and {}",
            scene.spacing,
            1e-3 * extent,
            1e-3 * scene.spacing,
        ));
    }
    let start = scene.max_initial_speed();
    if start > FASTEST {
        warnings.push(format!(
            "a body starts at {start} m/s; all methods take the fluid for incompressible, which water is up to \
             {FASTEST:.0} m/s, three tenths of its speed of sound"
        ));
    }
    let (low, high) = size.fluid_box;
    warnings.extend(limits::too_long(scene, low.as_vec3(), high.as_vec3()));
    warnings
}
