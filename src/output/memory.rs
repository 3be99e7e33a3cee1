//! Memory that the output of a run takes beside its simulation.

use super::picture::View;
use crate::{
    scene::Scene,
    step::{InstallError, Plan, plan_beside, warnings_beside},
};

/// A number, place, velocity, density and pressure \[bytes].
const FRAME: f64 = 4.0 + 12.0 + 12.0 + 4.0 + 4.0;
/// Place, normal and volume of a boundary particle \[bytes].
const WALLS: f64 = 12.0 + 12.0 + 4.0;

/// Memory that the output of a run of so many particles takes, by what holds it \[bytes]: one frame at a time, and its
/// picture while it is drawn.
pub fn bytes(scene: &Scene, fluid: f64, boundary: f64) -> Vec<(&'static str, f64)> {
    let output = &scene.output;
    let mut bytes = vec![("a frame", FRAME * fluid)];
    // Those that stand are written before the first step.
    if scene.boundaries.iter().any(|wall| wall.motion().is_some()) {
        let more = (WALLS * boundary - FRAME * fluid).max(0.0);
        bytes.push(("walls in motion, in the place of the frame", more));
    }
    if output.pictures {
        let view = View::from_scene(scene);
        bytes.push(("its picture", view.expected_bytes(fluid)));
    }
    bytes.retain(|(_, bytes)| *bytes > 0.0);
    bytes
}

/// Settings of a scene that are probably mistakes. Refuses a scene whose run does not fit into the memory that there
/// is, or into its `memory_limit`, before any is allocated.
///
/// # Errors
/// Those of [`install`](crate::install).
pub fn warnings(scene: &Scene) -> Result<Vec<String>, InstallError> {
    warnings_beside(scene, |fluid, boundary| sum(scene, fluid, boundary))
}

/// The plan of a scene. Refuses a scene whose run does not fit into the memory that there is.
///
/// # Errors
/// Those of [`install`](crate::install).
pub fn plan(scene: &Scene) -> Result<Plan, InstallError> {
    plan_beside(scene, |fluid, boundary| sum(scene, fluid, boundary))
}

fn sum(scene: &Scene, fluid: f64, boundary: f64) -> f64 {
    let parts = bytes(scene, fluid, boundary);
    parts.iter().map(|part| part.1).sum()
}
