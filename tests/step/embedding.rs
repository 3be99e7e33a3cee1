//! What a host does with a scene: takes it out and installs it again, advances by frames, asks at points, lends threads,
//! adds stages and systems.

use std::sync::Arc;

use bevy_ecs::prelude::*;
use glam::Vec3;
use overfall::{
    Execution, Phase, Simulation, Step, advance,
    gauge::{Gauges, SnapshotError},
    install,
    particle::{Density, Fluid, ParticleId, Position, Pressure, Velocity},
    scene::{
        Adaptive, BoundaryShape, Bounds, Dimension, FluidBody, Gauge, GaugeKind, GaugeReference,
        MeshBoundary, Rate, Scene, Shape, TimeStep,
    },
    step::{
        Accelerations, Clock, FailureCause, InstallError, Product, Stage, StageError, Stages,
        UninstallError, Velocities,
    },
    take_step, uninstall,
};

use super::orders::{STAGES, ordered, unordered};
use crate::common::{bits, bits_after, dam, methods, run, simulation};

/// The bits of positions and velocities, by the particles' numbers.
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

/// Scenes that between them bring every resource, component and schedule that the engine has.
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
    // Bevy's own list of schedules stays where a schedule was.
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
    // A step that fails ends it, and its time is not asked for again.
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

/// Particles nearer than h to a point, by looking at each.
fn near(world: &mut World, point: Vec3, h: f32) -> Vec<Entity> {
    let mut fluid = world.query_filtered::<(Entity, &Position), With<Fluid>>();
    let found = fluid.iter(world).filter(|(_, x)| x.0.distance(point) < h);
    let mut found: Vec<Entity> = found.map(|found| found.0).collect();
    found.sort_unstable();
    found
}

#[test]
fn neighbours_are_those_that_looking_at_each_particle_finds() {
    let flat = Scene {
        dimension: Dimension::Two,
        bodies: vec![FluidBody::new(Shape::cuboid([0.0; 3], [0.5, 0.4, 0.0]))],
        ..Scene::new("flat", 0.02)
    };
    for scene in [dam(), flat] {
        let mut simulation = simulation(&scene);
        let h = scene.support_radius();
        // Before the first step, after it, and with what a host did since.
        for moment in 0..3 {
            match moment {
                1 => run(&mut simulation, 25),
                2 => {
                    let far = Position(Vec3::new(900.0, 0.1, 0.0));
                    simulation.world_mut().spawn((Fluid, far));
                }
                _ => {}
            }
            let snapshot = simulation.snapshot().expect("a scene");
            let particles = snapshot.particles().to_vec();
            for k in 0..20 {
                let particle = particles[k * (particles.len() - 1) / 19];
                let at = simulation
                    .world()
                    .get::<Position>(particle)
                    .expect("a particle")
                    .0;
                let point = at + 0.3 * h * Vec3::new(1.0, -1.0, 0.0);
                let of_point = simulation.neighbours_of(point).expect("a scene");
                assert!(of_point.is_sorted_by(|a, b| a.distance <= b.distance));
                let mut found: Vec<Entity> = of_point.iter().map(|n| n.particle).collect();
                found.sort_unstable();
                assert_eq!(found, near(simulation.world_mut(), point, h));
                let of_particle = simulation.neighbours_of(particle).expect("a scene");
                let mut found: Vec<Entity> = of_particle.iter().map(|n| n.particle).collect();
                found.push(particle);
                found.sort_unstable();
                assert_eq!(found, near(simulation.world_mut(), at, h));
            }
        }
        let nobody = simulation.world_mut().spawn_empty().id();
        let error = simulation.neighbours_of(nobody).expect_err("no place");
        assert_eq!(error, SnapshotError::NoPlace { entity: nobody });
    }
}

