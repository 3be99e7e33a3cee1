//! A host's use of a scene: removes it and installs it again, advances by frames, queries points, lends threads, adds
//! stages and systems.

use std::sync::Arc;

use bevy_ecs::prelude::*;
use glam::Vec3;
use overfall::{
    Execution, Phase, Simulation, Step, advance, install,
    particle::{Fluid, ParticleId, Position, Velocity},
    scene::{
        Adaptive, BoundaryShape, Bounds, FluidBody, Gauge, GaugeKind, GaugeReference, MeshBoundary,
        Rate, Scene, Shape, TimeStep,
    },
    step::{Clock, FailureCause, UninstallError},
    take_step, uninstall,
};

use super::orders::unordered;
use crate::common::{bits, bits_after, dam, methods, run, simulation};

/// The bits of positions and velocities, by particle number.
fn bits_by_number(world: &mut World) -> Vec<(ParticleId, [u32; 6])> {
    let mut fluid = world.query_filtered::<(&ParticleId, &Position, &Velocity), With<Fluid>>();
    let bits = fluid.iter(world).map(|(id, x, v)| {
        let numbers = [x.0.x, x.0.y, x.0.z, v.0.x, v.0.y, v.0.z];
        (*id, numbers.map(f32::to_bits))
    });
    let mut bits: Vec<_> = bits.collect();
    bits.sort_unstable();
    bits
}

#[derive(Resource, Debug, PartialEq)]
struct Score(u32);

/// Scenes that together use every resource, component and schedule of the engine.
fn all_kinds() -> Vec<Scene> {
    let with = |change: fn(&mut Scene)| {
        let mut scene = dam();
        change(&mut scene);
        scene
    };
    let of_method = methods().map(|pressure| Scene { pressure, ..dam() });
    let others = [
        with(|scene| scene.time_step = TimeStep::Adaptive(Adaptive::default())),
        with(|scene| scene.boundaries.clear()),
        with(|scene| {
            scene.boundaries[0] = scene.boundaries[0].clone().named("tank");
            let load = GaugeKind::Force {
                boundary: "tank".to_owned(),
                about: Vec3::ZERO,
            };
            scene.gauges = vec![
                Gauge::new("load", load),
                Gauge::new("energy", GaugeKind::Energy),
            ];
        }),
    ];
    of_method.into_iter().chain(others).collect()
}

#[test]
fn a_scene_that_is_taken_out_leaves_nothing_and_the_next_runs_as_in_a_new_world() {
    let names = |world: &World| {
        let all = world
            .iter_resources()
            .map(|(_, info, _)| info.name().to_string());
        let mut all: Vec<String> = all.collect();
        all.sort();
        all
    };
    let mut world = World::new();
    world.insert_resource(Execution::new(2).expect("threads"));
    world.insert_resource(Score(7));
    let own = world.spawn(Position(Vec3::ONE)).id();
    // bevy's own list of schedules remains after a schedule is removed.
    world.init_resource::<Schedules>();
    let before = names(&world);
    for scene in all_kinds() {
        let mut fresh = World::new();
        fresh.insert_resource(Execution::new(2).expect("threads"));
        install(&mut fresh, &scene).expect("a scene");
        install(&mut world, &scene).expect("a scene");
        for world in [&mut fresh, &mut world] {
            for _ in 0..5 {
                take_step(world).expect("a step");
            }
        }
        assert!(bits_by_number(&mut world) == bits_by_number(&mut fresh));
        world.spawn((Fluid, Position(Vec3::splat(0.3))));
        assert_eq!(uninstall(&mut world), Ok(()));
        assert_eq!(names(&world), before);
        let mut places = world.query::<(Entity, &Position)>();
        let left: Vec<Entity> = places.iter(&world).map(|found| found.0).collect();
        assert_eq!(left, [own]);
        assert!(!world.resource::<Schedules>().contains(Step));
        assert_eq!(uninstall(&mut world), Err(UninstallError::NotInstalled));
        let error = take_step(&mut world).expect_err("no scene");
        assert!(matches!(error.cause, FailureCause::NotInstalled { .. }));
    }
    assert_eq!(world.resource::<Score>(), &Score(7));
}

#[test]
fn a_system_of_the_step_cannot_take_the_scene_away() {
    #[derive(Resource)]
    struct Said(Result<(), UninstallError>);
    let mut simulation = simulation(&dam());
    let world = simulation.world_mut();
    world.insert_resource(Said(Ok(())));
    world.schedule_scope(Step, |_, step| {
        let take_away = |world: &mut World| {
            let said = uninstall(world);
            world.insert_resource(Said(said));
        };
        step.add_systems(take_away.after(Phase::Density).before(Phase::Forces));
    });
    simulation.step().expect("a step");
    let said = simulation.world().resource::<Said>().0;
    assert_eq!(said, Err(UninstallError::WithinStep));
    uninstall(simulation.world_mut()).expect("between steps");
}

