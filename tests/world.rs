//! The step in a host's world: its entities, its components, its systems.

mod common;

use std::thread::{self, ThreadId};

use bevy_ecs::{entity_disabling::Disabled, prelude::*, schedule::ScheduleLabel};
use common::{DAM_PARTICLES, bits, dam, methods, pcisph, run, sesph, simulation, state};
use glam::{IVec3, Vec3};
use overfall::{
    Phase, Simulation, Step, StepOutcome,
    boundary::refresh_boundary,
    index::{BoundarySamples, FluidIndex, z_curve},
    install,
    scene::{
        Executor, Iisph, IndexStructure, Neighbours, PressureMethod, Scene, SurfaceTension,
        TimeStep, Viscosity,
    },
    state::{
        Clock, Densities, Positions,
        particle::{Boundary, BoundaryVolume, Density, Fluid, Position, Pressure, Velocity},
    },
    step::InstallError,
    take_step,
};

/// Components of the host's own. Every set of table components is a table.
#[derive(Component)]
struct Tag<const N: usize>;

#[derive(Component, Clone, Copy, Debug, PartialEq)]
struct Start(Vec3);

#[derive(Component)]
#[component(storage = "SparseSet")]
struct Sparse;

#[derive(Resource, Debug, PartialEq)]
struct HostData(u32);

fn tag(world: &mut World, entity: Entity, tags: usize) {
    let mut particle = world.entity_mut(entity);
    if tags & 1 != 0 {
        particle.insert(Tag::<0>);
    }
    if tags & 2 != 0 {
        particle.insert(Tag::<1>);
    }
    if tags & 4 != 0 {
        particle.insert(Tag::<2>);
    }
    if tags & 8 != 0 {
        particle.insert(Tag::<3>);
    }
    if tags & 16 != 0 {
        particle.insert(Sparse);
    }
}

fn entities(simulation: &mut Simulation) -> Vec<Entity> {
    let state = state(simulation.world_mut());
    state.into_iter().map(|particle| particle.0).collect()
}

/// Lengths of the tables that hold fluid, and the keys of their rows.
fn tables(world: &mut World) -> Vec<Vec<u64>> {
    let mut fluid = world.query_filtered::<&Position, With<Fluid>>();
    let grid = world.resource::<FluidIndex>().structure.grid();
    let cells: Vec<Vec<IVec3>> = fluid
        .contiguous_iter(world)
        .expect("table components")
        .map(|table| {
            table
                .iter()
                .map(|x| grid.cell_of(x.0.extend(0.0)))
                .collect()
        })
        .collect();
    let origin = cells.iter().flatten().copied().fold(IVec3::MAX, IVec3::min);
    let keys = |table: Vec<IVec3>| {
        let key = |cell: &IVec3| z_curve::key(*cell, origin);
        table.iter().map(key).collect()
    };
    cells.into_iter().map(keys).collect()
}

fn along_the_z_curve(keys: &[u64]) -> bool {
    keys.is_sorted() || keys.iter().rev().is_sorted()
}

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

#[test]
fn tables_change_the_results_by_rounding_only() {
    for (pressure, steps, tolerance) in [(sesph(), 24, 1e-5), (pcisph(), 12, 1e-4)] {
        let scene = Scene {
            pressure,
            reorder_interval: 10,
            ..dam()
        };
        let mut plain = simulation(&scene);
        let mut tagged = simulation(&scene);
        for (k, entity) in entities(&mut tagged).into_iter().enumerate() {
            tag(tagged.world_mut(), entity, k % 32);
        }
        assert_eq!(tables(tagged.world_mut()).len(), 16);
        for _ in 0..steps {
            run(&mut plain, 1);
            run(&mut tagged, 1);
        }
        let expected = state(plain.world_mut());
        common::assert_near(&state(tagged.world_mut()), &expected, tolerance);
    }
}

#[test]
fn tagging_between_steps_moves_no_particle() {
    let scene = Scene {
        pressure: sesph(),
        reorder_interval: 5,
        ..dam()
    };
    let mut plain = simulation(&scene);
    let mut tagged = simulation(&scene);
    let entities = entities(&mut tagged);
    for step in 0..20 {
        for (k, &entity) in entities.iter().enumerate().skip(step).step_by(20) {
            tag(tagged.world_mut(), entity, k % 32);
        }
        let before = bits(tagged.world_mut());
        assert_eq!(before.len(), DAM_PARTICLES);
        run(&mut plain, 1);
        run(&mut tagged, 1);
    }
    common::assert_near(
        &state(tagged.world_mut()),
        &state(plain.world_mut()),
        0.05 * scene.spacing,
    );
}