#[test]
fn a_constant_is_interpolated_exactly_and_a_linear_field_within_the_fluid() {
    let mut simulation = simulation(&Scene {
        bodies: vec![FluidBody::new(Shape::cuboid([0.0; 3], [0.4; 3]))],
        ..Scene::new("cube", 0.02)
    });
    let world = simulation.world_mut();
    let mut fluid = world.query::<(&Position, &mut Pressure, &mut Density, &mut Velocity)>();
    for (x, mut p, mut rho, mut v) in fluid.iter_mut(world) {
        p.0 = 9810.0 * (0.4 - x.0.y);
        rho.0 = 998.0;
        v.0 = Vec3::new(1.0, 2.0 * x.0.x, 0.0);
    }
    let inside: Vec<Vec3> = (0..20)
        .map(|k| Vec3::splat(0.1 + 0.01 * k as f32))
        .collect();
    let pressures = simulation
        .interpolate::<Pressure>(&inside)
        .expect("a scene");
    let velocities = simulation
        .interpolate::<Velocity>(&inside)
        .expect("a scene");
    for ((at, p), v) in inside.iter().zip(pressures).zip(velocities) {
        assert!(p.neighbours > 20 && p.neighbours == v.neighbours);
        // A lattice is not the same on all sides of a point between its nodes.
        let (p, v) = (p.value.expect("fluid").0, v.value.expect("fluid").0);
        assert!(
            (p - 9810.0 * (0.4 - at.y)).abs() < 9810.0 * 0.001,
            "{at}: {p}"
        );
        assert!(
            (v - Vec3::new(1.0, 2.0 * at.x, 0.0)).length() < 0.002,
            "{at}: {v}"
        );
    }
    // Beside a surface, at it and beyond.
    for x in [0.005, 0.0, -0.02, -0.03, -0.05, 1e6, f32::NAN] {
        let found = simulation.interpolate::<Density>(&[Vec3::new(x, 0.2, 0.2)]);
        let found = found.expect("a scene")[0];
        assert_eq!(found.value.is_some(), found.neighbours > 0);
        assert_eq!(found.neighbours > 0, x > -0.03, "{x}: {}", found.neighbours);
        assert!(found.value.is_none_or(|rho| (rho.0 - 998.0).abs() < 1e-3));
    }
}

#[test]
fn a_gauge_at_the_same_place_shows_the_same() {
    let at = Vec3::new(0.1, 0.1, 0.1);
    let scene = Scene {
        gauges: vec![Gauge::new("p", GaugeKind::Pressure { at, radius: None })],
        reorder_interval: 0,
        ..dam()
    };
    let mut simulation = simulation(&scene);
    run(&mut simulation, 10);
    let found = simulation.interpolate::<Pressure>(&[at]).expect("a scene")[0];
    let gauges = simulation.world().resource::<Gauges>();
    let gauge = gauges.get("p").expect("a gauge");
    let pressure = gauge.value("pressure_Pa").expect("fluid");
    assert!((f64::from(found.value.expect("fluid").0) / pressure - 1.0).abs() < 1e-5);
    assert_eq!(gauge.value("neighbours"), Some(found.neighbours.into()));
}

#[test]
fn rows_and_particles_name_each_other() {
    let mut simulation = simulation(&dam());
    let particles = simulation.snapshot().expect("a scene").particles().to_vec();
    assert_eq!(simulation.row_of(particles[0]), None);
    run(&mut simulation, 3);
    for &particle in particles.iter().step_by(97) {
        let row = simulation.row_of(particle).expect("a row");
        assert_eq!(simulation.entity_of(row), Some(particle));
    }
    assert_eq!(simulation.entity_of(particles.len()), None);
    assert_eq!(simulation.row_of(Entity::PLACEHOLDER), None);
}

#[derive(Resource, Default)]
struct Blown(u32);

fn blow(velocities: Res<Velocities>, mut a: ResMut<Accelerations>, mut blown: ResMut<Blown>) {
    // Gravity was there before, and pressure comes after.
    assert!(a.0.iter().all(|a| a.y < -1.0));
    a.0.iter_mut()
        .zip(&velocities.0)
        .for_each(|(a, v)| a.x += 50.0 - v.x);
    blown.0 += 1;
}

const MY_WIND: Stage = Stage {
    needs: &[Product::Columns],
    makes: &[Product::Forces],
    install: |world, _| _ = world.init_resource::<Blown>(),
    ..Stage::new("my_wind", Phase::Forces, |_| blow.into_configs())
};

fn with_wind(stages: &str) -> Result<Simulation, InstallError> {
    let (scene, _folder) = ordered(stages);
    let mut world = World::new();
    let mut known = Stages::default();
    known.register(MY_WIND).expect("a new name");
    world.insert_resource(known);
    Simulation::in_world(world, &scene)
}