#[test]
fn frames_add_up_to_whole_steps_whatever_their_length() {
    for dt in [1e-3, 3.7e-4] {
        let scene = Scene {
            time_step: TimeStep::Fixed(dt),
            ..unordered()
        };
        for frame in [1e-4, 1.0 / 60.0, f64::from(dt), 2.5 * f64::from(dt)] {
            let mut simulation = simulation(&scene);
            let (mut asked, mut steps) = (0.0, 0);
            while asked < 0.01 {
                let done = simulation.advance(frame).expect("steps");
                asked += frame;
                steps += done.steps;
                assert!((-1e-9..f64::from(dt)).contains(&done.rest), "{}", done.rest);
                assert!((simulation.time() + done.rest - asked).abs() < 1e-9);
                assert_eq!(done.report.is_some(), done.steps > 0);
            }
            assert_eq!(
                simulation.world().resource::<Clock>().step,
                u64::from(steps)
            );
            let expected = bits_after(&scene, 2, steps as usize);
            assert!(bits(simulation.world_mut()) == expected, "{dt}, {frame}");
        }
    }
}

#[test]
fn a_time_that_is_none_is_an_error_and_nothing_happens() {
    let mut simulation = simulation(&dam());
    for seconds in [-1e-9, f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
        let error = simulation.advance(seconds).expect_err("no time");
        assert!(
            matches!(error.cause, FailureCause::Seconds { .. }),
            "{error}"
        );
    }
    assert_eq!(simulation.time(), 0.0);
    let error = advance(&mut World::new(), 0.1).expect_err("no scene");
    assert!(
        matches!(error.cause, FailureCause::NotInstalled { .. }),
        "{error}"
    );
    // A failing step ends the call, and its time is not requested again.
    simulation.world_mut().resource_mut::<Clock>().next_dt = f32::NAN;
    let error = simulation.advance(0.1).expect_err("no time step");
    assert!(
        matches!(error.cause, FailureCause::TimeStep { .. }),
        "{error}"
    );
    simulation.world_mut().resource_mut::<Clock>().next_dt = 1e-3;
    assert_eq!(simulation.advance(0.0).expect("no steps").steps, 0);
}

#[test]
fn a_pool_of_the_hosts_gives_the_same_bits() {
    let expected = bits_after(&dam(), 1, 5);
    for threads in [1, 3] {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
        let pool = Arc::new(pool.expect("threads"));
        let mut world = World::new();
        world.insert_resource(Execution::with_pool(pool.clone()));
        let mut simulation = Simulation::in_world(world, &dam()).expect("a scene");
        run(&mut simulation, 5);
        assert!(bits(simulation.world_mut()) == expected);
        let execution = simulation.world().resource::<Execution>();
        assert!(Arc::ptr_eq(execution.pool(), &pool));
        assert_eq!(execution.threads(), threads);
    }
}

#[test]
fn a_scene_from_code_is_the_one_that_its_file_gives() {
    let mut full = Scene {
        bodies: vec![
            FluidBody::new(Shape::cuboid([0.1; 3], [0.3; 3])),
            Shape::sphere([0.6, 0.6, 0.6], 0.1).into(),
        ],
        boundaries: vec![
            BoundaryShape::tank([0.0; 3], [1.0; 3]).named("tank"),
            BoundaryShape::cuboid([0.7, 0.0, 0.7], [0.8, 0.2, 0.8]),
            BoundaryShape::sphere([0.5, 0.2, 0.8], 0.1),
            BoundaryShape::plane([0.5, 0.4, 0.2], [0.0, 1.0, 0.0], 0.1),
        ],
        domain: Some(Bounds::new([-1.0; 3], [2.0; 3])),
        gauges: vec![Gauge {
            every: Rate::Seconds(0.01),
            ..Gauge::new(
                "p",
                GaugeKind::Pressure {
                    at: Vec3::splat(0.2),
                    radius: None,
                },
            )
        }],
        ..Scene::new("full", 0.05)
    };
    for pressure in methods() {
        full.pressure = pressure;
        let text = full.to_ron().expect("RON");
        assert_eq!(Scene::parse(&text, "full.ron", &[]).expect("a scene"), full);
    }
    // A constructor omits the same fields as a file may.
    let parse = |text| Scene::parse(text, "x.ron", &[]).expect("a scene");
    let file = parse(
        r#"(name: "x", spacing: 0.1, bodies: [(shape: Box(min: (0, 0, 0), max: (1, 1, 1)))],
            boundaries: [Tank(min: (0, 0, 0), max: (2, 2, 1), open: true)])"#,
    );
    let code = Scene {
        bodies: vec![FluidBody::new(Shape::cuboid([0.0; 3], [1.0; 3]))],
        boundaries: vec![BoundaryShape::open_tank([0.0; 3], [2.0, 2.0, 1.0])],
        ..Scene::new("x", 0.1)
    };
    assert_eq!(file, code);
    let mesh: MeshBoundary = ron::from_str("(file: \"a.obj\")").expect("a mesh");
    assert_eq!(mesh, MeshBoundary::new("a.obj"));
    let gauge: Gauge = ron::from_str("(name: \"e\", kind: Energy)").expect("a gauge");
    assert_eq!(gauge, Gauge::new("e", GaugeKind::Energy));
    let reference: GaugeReference = ron::from_str("(file: \"a.csv\")").expect("a reference");
    assert_eq!(reference, GaugeReference::new("a.csv"));
}
