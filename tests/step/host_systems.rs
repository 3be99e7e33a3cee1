//! Misuse by systems of a host in the middle of a step: commands, panics, steps within the pool.

use std::{
    collections::HashMap,
    panic::{AssertUnwindSafe, catch_unwind},
};

use bevy_ecs::prelude::*;
use glam::Vec3;
use overfall::{
    Phase, Simulation, Step, install,
    scene::{Executor, Scene},
    state::{
        Clock, Execution, FailureCause,
        particle::{Fluid, Position},
    },
    take_step,
};

use super::host::{Tag, culprit};
use crate::common::{self, DAM_PARTICLES, bits, dam, run, simulation, state};

/// An action of a host's system in the middle of a step, executed once.
#[derive(Resource, Clone, Copy, PartialEq)]
enum Deed {
    Nothing,
    Spawn,
    Despawn(Entity),
    Tag(Entity),
    Both(Entity),
}

fn interfere(mut deed: ResMut<Deed>, mut commands: Commands) {
    let drop = (Fluid, Position(Vec3::new(0.35, 0.35, 0.1)));
    match std::mem::replace(&mut *deed, Deed::Nothing) {
        Deed::Nothing => {}
        Deed::Spawn => _ = commands.spawn(drop),
        Deed::Despawn(entity) => commands.entity(entity).despawn(),
        Deed::Tag(entity) => _ = commands.entity(entity).insert(Tag),
        // The same number as before.
        Deed::Both(entity) => {
            commands.entity(entity).despawn();
            commands.spawn(drop);
        }
    }
}

#[test]
fn commands_within_a_step_are_refused_and_the_next_step_has_them() {
    let places = [
        (Phase::RebuildIndex, Phase::FindNeighbours),
        (Phase::Density, Phase::Forces),
        (Phase::Forces, Phase::Pressure),
        (Phase::Pressure, Phase::Integrate),
        (Phase::Integrate, Phase::Reorder),
        (Phase::Reorder, Phase::Observe),
    ];
    for executor in [Executor::SingleThreaded, Executor::Parallel] {
        for (after, before) in places {
            for kind in 0..4 {
                let scene = Scene { executor, ..dam() };
                let mut simulation = simulation(&scene);
                run(&mut simulation, 1);
                let victim = culprit(&mut simulation);
                let (deed, count) = match kind {
                    0 => (Deed::Spawn, DAM_PARTICLES + 1),
                    1 => (Deed::Despawn(victim), DAM_PARTICLES - 1),
                    2 => (Deed::Tag(victim), DAM_PARTICLES),
                    _ => (Deed::Both(victim), DAM_PARTICLES),
                };
                let world = simulation.world_mut();
                world.insert_resource(deed);
                world.schedule_scope(Step, |_, step| {
                    step.add_systems(interfere.after(after).before(before));
                });
                let earlier: HashMap<Entity, Vec3> =
                    state(world).iter().map(|p| (p.0, p.1)).collect();
                if let Err(error) = simulation.step() {
                    let cause = &error.cause;
                    assert!(
                        matches!(cause, FailureCause::ParticlesChanged { .. }),
                        "{after:?}, {kind}: {error}"
                    );
                    assert!(before <= Phase::Integrate, "{after:?}, {kind}");
                }
                let report = simulation.step().expect("a step");
                assert_eq!(report.particles, count, "{after:?}, {kind}");
                // Every particle has continued from its position.
                for (entity, x, _) in state(simulation.world_mut()) {
                    if let Some(start) = earlier.get(&entity) {
                        assert!(x.distance(*start) < 0.01, "{entity}: {start} to {x}");
                    }
                }
            }
        }
    }
}

#[derive(Resource)]
struct Armed(bool);

fn explode(mut armed: ResMut<Armed>) {
    assert!(!std::mem::take(&mut armed.0), "the host's own mistake");
}

#[test]
fn after_a_hosts_panic_the_next_step_is_taken_as_if_nothing_had_been() {
    for executor in [Executor::SingleThreaded, Executor::Parallel] {
        for (after, before) in [
            (Phase::RebuildIndex, Phase::FindNeighbours),
            (Phase::Forces, Phase::Pressure),
            (Phase::Pressure, Phase::Integrate),
        ] {
            let scene = Scene { executor, ..dam() };
            let mut simulation = simulation(&scene);
            run(&mut simulation, 2);
            let world = simulation.world_mut();
            world.insert_resource(Armed(true));
            world.schedule_scope(Step, |_, step| {
                step.add_systems(explode.after(after).before(before));
            });
            let as_if_nothing = |simulation: &mut Simulation| {
                let steps = simulation.world().resource::<Clock>().step as usize;
                let expected = common::bits_after(&scene, 2, steps);
                assert!(bits(simulation.world_mut()) == expected);
                steps
            };
            for k in 0..2 {
                simulation.world_mut().resource_mut::<Armed>().0 = true;
                // It shortens no step, and is removed for those that follow.
                let far = simulation.time() + 1.0;
                let panic = catch_unwind(AssertUnwindSafe(|| simulation.step_until(far)));
                assert!(panic.is_err());
                assert_eq!(simulation.world().resource::<Clock>().until, None);
                let steps = as_if_nothing(&mut simulation);
                // Beside other systems it does not stop them.
                let taken = if executor == Executor::Parallel {
                    k + 1
                } else {
                    0
                };
                assert_eq!(steps, 2 + taken, "{executor:?}");
            }
            run(&mut simulation, 3);
            as_if_nothing(&mut simulation);
        }
    }
}

#[test]
fn a_schedule_that_a_panic_lost_is_an_error() {
    let mut simulation = simulation(&dam());
    let world = simulation.world_mut();
    world.insert_resource(Armed(true));
    world.schedule_scope(Step, |_, step| {
        step.add_systems(explode.after(Phase::Forces).before(Phase::Pressure));
    });
    // Not through `take_step`, which would restore the schedule.
    catch_unwind(AssertUnwindSafe(|| world.run_schedule(Step))).expect_err("armed");
    let error = simulation.step().expect_err("a lost schedule");
    assert!(
        matches!(error.cause, FailureCause::NotInstalled { .. }),
        "{error}"
    );
}

#[test]
fn a_step_may_be_taken_within_the_pool_whatever_its_executor() {
    for threads in [1, 2] {
        for executor in [Executor::SingleThreaded, Executor::Parallel] {
            let scene = Scene { executor, ..dam() };
            let mut world = World::new();
            let execution = Execution::new(threads).expect("threads");
            world.insert_resource(execution.clone());
            install(&mut world, &scene).expect("a scene");
            for within in [true, false, true] {
                if within {
                    execution.install(|| take_step(&mut world)).expect("a step");
                } else {
                    take_step(&mut world).expect("a step");
                }
            }
            execution.install(|| world.run_schedule(Step));
            assert!(bits(&mut world) == common::bits_after(&scene, threads, 4));
        }
    }
}
