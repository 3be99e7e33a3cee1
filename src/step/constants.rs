//! Refuses a step of constants and columns that a host has spoilt, where they are known: later a system panics, or
//! particles that are right are at fault.

use bevy_ecs::prelude::*;

use crate::state::{
    Accelerations, CHUNK, Execution, Failure, FailureCause, Material, Positions, Rows, TOO_LARGE,
    Velocities,
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
        _ if now.period != before.period => ("period", "another".to_owned()),
        _ => return None,
    };
    Some(of(value.0, value.1, fixed))
}

/// Looks at what a host may have written to accelerations (before the stage `pressure`).
pub(super) fn check_accelerations(
    accelerations: Res<Accelerations>,
    positions: Res<Positions>,
    rows: Res<Rows>,
    execution: Res<Execution>,
    mut failure: ResMut<Failure>,
) {
    // The engine gives accelerations as many rows as there are positions: those are the cause.
    let rows = rows.entities.len();
    let columns = [
        ("Positions", positions.0.len(), rows + 1),
        ("Accelerations", accelerations.0.len(), rows),
    ];
    let resized = columns.into_iter().find(|column| column.1 != column.2);
    if let Some((column, found, expected)) = resized {
        let cause = FailureCause::Resized {
            column,
            found,
            expected,
        };
        return failure.record(cause, None);
    }
    // A value that is not a number is not below either.
    let bad = |a: &glam::Vec3| !a.abs().cmplt(glam::Vec3::splat(TOO_LARGE)).all();
    let chunks = accelerations.0.par_chunks(CHUNK).enumerate();
    let found = chunks.filter_map(|(chunk, rows)| Some(chunk * CHUNK + rows.iter().position(bad)?));
    if let Some(row) = execution.install(|| found.min()) {
        let quantity = "acceleration";
        failure.record(FailureCause::NotFinite { quantity }, Some(row));
    }
}

/// A column whose length a host has changed in the middle of a step, if there is one.
pub(super) fn resized(world: &World) -> Option<FailureCause> {
    // With the sentinel. Other columns may be as long as in an earlier step.
    let expected = world.get_resource::<Rows>()?.entities.len() + 1;
    let positions = world.get_resource::<Positions>()?.0.len();
    let velocities = world.get_resource::<Velocities>()?.0.len();
    let columns = [("Positions", positions), ("Velocities", velocities)];
    columns.into_iter().find_map(|(column, found)| {
        (found != expected).then_some(FailureCause::Resized {
            column,
            found,
            expected,
        })
    })
}
