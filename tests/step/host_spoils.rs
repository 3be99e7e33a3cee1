//! A host that removes, spoils or resizes what a step needs, and panics while a scene is installed: an error names what
//! is wrong, nothing panics, and the next attempt works.

use std::panic::{AssertUnwindSafe, catch_unwind};

use bevy_ecs::{component::ComponentId, prelude::*, resource::IsResource};
use glam::Vec3;
use overfall::{
    Execution, Override, Phase, Simulation, Step, advance, apply,
    boundary::{BoundaryError, refresh_boundary},
    checkpoint, install,
    particle::{Boundary, Fluid, Position},
    scene::{Adaptive, Scene, TimeStep},
    step::{Clock, FailureCause, InstallError, Material},
    take_step, uninstall,
};

use crate::common::{bits, bits_after, dam, methods, run, simulation};

/// A small scene.
fn small() -> Scene {
    let text = r#"(
        name: "small",
        dimension: 2,
        spacing: 0.1,
        bodies: [(shape: Box(min: (0, 0, 0), max: (0.6, 0.6, 0)))],
        boundaries: [Tank(min: (0, 0, 0), max: (1, 1, 0), motion: Velocity(velocity: (0.01, 0, 0)))],
        gauges: [(name: "e", kind: Energy)],
    )"#;
    Scene::parse(text, "small.ron", &[]).expect("a scene")
}

fn world() -> World {
    let mut world = World::new();
    world.insert_resource(Execution::new(1).expect("a thread"));
    world
}

fn resources(world: &World) -> Vec<(ComponentId, String)> {
    let named = |(id, info, _): (ComponentId, &bevy_ecs::component::ComponentInfo, _)| {
        (id, info.name().shortname().to_string())
    };
    world.iter_resources().map(named).collect()
}

#[test]
fn a_resource_that_a_host_removes_is_named_and_another_scene_can_be_installed() {
    let adaptive = Scene {
        time_step: TimeStep::Adaptive(Adaptive::default()),
        ..small()
    };
    for scene in [small(), adaptive] {
        let mut world = world();
        let own = resources(&world);
        install(&mut world, &scene).expect("a scene");
        let engines: Vec<_> = resources(&world)
            .into_iter()
            .filter(|resource| !own.contains(resource))
            .collect();
        uninstall(&mut world).expect("a scene");
        assert!(engines.len() > 20);
        // The two that say that a scene is there at all.
        let is_mark = |name: &str| matches!(name, "Installed" | "Labels" | "Schedules");
        for (id, name) in engines.into_iter().filter(|(_, name)| !is_mark(name)) {
            install(&mut world, &scene).expect("a scene");
            take_step(&mut world).expect("a step");
            world.remove_resource_by_id(id);
            for _ in 0..2 {
                let error = take_step(&mut world).expect_err("a resource is gone");
                let FailureCause::LacksResource { resource } = &error.cause else {
                    panic!("{name}: {error}");
                };
                assert_eq!(*resource, name);
            }
            advance(&mut world, 0.1).expect_err("a resource is gone");
            let gravity = Override::parse("gravity=(0, 1, 0)").expect("an override");
            let error = apply(&mut world, &[gravity]).expect_err("a resource is gone");
            assert!(error.to_string().contains(&name), "{error}");
            checkpoint::write(&mut world, &mut Vec::new()).expect_err("a resource is gone");
            uninstall(&mut world).expect("a scene");
        }
        install(&mut world, &scene).expect("a scene");
        take_step(&mut world).expect("a step");
    }
}

/// Entities beside those of resources. Those of resources that were removed stay, for the next of their kind.
fn entities(world: &mut World) -> usize {
    let mut entities = world.query::<EntityRef>();
    let of = |entity: &EntityRef| !entity.contains::<IsResource>();
    entities.iter(world).filter(of).count()
}

#[derive(Resource)]
struct Armed(bool);

fn disarm(armed: &mut Armed) {
    assert!(!std::mem::take(&mut armed.0), "the host's own mistake");
}

