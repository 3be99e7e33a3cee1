//! The step in a host's world: its entities, its components, its systems.

use std::thread::{self, ThreadId};

use bevy_ecs::{prelude::*, schedule::ScheduleLabel};
use glam::Vec3;
use overfall::{
    Phase, Simulation, Step, StepOutcome,
    boundary::refresh_boundary,
    index::BoundarySamples,
    install,
    scene::{Executor, Iisph, Neighbours, PressureMethod, Scene},
    state::{
        Clock, Densities, Positions,
        particle::{Boundary, BoundaryVolume, Density, Fluid, Position, Velocity},
    },
    step::InstallError,
    take_step,
};

use super::tables::{Start, Tag, tag};
use crate::common::{DAM_PARTICLES, bits, dam, pcisph, run, sesph, simulation, state};

#[derive(Resource, Debug, PartialEq)]
struct HostData(u32);

#[test]
fn a_host_runs_the_step_in_its_own_world() {
    let mut world = World::new();
    world.insert_resource(HostData(7));
    let bystander = world
        .spawn((
            Position(Vec3::splat(0.1)),
            Velocity(Vec3::X),
            Start(Vec3::Y),
        ))
        .id();
    let scene = dam();
    install(&mut world, &scene).expect("a free world");
    let later = world.spawn((Position(Vec3::splat(0.1)), Tag::<0>)).id();
    for step in 1..=25 {
        world.run_schedule(Step);
        let report = world.resource::<StepOutcome>().0.clone().expect("a step");
        assert_eq!((report.step, report.particles), (step, DAM_PARTICLES));
        assert_eq!(report.time, world.resource::<Clock>().time);
    }
    assert_eq!(world.resource::<HostData>(), &HostData(7));
    for entity in [bystander, later] {
        assert_eq!(
            world.get::<Position>(entity),
            Some(&Position(Vec3::splat(0.1)))
        );
    }
    assert_eq!(world.get::<Velocity>(bystander), Some(&Velocity(Vec3::X)));
    let mut alone = simulation(&scene);
    run(&mut alone, 25);
    assert!(bits(&mut world) == bits(alone.world_mut()));
}

#[test]
fn a_second_scene_is_refused_and_the_first_goes_on() {
    let scene = dam();
    let mut simulation = simulation(&scene);
    run(&mut simulation, 1);
    let before = bits(simulation.world_mut());
    let error = install(simulation.world_mut(), &scene).expect_err("it is occupied");
    assert!(matches!(error, InstallError::Occupied), "{error}");
    assert!(bits(simulation.world_mut()) == before);
    run(&mut simulation, 1);
}

#[test]
fn a_refused_scene_leaves_the_world_free() {
    let mut world = World::new();
    let mut scene = dam();
    scene.spacing = -1.0;
    let error = install(&mut world, &scene).expect_err("a negative spacing");
    assert!(matches!(error, InstallError::Scene(_)), "{error}");
    install(&mut world, &dam()).expect("the world is free");
}

#[derive(Resource, Default)]
struct Seen(Vec<f32>);

fn look(densities: Res<Densities>, mut seen: ResMut<Seen>) {
    seen.0 = densities.to_vec();
}

#[test]
fn a_hosts_system_runs_after_the_phase_that_it_asks_for() {
    for executor in [Executor::SingleThreaded, Executor::Parallel] {
        let scene = Scene { executor, ..dam() };
        let mut simulation = simulation(&scene);
        let world = simulation.world_mut();
        world.init_resource::<Seen>();
        world
            .resource_mut::<Schedules>()
            .add_systems(Step, look.after(Phase::Density).before(Phase::Forces));
        run(&mut simulation, 3);
        let world = simulation.world_mut();
        assert_eq!(world.resource::<Seen>().0, **world.resource::<Densities>());
        let mut fluid = world.query_filtered::<&Density, With<Fluid>>();
        let densities: Vec<f32> = fluid.iter(world).map(|density| density.0).collect();
        assert_eq!(world.resource::<Seen>().0, densities);
    }
}

