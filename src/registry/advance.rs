//! The end of a step: particles move, and the tables take the new state if nothing went wrong.

use bevy_ecs::prelude::*;

use super::columns::lasting;
use crate::{
    boundary::{contact, direct_forcing, moving, room},
    flow::changes,
    gauge,
    integrate::{self, Domain, GuardLimits, Motion},
    scene::{Outside, Scene, TimeStep},
    state::{
        Phase, Product, Stage, Systems, agree, chain, clock, failure::healthy, of_step, transfer,
        wrap,
    },
    time_step::{self, adaptive, roll_back},
};

/// Motion, the failure guard, the new state, the next time step.
pub(super) const STAGE: Stage = Stage {
    needs: &[
        Product::Columns,
        Product::Index,
        Product::Neighbours,
        Product::Density,
        Product::Forces,
        Product::Pressure,
    ],
    invalidates: true,
    install: |world, scene| {
        world.init_resource::<Motion>();
        world.insert_resource(GuardLimits(scene.limits));
        if let Some(bounds) = scene.domain.filter(|_| scene.outside == Outside::Stop) {
            world.insert_resource(Domain(bounds));
        }
        if let TimeStep::Adaptive(_) = scene.time_step {
            roll_back::install(world, lasting(scene));
        }
    },
    bytes: |scene, _| match scene.time_step {
        // All persistent columns once more, with the entities.
        TimeStep::Adaptive(_) => vec![("state to go back to", 8.0 + 36.0)],
        _ => Vec::new(),
    },
    ..Stage::new("integrate", Phase::Integrate, systems)
};

fn systems(scene: &Scene) -> Systems {
    let integrated = if gauge::measures_forces(scene) {
        (integrate::integrate, gauge::keep_velocities).chain()
    } else {
        integrate::integrate.into_configs()
    };
    let moved = if scene.boundaries.is_empty() {
        integrated
    } else if scene.forces_directly() {
        let corrected = (direct_forcing::correct_motion, contact::keep_outside);
        (integrated, corrected.chain()).chain()
    } else {
        (integrated, contact::keep_outside).chain()
    };
    let moved = if scene.period().is_any() {
        (moved, wrap::wrap_end).chain()
    } else {
        moved
    };
    let unwritten = lasting(scene)
        .iter()
        .map(|column| (column.check_unwritten)())
        .collect();
    let guard = (
        transfer::check_rows,
        of_step::check_unwritten,
        chain(unwritten),
        integrate::guard,
    )
        .chain();
    let guard = if moving::is_wanted(scene) && scene.pressure.iterations().is_some() {
        (guard, room::look_for_room.run_if(healthy)).chain()
    } else {
        guard
    };
    let goes_back = matches!(scene.time_step, TimeStep::Adaptive(_));
    let guard = if goes_back {
        (guard, adaptive::detect_shock.run_if(healthy)).chain()
    } else {
        guard
    };
    let accept = accept(scene).run_if(healthy);
    (moved, integrate::measure, guard, agree, accept).chain()
}

/// Completion of a step that succeeded.
fn accept(scene: &Scene) -> Systems {
    let lasting = lasting(scene);
    let mut systems: Vec<Systems> = vec![integrate::keep_account.into_configs()];
    if let TimeStep::Adaptive(_) = scene.time_step {
        systems.push(roll_back::keep_state.into_configs());
        if changes::are_kept(scene) {
            systems.push(changes::forget.into_configs());
        }
        systems.extend(lasting.iter().map(|column| (column.keep)()));
    }
    systems.extend(lasting.iter().map(|column| (column.scatter)()));
    systems.push((clock::advance_clock, of_step::move_on).chain());
    if moving::is_wanted(scene) {
        systems.push(moving::show_walls.into_configs());
    }
    let recovers = scene
        .pressure
        .iterations()
        .is_some_and(|iterations| iterations.recovery < 1.0);
    if recovers {
        systems.push(time_step::choose_recovery_time.into_configs());
    }
    match scene.time_step {
        TimeStep::Fixed(_) => {}
        TimeStep::Cfl(_) => systems.push(time_step::choose_time_step.into_configs()),
        TimeStep::Adaptive(_) => systems.push(adaptive::choose_adaptive_time_step.into_configs()),
    }
    chain(systems)
}