/// A query that saw new tables in one go may go through them in another order than one that saw them in two.
#[test]
fn tables_that_appear_around_a_failed_step_keep_their_particles() {
    let scene = Scene {
        pressure: sesph(),
        reorder_interval: 4,
        ..dam()
    };
    let mut simulation = simulation(&scene);
    run(&mut simulation, 1);
    let entities = entities(&mut simulation);
    for (k, &entity) in entities.iter().enumerate() {
        tag(simulation.world_mut(), entity, k % 4);
    }
    let spoilt = entities[100];
    let position = *simulation
        .world()
        .get::<Position>(spoilt)
        .expect("a particle");
    simulation
        .world_mut()
        .entity_mut(spoilt)
        .insert(Position(Vec3::NAN));
    let error = simulation.step().expect_err("a position that is no number");
    assert_eq!(error.particle.map(|particle| particle.0), Some(spoilt));
    simulation.world_mut().entity_mut(spoilt).insert(position);
    for (k, &entity) in entities.iter().enumerate() {
        tag(simulation.world_mut(), entity, k % 16);
    }
    for _ in 0..8 {
        let before = state(simulation.world_mut());
        run(&mut simulation, 1);
        let after = state(simulation.world_mut());
        common::assert_near(&after, &before, 0.5 * scene.support_radius());
    }
}

#[test]
fn disabled_particles_rest_and_come_back() {
    let scene = Scene {
        pressure: sesph(),
        reorder_interval: 3,
        ..dam()
    };
    let mut simulation = simulation(&scene);
    run(&mut simulation, 2);
    let all = state(simulation.world_mut());
    let (resting, _) = all.split_at(300);
    for (entity, ..) in resting {
        simulation.world_mut().entity_mut(*entity).insert(Disabled);
    }
    for _ in 0..7 {
        let report = simulation.step().expect("a step");
        assert_eq!(report.particles, DAM_PARTICLES - 300);
    }
    for (entity, x, v) in resting {
        let world = simulation.world();
        assert_eq!(world.get::<Position>(*entity), Some(&Position(*x)));
        assert_eq!(world.get::<Velocity>(*entity), Some(&Velocity(*v)));
    }
    let entity = resting[0].0;
    simulation
        .world_mut()
        .entity_mut(entity)
        .insert(Position(Vec3::new(0.35, 0.3, 0.1)))
        .remove::<Disabled>();
    for _ in 0..4 {
        let report = simulation.step().expect("a step");
        assert_eq!(report.particles, DAM_PARTICLES - 299);
    }
    assert_ne!(
        simulation.world().get::<Density>(entity),
        Some(&Density(0.0))
    );
}

#[test]
fn particles_come_and_go_between_steps() {
    for pressure in methods() {
        let scene = Scene {
            pressure,
            reorder_interval: 4,
            ..dam()
        };
        let mut simulation = simulation(&scene);
        let mut alive = DAM_PARTICLES;
        let mut spawned = Vec::new();
        for step in 0..18 {
            let world = simulation.world_mut();
            let victims: Vec<Entity> = state(world)
                .iter()
                .skip(step)
                .step_by(50)
                .map(|p| p.0)
                .collect();
            alive -= victims.len();
            victims.into_iter().for_each(|entity| {
                world.despawn(entity);
            });
            // Drops above the surface, one a corner, each in a table of its own.
            for corner in 0..4 {
                let (i, k) = ((corner % 2) as f32, (corner / 2) as f32);
                let place = Vec3::new(0.28 + 0.08 * i, 0.02 + 0.018 * step as f32, 0.04 + 0.1 * k);
                let drop = world.spawn((Fluid, Position(place))).id();
                tag(world, drop, corner);
                spawned.push((drop, place));
                alive += 1;
            }
            let report = simulation.step().expect("a step");
            assert_eq!(report.particles, alive);
        }
        let state = state(simulation.world_mut());
        assert_eq!(state.len(), alive);
        for (drop, place) in spawned {
            if let Some((_, x, v)) = state.iter().find(|particle| particle.0 == drop) {
                assert!(
                    x.distance(place) < 0.1 && v.is_finite(),
                    "{drop} from {place} at {x}"
                );
                let density = simulation.world().get::<Density>(drop).expect("required").0;
                assert!(density > 0.0);
                assert!(simulation.world().get::<Pressure>(drop).is_some());
            }
        }
    }
}