fn look_around(positions: Res<Positions>, densities: Res<Densities>, mut seen: ResMut<Seen>) {
    let heights = positions.points().iter().map(|x| x.y);
    seen.0 = heights
        .zip(densities.iter())
        .map(|(y, rho)| y * rho)
        .collect();
}

#[test]
fn a_hosts_system_may_read_the_particles_beside_the_forces() {
    for pressure in [sesph(), pcisph(), PressureMethod::Iisph(Iisph::default())] {
        for executor in [Executor::SingleThreaded, Executor::Parallel] {
            let scene = Scene {
                executor,
                pressure,
                ..dam()
            };
            let mut simulation = simulation(&scene);
            let world = simulation.world_mut();
            world.init_resource::<Seen>();
            world
                .resource_mut::<Schedules>()
                .add_systems(Step, look_around.in_set(Phase::Forces));
            run(&mut simulation, 3);
            assert_eq!(simulation.world().resource::<Seen>().0.len(), DAM_PARTICLES);
        }
    }
}

/// The stage at which a host's system ran.
#[derive(Resource, Default)]
struct RanIn(Option<ThreadId>);

fn note_the_thread(mut ran: ResMut<RanIn>) {
    ran.0 = Some(thread::current().id());
}

#[test]
fn a_step_runs_in_the_pool_unless_the_host_has_data_bound_to_its_thread() {
    let scene = Scene {
        executor: Executor::SingleThreaded,
        ..dam()
    };
    let mut world = World::new();
    install(&mut world, &scene).expect("a scene");
    world.init_resource::<RanIn>();
    world.schedule_scope(Step, |_, step| {
        step.add_systems(
            note_the_thread
                .after(Phase::Integrate)
                .before(Phase::Reorder),
        );
    });
    take_step(&mut world).expect("a step");
    let here = Some(thread::current().id());
    assert_ne!(world.resource::<RanIn>().0, here);

    world.insert_non_send(std::rc::Rc::new(()));
    world.schedule_scope(Step, |_, step| {
        let bound = |_: NonSend<std::rc::Rc<()>>| {};
        step.add_systems(bound.after(Phase::Integrate).before(Phase::Reorder));
    });
    take_step(&mut world).expect("a step");
    assert_eq!(world.resource::<RanIn>().0, here);
}

/// Rows and steps that a host's system observed.
#[derive(Resource, Default)]
struct Ran(Option<(usize, u64)>);

#[test]
fn a_phase_orders_a_hosts_systems_even_where_it_has_no_stage() {
    // No lists, no reordering.
    let scene = Scene {
        neighbours: Neighbours::Recomputed,
        reorder_interval: 0,
        ..dam()
    };
    for (phase, next, step) in [
        (Phase::FindNeighbours, Phase::Density, 0),
        (Phase::Reorder, Phase::Observe, 1),
    ] {
        let mut simulation = simulation(&scene);
        let world = simulation.world_mut();
        world.init_resource::<Ran>();
        let look = |positions: Res<Positions>, clock: Res<Clock>, mut ran: ResMut<Ran>| {
            ran.0 = Some((positions.rows(), clock.step));
        };
        world
            .resource_mut::<Schedules>()
            .add_systems(Step, look.after(phase).before(next));
        let built = world.schedule_scope(Step, |world, step| step.initialize(world).is_ok());
        assert!(built, "after {phase:?} is nowhere");
        run(&mut simulation, 1);
        let ran = simulation.world().resource::<Ran>();
        assert_eq!(ran.0, Some((DAM_PARTICLES, step)), "{phase:?}");
    }
}