#[test]
fn a_hosts_panic_while_a_scene_comes_or_goes_leaves_nothing_behind() {
    let scene = dam();
    let expected = bits_after(&scene, 1, 2);
    for kind in 0..3 {
        let mut world = world();
        world.insert_resource(Armed(true));
        let bystander = world.spawn((Fluid, Position(Vec3::splat(9.0)))).id();
        match kind {
            0 => world.add_observer(|_: On<Add<Fluid>>, mut armed: ResMut<Armed>| {
                disarm(&mut armed);
            }),
            1 => world.add_observer(|_: On<Add<Boundary>>, mut armed: ResMut<Armed>| {
                disarm(&mut armed);
            }),
            _ => world.add_observer(|_: On<Remove<Fluid>>, mut armed: ResMut<Armed>| {
                disarm(&mut armed);
            }),
        };
        let before = (resources(&world), entities(&mut world));
        if kind < 2 {
            let panic = catch_unwind(AssertUnwindSafe(|| install(&mut world, &scene)));
            assert!(panic.is_err());
            let after = (resources(&world), entities(&mut world));
            assert!(before == after, "{before:?}, {after:?}");
            take_step(&mut world).expect_err("no scene");
        } else {
            install(&mut world, &scene).expect("a scene");
            let panic = catch_unwind(AssertUnwindSafe(|| uninstall(&mut world)));
            assert!(panic.is_err());
            uninstall(&mut world).expect("what is left of a scene");
        }
        world.try_despawn(bystander).ok();
        install(&mut world, &scene).expect("the world is free");
        for _ in 0..2 {
            take_step(&mut world).expect("a step");
        }
        let mut found = bits(&mut world);
        let mut expected = expected.clone();
        // Entities have other numbers than in a new world.
        found.sort_unstable();
        expected.sort_unstable();
        assert!(found == expected);
    }
}

#[test]
fn systems_that_the_step_would_lose_are_refused() {
    let mut world = world();
    world.init_resource::<Schedules>();
    let mut schedules = world.resource_mut::<Schedules>();
    schedules.add_systems(Step, || {});
    let error = install(&mut world, &small()).expect_err("a system");
    assert!(matches!(error, InstallError::StepHasSystems { systems: 1 }));
    // A clock of the host's is no scene.
    world.resource_mut::<Schedules>().remove(Step);
    world.insert_resource(Clock::default());
    install(&mut world, &small()).expect("a free world");
    take_step(&mut world).expect("a step");
}

#[test]
fn a_constant_that_is_none_is_named() {
    type Spoil = fn(&mut Material, f32);
    let constants: [(&str, Spoil, &[f32]); 5] = [
        (
            "particle_mass",
            |m, x| m.particle_mass = x,
            &[f32::NAN, f32::INFINITY, 0.0, -1.0],
        ),
        (
            "rest_density",
            |m, x| m.rest_density = x,
            &[f32::NAN, f32::INFINITY, 0.0, -1.0],
        ),
        (
            "gravity",
            |m, x| m.gravity.y = x,
            &[f32::NAN, f32::NEG_INFINITY, 1e30],
        ),
        ("spacing", |m, x| m.spacing = x, &[f32::NAN, 0.0, 1.0]),
        (
            "kernel",
            |m, x| m.kernel.support_radius = x,
            &[f32::NAN, 0.0, 1.0],
        ),
    ];
    for pressure in methods() {
        let mut simulation = simulation(&Scene { pressure, ..dam() });
        run(&mut simulation, 1);
        let good = *simulation.world().resource::<Material>();
        for (name, spoil, values) in constants {
            for &value in values {
                let before = bits(simulation.world_mut());
                spoil(
                    &mut simulation.world_mut().resource_mut::<Material>(),
                    value,
                );
                let error = simulation.step().expect_err("a constant that is none");
                let is_named = matches!(error.cause, FailureCause::Constant { constant, .. } if constant == name);
                assert!(
                    is_named && error.particle.is_none(),
                    "{name}, {value}: {error}"
                );
                assert!(bits(simulation.world_mut()) == before);
                *simulation.world_mut().resource_mut::<Material>() = good;
            }
        }
        run(&mut simulation, 1);
    }
}