#[test]
fn a_stage_of_the_hosts_runs_where_the_order_names_it() {
    let between = STAGES.replace(r#"Run("pressure")"#, r#"Run("my_wind"), Run("pressure")"#);
    let mut windy = with_wind(&format!("(stages: [{between}])")).expect("an order");
    run(&mut windy, 10);
    assert_eq!(windy.world().resource::<Blown>().0, 10);
    let mut calm = simulation(&unordered());
    run(&mut calm, 10);
    let mean = |simulation: &mut Simulation| {
        let world = simulation.world_mut();
        let mut fluid = world.query_filtered::<&Velocity, With<Fluid>>();
        fluid.iter(world).map(|v| v.0.x).sum::<f32>() / 1200.0
    };
    assert!(mean(&mut windy) > mean(&mut calm) + 0.05);
    // The stages are the host's and stay; what one of them brought goes with the scene.
    uninstall(windy.world_mut()).expect("a scene");
    assert!(windy.world().contains_resource::<Stages>());
    assert!(!windy.world().contains_resource::<Blown>());

    let every_other = STAGES.replace(
        r#"Run("pressure")"#,
        r#"Every(2, [Run("my_wind")]), Run("pressure")"#,
    );
    let left_out = format!(r#"(stages: [{STAGES}], leave_out: ["my_wind"])"#);
    let mut without = with_wind(&left_out).expect("an order");
    run(&mut without, 10);
    assert!(bits(without.world_mut()) == bits(calm.world_mut()));
    for (order, says) in [
        // Not named, too early, in vain, made for every second step alone.
        (format!("(stages: [{STAGES}])"), "my_wind"),
        (
            format!(r#"(stages: [Run("my_wind"), {STAGES}])"#),
            "my_wind",
        ),
        (format!("(stages: [{every_other}])"), "stale"),
        (between.replace("my_wind", "my_wnd"), "my_wnd"),
    ] {
        let order = if order.starts_with('(') {
            order
        } else {
            format!("(stages: [{order}])")
        };
        let error = with_wind(&order).err().map(|error| error.to_string());
        assert!(
            error.as_ref().is_some_and(|error| error.contains(says)),
            "{order}: {error:?}"
        );
    }
}

#[test]
fn a_stage_needs_a_name_of_its_own() {
    let mut stages = Stages::default();
    stages.register(MY_WIND).expect("a new name");
    let taken = |name| Err(StageError::NameIsTaken { name });
    assert_eq!(stages.register(MY_WIND), taken("my_wind"));
    let named = |name| Stage { name, ..MY_WIND };
    assert_eq!(stages.register(named("pressure")), taken("pressure"));
    for name in ["", "my wind", "a-b", "a\n"] {
        assert_eq!(
            stages.register(named(name)),
            Err(StageError::NoName { name })
        );
    }
}

fn push(mut fluid: Query<&mut Velocity, With<Fluid>>) {
    if let Some(mut v) = fluid.iter_mut().next() {
        v.0.x += 0.01;
    }
}

fn lift(mut fluid: Query<&mut Position, With<Fluid>>) {
    if let Some(mut x) = fluid.iter_mut().next() {
        x.0.y += 1e-4;
    }
}

fn heat(mut fluid: Query<&mut Pressure, With<Fluid>>) {
    if let Some(mut p) = fluid.iter_mut().next() {
        p.0 += 1.0;
    }
}

#[test]
fn what_a_step_would_overwrite_is_refused_by_name() {
    type Add = fn(&mut Schedule, Phase, Phase);
    let writers: [(&str, Add); 3] = [
        ("Velocity", |step, after, before| {
            _ = step.add_systems(push.after(after).before(before))
        }),
        ("Position", |step, after, before| {
            _ = step.add_systems(lift.after(after).before(before))
        }),
        ("Pressure", |step, after, before| {
            _ = step.add_systems(heat.after(after).before(before))
        }),
    ];
    for phases in Phase::ALL.windows(2) {
        for (name, add) in writers {
            let mut simulation = simulation(&dam());
            run(&mut simulation, 1);
            let world = simulation.world_mut();
            world.schedule_scope(Step, |_, step| add(step, phases[0], phases[1]));
            let before = simulation.time();
            let is_safe = phases[0] >= Phase::Integrate;
            for _ in 0..2 {
                match simulation.step() {
                    Ok(_) => assert!(is_safe, "{name} after {phases:?}"),
                    Err(error) => {
                        assert!(!is_safe, "{phases:?}: {error}");
                        assert!(
                            matches!(error.cause, FailureCause::Overwritten { component } if component == name),
                            "{error}"
                        );
                        assert!(error.particle.is_some() && simulation.time() == before);
                    }
                }
            }
        }
    }
    // Before the first phase it is what the step starts from.
    let mut simulation = simulation(&dam());
    simulation.world_mut().schedule_scope(Step, |_, step| {
        step.add_systems((push, lift, heat).chain().before(Phase::RebuildIndex));
    });
    run(&mut simulation, 3);
}

#[test]
fn systems_that_conflict_are_an_error_that_names_them() {
    let mut simulation = simulation(&dam());
    run(&mut simulation, 1);
    simulation.world_mut().schedule_scope(Step, |_, step| {
        step.add_systems(push);
    });
    for _ in 0..2 {
        let error = simulation.step().expect_err("a conflict").to_string();
        assert!(
            error.contains("push") && error.contains("Velocity"),
            "{error}"
        );
    }
    // The scene can be taken out, and is well in the next world.
    uninstall(simulation.world_mut()).expect("a scene");
    install(simulation.world_mut(), &dam()).expect("a scene");
    run(&mut simulation, 2);
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
    // What a file may leave out is what a constructor leaves out.
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