#[test]
fn reordering_keeps_every_entity_with_its_particle() {
    let run_with = |reorder_interval: u32| {
        let scene = Scene {
            pressure: sesph(),
            reorder_interval,
            ..dam()
        };
        let mut simulation = simulation(&scene);
        for (entity, x, _) in state(simulation.world_mut()) {
            simulation.world_mut().entity_mut(entity).insert(Start(x));
        }
        let started = entities(&mut simulation);
        for step in 1..=24u32 {
            run(&mut simulation, 1);
            if reorder_interval > 0 && step.is_multiple_of(reorder_interval) {
                let tables = tables(simulation.world_mut());
                assert_eq!(tables.len(), 1, "one table and no strays");
                assert!(along_the_z_curve(&tables[0]), "step {step}");
            }
        }
        let world = simulation.world_mut();
        assert_eq!(state(world).len(), started.len());
        let mut query = world.query_filtered::<(&Start, &Position, &Velocity), With<Fluid>>();
        let mut ends: Vec<_> = query
            .iter(world)
            .map(|(start, x, v)| (start.0.to_array().map(f32::to_bits), x.0, v.0))
            .collect();
        ends.sort_by_key(|end| end.0);
        ends
    };
    let never = run_with(0);
    let often = run_with(5);
    let mut moved = 0.0f32;
    for ((start, x, v), (other_start, other_x, other_v)) in never.iter().zip(&often) {
        assert_eq!(start, other_start);
        assert!(x.distance(*other_x) < 1e-4, "{x} and {other_x}");
        assert!(v.distance(*other_v) < 0.1, "{v} and {other_v}");
        moved = moved.max(x.distance(Vec3::from_array(start.map(f32::from_bits))));
    }
    assert!(moved > 1e-3, "nothing moved");
}

#[test]
fn spawned_particles_are_sorted_in_with_the_next_reordering() {
    let scene = Scene {
        pressure: sesph(),
        reorder_interval: 4,
        ..dam()
    };
    let mut simulation = simulation(&scene);
    // So that both sides of the reordering are met.
    for round in 0..3 {
        let world = simulation.world_mut();
        for k in 0..20 {
            let place = Vec3::new(0.3, 0.02 * k as f32, 0.02 + 0.06 * round as f32);
            world.spawn((Fluid, Position(place)));
        }
        run(&mut simulation, 4);
        let tables = tables(simulation.world_mut());
        assert_eq!(tables.len(), 1);
        assert_eq!(tables[0].len(), DAM_PARTICLES + 20 * (round + 1));
        assert!(along_the_z_curve(&tables[0]), "round {round}");
    }
}

#[test]
fn every_table_is_sorted_by_itself() {
    let scene = Scene {
        pressure: sesph(),
        reorder_interval: 4,
        ..dam()
    };
    let mut simulation = simulation(&scene);
    for (k, entity) in entities(&mut simulation).into_iter().enumerate() {
        tag(simulation.world_mut(), entity, k % 4);
    }
    for _ in 0..3 {
        run(&mut simulation, 4);
        let tables = tables(simulation.world_mut());
        assert_eq!(tables.len(), 4);
        assert!(tables.iter().all(|keys| along_the_z_curve(keys)));
    }
}

#[test]
fn a_world_without_fluid_steps_on_and_fills_again() {
    for pressure in methods() {
        for neighbours in [Neighbours::Stored, Neighbours::Recomputed] {
            let scene = Scene {
                pressure,
                neighbours,
                reorder_interval: 2,
                ..dam()
            };
            let mut simulation = simulation(&scene);
            run(&mut simulation, 1);
            for entity in entities(&mut simulation) {
                simulation.world_mut().despawn(entity);
            }
            for _ in 0..3 {
                let report = simulation.step().expect("an empty step");
                assert_eq!(report.particles, 0);
                assert!(report.dt.is_finite() && report.kinetic_energy == 0.0);
                assert!(report.mean_density_error == 0.0 && report.mean_neighbours == 0.0);
            }
            let place = Vec3::new(0.1, 0.3, 0.1);
            let drop = simulation.world_mut().spawn((Fluid, Position(place))).id();
            for _ in 0..3 {
                assert_eq!(simulation.step().expect("a drop").particles, 1);
            }
            assert!(simulation.world().get::<Position>(drop).expect("it").0.y < place.y);
        }
    }
}

#[derive(Resource, Default)]
struct Seen(Vec<f32>);

fn look(densities: Res<Densities>, mut seen: ResMut<Seen>) {
    seen.0.clone_from(&densities.0);
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
        assert_eq!(world.resource::<Seen>().0, world.resource::<Densities>().0);
        let mut fluid = world.query_filtered::<&Density, With<Fluid>>();
        let densities: Vec<f32> = fluid.iter(world).map(|density| density.0).collect();
        assert_eq!(world.resource::<Seen>().0, densities);
    }
}