#[test]
fn a_hosts_system_that_conflicts_without_an_order_is_an_error() {
    let mut simulation = simulation(&dam());
    let world = simulation.world_mut();
    world
        .resource_mut::<Schedules>()
        .add_systems(Step, |mut densities: ResMut<Densities>| {
            densities.set_changed()
        });
    let refused = world.schedule_scope(Step, |world, step| step.initialize(world).is_err());
    assert!(refused);
}

#[derive(ScheduleLabel, Clone, Debug, PartialEq, Eq, Hash)]
struct HostFrame;

#[derive(Resource, Default)]
struct Moved(usize);

#[test]
fn change_detection_sees_steps_and_nothing_else() {
    let mut simulation = simulation(&Scene {
        reorder_interval: 3,
        ..dam()
    });
    let world = simulation.world_mut();
    world.init_resource::<Moved>();
    let mut frame = Schedule::new(HostFrame);
    frame.add_systems(
        |fluid: Query<(), (With<Fluid>, Changed<Position>)>, mut moved: ResMut<Moved>| {
            moved.0 = fluid.iter().count();
        },
    );
    world.add_schedule(frame);
    let moved = |simulation: &mut Simulation| {
        simulation.world_mut().run_schedule(HostFrame);
        simulation.world().resource::<Moved>().0
    };
    assert_eq!(moved(&mut simulation), DAM_PARTICLES, "spawned");
    assert_eq!(moved(&mut simulation), 0);
    for _ in 0..4 {
        run(&mut simulation, 1);
        assert_eq!(moved(&mut simulation), DAM_PARTICLES);
        assert_eq!(moved(&mut simulation), 0);
    }
    let (entity, x, _) = state(simulation.world_mut())[5];
    let position = |simulation: &mut Simulation, x: Vec3| {
        simulation
            .world_mut()
            .entity_mut(entity)
            .insert(Position(x));
    };
    position(&mut simulation, Vec3::NAN);
    simulation.step().expect_err("a position that is no number");
    position(&mut simulation, x);
    assert_eq!(moved(&mut simulation), 1, "a refused step changes nothing");
}

#[test]
fn boundary_particles_are_entities_that_no_step_moves() {
    let mut simulation = simulation(&dam());
    let walls = |simulation: &mut Simulation| {
        let world = simulation.world_mut();
        let mut walls = world.query_filtered::<(Entity, &Position), With<Boundary>>();
        let mut walls: Vec<_> = walls.iter(world).map(|(e, x)| (e, *x)).collect();
        walls.sort_by_key(|wall| wall.0);
        walls
    };
    let before = walls(&mut simulation);
    assert!(!before.is_empty());
    run(&mut simulation, 21);
    assert!(walls(&mut simulation) == before);
}

#[test]
fn refreshed_walls_are_those_that_the_host_left() {
    let scene = dam();
    let mut simulation = simulation(&scene);
    run(&mut simulation, 2);
    let world = simulation.world_mut();
    let mut walls = world.query_filtered::<(Entity, &Position), With<Boundary>>();
    let walls: Vec<_> = walls.iter(world).map(|(e, x)| (e, *x)).collect();
    // The far wall is removed; the others are in many tables.
    for (k, (entity, x)) in walls.into_iter().enumerate() {
        if x.0.x > 0.39 {
            world.despawn(entity);
        } else {
            tag(world, entity, k % 16);
        }
    }
    refresh_boundary(world, &scene).expect("walls that fit");
    let mut walls = world.query_filtered::<(&Position, &BoundaryVolume), With<Boundary>>();
    let mut found: Vec<_> = walls
        .iter(world)
        .map(|(x, v)| (x.0.to_array(), v.0))
        .collect();
    let samples = world.resource::<BoundarySamples>().points();
    let mut expected: Vec<_> = samples
        .iter()
        .map(|sample| (sample.truncate().to_array(), sample.w))
        .collect();
    found.sort_by(|a, b| a.partial_cmp(b).expect("numbers"));
    expected.sort_by(|a, b| a.partial_cmp(b).expect("numbers"));
    assert!(found == expected);
    run(&mut simulation, 5);
}
