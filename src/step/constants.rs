//! Refuses a step of constants and columns that a host has spoilt, where they are known: later a system panics, or
//! particles that are right are at fault.

use bevy_ecs::prelude::*;

use crate::state::{
    Accelerations, CHUNK, Execution, Failure, FailureCause, Material, TOO_LARGE, of_step::OfStep,
};
use rayon::prelude::*;

/// The constants of the fluid as the scene has them.
#[derive(Resource, Debug, Clone, Copy)]
pub(super) struct SceneMaterial(pub(super) Material);

/// Looks at the constants of the fluid (before the first stage).
pub(super) fn check_constants(
    material: Res<Material>,
    of_scene: Res<SceneMaterial>,
    mut failure: ResMut<Failure>,
) {
    if let Some(cause) = refusal(&material, &of_scene.0) {
        failure.record(cause, None);
    }
}

/// What is wrong with constants of a scene that was installed with others.
fn refusal(now: &Material, before: &Material) -> Option<FailureCause> {
    let of = |constant, value: String, wanted| FailureCause::Constant {
        constant,
        value,
        wanted,
    };
    for (constant, value) in [
        ("particle_mass", now.particle_mass),
        ("rest_density", now.rest_density),
    ] {
        if !(value.is_finite() && value > 0.0) {
            return Some(of(constant, value.to_string(), "finite and above 0"));
        }
    }
    if !(now.gravity.abs().max_element() < TOO_LARGE && now.gravity.is_finite()) {
        let value = now.gravity.to_string();
        return Some(of("gravity", value, "finite and below 1e17 m/s²"));
    }
    // Lists, cells and walls are made for these.
    let fixed = "as the scene has it; install another scene to change it";
    let value = match (now, before) {
        _ if now.spacing != before.spacing => ("spacing", format!("{} m", now.spacing)),
        _ if now.kernel != before.kernel => ("kernel", "another".to_owned()),
        _ if now.dimension != before.dimension => ("dimension", "another".to_owned()),
        _ if now.gravity_ramp != before.gravity_ramp => {
            ("gravity_ramp", format!("{} s", now.gravity_ramp))
        }
        _ if now.period != before.period => ("period", "another".to_owned()),
        _ => return None,
    };
    Some(of(value.0, value.1, fixed))
}

/// Looks at what a host may have written to accelerations (before the stage `pressure`).
pub(super) fn check_accelerations(
    accelerations: Res<Accelerations>,
    execution: Res<Execution>,
    mut failure: ResMut<Failure>,
) {
    // A value that is not a number is not below either.
    let bad = |a: &glam::Vec3| !a.abs().cmplt(glam::Vec3::splat(TOO_LARGE)).all();
    let chunks = accelerations.0.par_chunks(CHUNK).enumerate();
    let found = chunks.filter_map(|(chunk, rows)| Some(chunk * CHUNK + rows.iter().position(bad)?));
    if let Some(row) = execution.install(|| found.min()) {
        let quantity = "acceleration";
        failure.record(FailureCause::NotFinite { quantity }, Some(row));
    }
}

/// What a host has spoilt in the middle of a step in which an engine's system panicked, if there is something.
pub(super) fn spoilt(world: &World) -> Option<FailureCause> {
    let of_step = world.get_resource::<OfStep>()?;
    let (material, clock) = (world.get_resource()?, world.get_resource()?);
    of_step.written(material, clock)
}