fn look_around(positions: Res<Positions>, densities: Res<Densities>, mut seen: ResMut<Seen>) {
    let heights = positions.points().iter().map(|x| x.y);
    seen.0 = heights.zip(&densities.0).map(|(y, rho)| y * rho).collect();
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

/// Where a host's system ran.
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

/// Rows and steps that a host's system saw.
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
        .add_systems(Step, |mut densities: ResMut<Densities>| densities.0.clear());
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

/// Four particles a side, quick to set up.
fn small(flat: bool) -> Scene {
    let (dimension, depth) = if flat { (2, 0.0) } else { (3, 0.08) };
    let text = format!(
        r#"(
            name: "small",
            dimension: {dimension},
            spacing: 0.02,
            bodies: [(shape: Box(min: (0, 0, 0), max: (0.08, 0.08, {depth})))],
            boundaries: [Tank(min: (0, 0, 0), max: (0.2, 0.2, {depth}))],
        )"#
    );
    Scene::parse(&text, "small.ron", &[]).expect("a scene")
}

/// Every scene that differs from `scenes` in one field.
fn with<T: Clone>(scenes: Vec<Scene>, values: &[T], set: impl Fn(&mut Scene, T)) -> Vec<Scene> {
    let variants = |scene: Scene| {
        let variant = |value: &T| {
            let mut scene = scene.clone();
            set(&mut scene, value.clone());
            scene
        };
        values.iter().map(variant).collect::<Vec<_>>()
    };
    scenes.into_iter().flat_map(variants).collect()
}

#[test]
fn every_variant_of_a_scene_has_a_schedule_without_ambiguities() {
    let viscosities = [
        Viscosity::None,
        Viscosity::Laminar {
            kinematic_viscosity: 1e-5,
            numerical: 0.2,
        },
        Viscosity::Artificial {
            alpha: 0.05,
            sound_speed: 20.0,
        },
    ];
    let tensions = [
        SurfaceTension::None,
        SurfaceTension::BeckerTeschner { kappa: 0.01 },
    ];
    let pressures: [PressureMethod; 4] = methods();
    let scenes = vec![small(false), small(true)];
    let scenes = with(scenes, &viscosities, |scene, v| scene.fluid.viscosity = v);
    let scenes = with(scenes, &tensions, |scene, t| {
        scene.fluid.surface_tension = t
    });
    let scenes = with(scenes, &pressures, |scene, p| scene.pressure = p);
    let scenes = with(scenes, &[true, false], |scene, solid| {
        if !solid {
            scene.boundaries.clear();
        }
    });
    let lists = [Neighbours::Stored, Neighbours::Recomputed];
    let scenes = with(scenes, &lists, |scene, n| scene.neighbours = n);
    let steps = [TimeStep::default(), TimeStep::Fixed(1e-4)];
    let mut scenes = with(scenes, &steps, |scene, dt| scene.time_step = dt);
    // The others, spread over the variants so far.
    for (k, scene) in scenes.iter_mut().enumerate() {
        scene.reorder_interval = [0, 1][k / 3 % 2];
        scene.executor = [Executor::SingleThreaded, Executor::Parallel][k / 5 % 2];
        scene.index.structure = IndexStructure::ALL[k / 7 % IndexStructure::ALL.len()];
    }
    assert_eq!(scenes.len(), 384);
    for scene in scenes {
        let mut simulation = match Simulation::with_threads(&scene, 1) {
            Ok(simulation) => simulation,
            Err(error) => panic!("{error}: {scene:?}"),
        };
        run(&mut simulation, 2);
    }
}

#[test]
fn every_structure_gives_the_same_with_any_reordering() {
    for reorder_interval in [0, 1, 3] {
        let with = |structure| {
            let mut scene = Scene {
                pressure: sesph(),
                reorder_interval,
                ..dam()
            };
            scene.index.structure = structure;
            let mut simulation = simulation(&scene);
            run(&mut simulation, 12);
            // A host in between: rows come, and go by swapping with the last.
            let world = simulation.world_mut();
            let place = |k: u8| Vec3::new(0.3, 0.01 * f32::from(k), 0.1);
            world.spawn_batch((0..30).map(|k| (Fluid, Position(place(k)))));
            for (entity, ..) in state(world).into_iter().skip(5).step_by(100) {
                world.despawn(entity);
            }
            run(&mut simulation, 5);
            state(simulation.world_mut())
        };
        let expected = with(IndexStructure::BruteForce);
        for structure in IndexStructure::ALL {
            common::assert_near(&with(structure), &expected, 1e-5);
        }
    }
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
    // The far wall goes; the others lie in many tables.
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