#[test]
fn a_time_that_is_none_or_stands_still_is_an_error() {
    let mut simulation = simulation(&small());
    run(&mut simulation, 1);
    let good = *simulation.world().resource::<Clock>();
    for time in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY, 1e20, 1e300] {
        simulation.world_mut().resource_mut::<Clock>().time = time;
        let error = simulation.step().expect_err("no time");
        assert!(matches!(error.cause, FailureCause::Time { .. }), "{error}");
        if !time.is_finite() {
            let error = simulation.advance(0.01).expect_err("no time");
            assert!(matches!(error.cause, FailureCause::Time { .. }), "{error}");
        }
        *simulation.world_mut().resource_mut::<Clock>() = good;
    }
    simulation.world_mut().resource_mut::<Clock>().next_dt = f32::INFINITY;
    let error = simulation.advance(0.01).expect_err("no time step");
    assert!(
        matches!(error.cause, FailureCause::TimeStep { .. }),
        "{error}"
    );
    *simulation.world_mut().resource_mut::<Clock>() = good;
    run(&mut simulation, 1);
    uninstall(simulation.world_mut()).expect("a scene");
    assert_eq!(simulation.time(), 0.0);
}

#[derive(Resource, Default)]
struct Said(Vec<String>);

#[test]
fn what_is_done_between_steps_is_refused_within_one() {
    let mut simulation = simulation(&dam());
    let world = simulation.world_mut();
    world.init_resource::<Said>();
    world.schedule_scope(Step, |_, step| {
        let within = |world: &mut World| {
            let gravity = Override::parse("gravity=(0, 9, 0)").expect("an override");
            let said = vec![
                take_step(world).expect_err("within a step").to_string(),
                advance(world, 1.0).expect_err("within a step").to_string(),
                apply(world, &[gravity])
                    .expect_err("within a step")
                    .to_string(),
                checkpoint::write(world, &mut Vec::new())
                    .expect_err("within a step")
                    .to_string(),
            ];
            world.insert_resource(Said(said));
        };
        step.add_systems(within.after(Phase::Density).before(Phase::Forces));
    });
    run(&mut simulation, 1);
    let said = &simulation.world().resource::<Said>().0;
    assert_eq!(said.len(), 4);
    assert!(
        said.iter().all(|said| said.contains("in the middle of")),
        "{said:?}"
    );
    assert!(bits(simulation.world_mut()) == bits_after(&dam(), 2, 1));
}

#[test]
fn walls_are_taken_over_for_the_installed_scene_alone() {
    let scene = dam();
    let mut simulation = simulation(&scene);
    run(&mut simulation, 1);
    for spacing in [0.0, -1.0, f32::NAN, f32::INFINITY, 1e-30, 0.04] {
        let other = Scene {
            spacing,
            ..scene.clone()
        };
        let error = refresh_boundary(simulation.world_mut(), &other).expect_err("another scene");
        assert!(
            matches!(error, BoundaryError::OtherScene { differs: "spacing" }),
            "{error}"
        );
    }
    refresh_boundary(simulation.world_mut(), &scene).expect("the scene that is installed");
    run(&mut simulation, 1);
    assert!(bits(simulation.world_mut()) == bits_after(&scene, 2, 2));
    // A step without walls cannot take any.
    let open = Scene {
        boundaries: Vec::new(),
        ..scene
    };
    let mut simulation = Simulation::with_threads(&open, 1).expect("a scene");
    simulation
        .world_mut()
        .spawn((Boundary, Position(Vec3::ZERO)));
    let error = refresh_boundary(simulation.world_mut(), &open).expect_err("no walls");
    assert_eq!(error, BoundaryError::NoWalls);
}
