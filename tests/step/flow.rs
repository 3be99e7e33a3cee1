//! Fluid that enters and leaves: identities, determinism, checkpoints, roll-back, orders, and scenes without any.

use std::collections::HashSet;

use bevy_ecs::prelude::*;
use glam::Vec3;
use overfall::{
    Simulation, StepReport,
    checkpoint::Checkpoint,
    scene::{Dfsph, Executor, IndexStructure, Neighbours, PressureMethod, Scene, TimeStep},
    state::{
        Clock,
        particle::{Fluid, ParticleId, Position, Velocity},
    },
    step::Order,
};

use crate::common::{self, methods, run, sesph, simulation};

/// Two jets into a tank of which a box drinks, with drops that leave the domain; every few steps something enters, and
/// soon something leaves, too.
/// All methods but δ-SPH, which takes no emitters.
fn fed() -> impl Iterator<Item = PressureMethod> {
    methods().into_iter().take(4)
}

fn scene(pressure: PressureMethod, time_step: &str) -> Scene {
    let text = format!(
        r#"(
            name: "flow",
            dimension: 2,
            spacing: 0.02,
            bodies: [(shape: Box(min: (0, 0, 0), max: (0.3, 0.1, 0)))],
            emitters: [
                (shape: Disc(center: (0.1, 0.3, 0), normal: (0, -1, 0), radius: 0.04), speed: 2,
                    jitter: (amplitude: 0.1, seed: 3)),
                (shape: Rectangle(center: (0.44, 0.2, 0), normal: (1, 0.2, 0), width: 0.09), speed: 3, start: 0.004,
                    end: 0.05, limit: 27),
            ],
            boundaries: [Tank(min: (0, 0, 0), max: (0.3, 0.5, 0), open: true)],
            outflow: [(min: (0.2, -0.1, 0), max: (0.31, 0.06, 0))],
            domain: (min: (-0.1, -0.1, 0), max: (0.56, 0.6, 0)),
            outside: Remove,
            time_step: {time_step},
            reorder_interval: 7,
        )"#
    );
    let scene = Scene::parse(&text, "flow.ron", &[]);
    let mut scene = scene.unwrap_or_else(|error| panic!("{error}"));
    scene.pressure = pressure;
    scene
}

const CFL: &str = "Cfl(max: 0.001)";

/// Numbers, positions and velocities in the order of the rows.
fn rows(world: &mut World) -> Vec<[u32; 7]> {
    let mut fluid = world.query_filtered::<(&ParticleId, &Position, &Velocity), With<Fluid>>();
    let of = |(id, x, v): (&ParticleId, &Position, &Velocity)| {
        let [x, v] = [x.0, v.0].map(|x| x.to_array().map(f32::to_bits));
        [id.get(), x[0], x[1], x[2], v[0], v[1], v[2]]
    };
    fluid.iter(world).map(of).collect()
}

/// Steps that must succeed; the parts of their reports that do not depend on the machine.
fn reports(simulation: &mut Simulation, steps: usize) -> Vec<StepReport> {
    let report = |_| {
        let mut report = simulation.step().unwrap_or_else(|error| panic!("{error}"));
        report.phase_seconds = Default::default();
        report
    };
    (0..steps).map(report).collect()
}

#[test]
fn every_particle_is_counted_and_numbers_are_never_given_again() {
    for pressure in fed() {
        let mut simulation = simulation(&scene(pressure, CFL));
        let numbers = |simulation: &mut Simulation| -> HashSet<u32> {
            let rows = rows(simulation.world_mut());
            rows.iter().map(|row| row[0]).collect()
        };
        let mut before = numbers(&mut simulation);
        let mut seen = before.clone();
        let mut last = StepReport::default();
        for _ in 0..120 {
            last = simulation
                .step()
                .unwrap_or_else(|error| panic!("{pressure:?}: {error}"));
            let now = numbers(&mut simulation);
            let new: Vec<u32> = now.difference(&before).copied().collect();
            assert!(new.iter().all(|id| seen.insert(*id)), "a number came back");
            // 15 × 5 particles of the body.
            assert_eq!(now.len() as u64, 75 + last.emitted - last.removed);
            before = now;
        }
        assert!(last.emitted > 80 && last.removed > 20, "{last:?}");
        assert_eq!(seen.len() as u64, 75 + last.emitted);
    }
}

#[test]
fn threads_and_executor_change_no_bit() {
    for pressure in fed() {
        let single = scene(pressure, CFL);
        let run = |scene: &Scene, threads| {
            let mut simulation = Simulation::with_threads(scene, threads).expect("a scene");
            let reports = reports(&mut simulation, 60);
            (reports, rows(simulation.world_mut()))
        };
        let expected = run(&single, 1);
        assert!(run(&single, 3) == expected, "{pressure:?}");
        let parallel = Scene {
            executor: Executor::Parallel,
            ..single
        };
        assert!(run(&parallel, 2) == expected, "{pressure:?}");
    }
}

/// All structures find the same neighbours, in another order: runs agree to rounding.
#[test]
fn structures_agree() {
    let mut expected: Option<Vec<(u32, Vec3)>> = None;
    for structure in IndexStructure::ALL {
        for neighbours in [Neighbours::Stored, Neighbours::Recomputed] {
            let mut scene = scene(sesph(), "Fixed(0.0002)");
            scene.index.structure = structure;
            scene.neighbours = neighbours;
            let mut simulation = simulation(&scene);
            run(&mut simulation, 100);
            let world = simulation.world_mut();
            let mut fluid = world.query_filtered::<(&ParticleId, &Position), With<Fluid>>();
            let mut found: Vec<_> = fluid.iter(world).map(|(id, x)| (id.get(), x.0)).collect();
            found.sort_by_key(|particle| particle.0);
            let expected = expected.get_or_insert_with(|| found.clone());
            assert_eq!(found.len(), expected.len(), "{structure:?}");
            for (a, b) in found.iter().zip(expected) {
                assert!(
                    a.0 == b.0 && a.1.distance(b.1) < 1e-4,
                    "{structure:?}: {a:?} {b:?}"
                );
            }
        }
    }
}

/// A new simulation from the checkpoint of another, through its bytes.
fn resumed(simulation: &mut Simulation) -> Simulation {
    let bytes = Checkpoint::of(simulation.world_mut())
        .expect("a checkpoint")
        .to_bytes();
    let checkpoint = Checkpoint::read(&mut &bytes[..]).expect("the same");
    let scene = checkpoint.scene().expect("its scene");
    let mut resumed = Simulation::with_threads(&scene, 2).expect("a scene that runs");
    checkpoint.restore(resumed.world_mut()).expect("its state");
    resumed
}

#[test]
fn a_resumed_run_has_the_bits_of_the_uninterrupted_one() {
    let means = PressureMethod::Dfsph(Dfsph {
        warm_start: 1.0,
        warm_start_steps: 3,
        ..Dfsph::default()
    });
    for pressure in fed().chain([means]) {
        for control in ["Fixed(0.0005)", CFL, "Adaptive(max: 0.001)"] {
            let mut whole = simulation(&scene(pressure, control));
            // Before and after the first reordering; particles enter and leave all the time.
            for steps in [0, 9, 40] {
                reports(&mut whole, steps);
                let mut part = resumed(&mut whole);
                assert_eq!(rows(part.world_mut()), rows(whole.world_mut()));
                let [expected, found] = [&mut whole, &mut part].map(|run| reports(run, 15));
                assert_eq!(found, expected, "{pressure:?} {control}");
                assert_eq!(
                    rows(part.world_mut()),
                    rows(whole.world_mut()),
                    "{pressure:?} {control}"
                );
            }
        }
    }
}

/// Makes the next step fail.
fn spoil(simulation: &mut Simulation) {
    let world = simulation.world_mut();
    let entity = common::state(world)[7].0;
    world.entity_mut(entity).insert(Velocity(Vec3::NAN));
}

/// Numbers of steps after which one comes in which fluid enters, and one in which some leaves.
fn steps_with_flow(scene: &Scene) -> Vec<usize> {
    let all = reports(&mut simulation(scene), 90);
    let first = |count: fn(&StepReport) -> u64| {
        (25..all.len()).find(|&k| count(&all[k]) > count(&all[k - 1]))
    };
    let both = [
        first(|report| report.emitted),
        first(|report| report.removed),
    ];
    both.into_iter().flatten().collect()
}

#[test]
fn steps_taken_back_undo_what_came_and_went() {
    let (mut came, mut went) = (0, 0);
    for pressure in fed() {
        for interval in [0, 7] {
            let scene = Scene {
                reorder_interval: interval,
                ..scene(pressure, "Adaptive(max: 0.001)")
            };
            for wrong in steps_with_flow(&scene) {
                let [mut straight, mut back] = [(); 2].map(|()| simulation(&scene));
                let before = reports(&mut straight, wrong).pop().expect("steps");
                let expected = rows(straight.world_mut());
                let stood = *straight.world().resource::<Clock>();
                reports(&mut back, wrong);
                let after = reports(&mut back, 1)[0].clone();
                came += after.emitted - before.emitted;
                went += after.removed - before.removed;
                // Also from a checkpoint between.
                let mut back = if wrong % 2 == 0 {
                    resumed(&mut back)
                } else {
                    back
                };
                spoil(&mut back);
                let report = back.step().expect("it goes back");
                assert_eq!(
                    report.taken_back.map(|back| back.steps),
                    Some(2),
                    "{pressure:?} {wrong}"
                );
                assert_eq!(
                    (report.emitted, report.removed),
                    (before.emitted, before.removed)
                );
                let what = format!("{pressure:?} {interval} {wrong}");
                assert!(rows(back.world_mut()) == expected, "{what}: another state");
                // The same steps again, but for the numbers of what enters again.
                back.world_mut().resource_mut::<Clock>().next_dt = stood.next_dt;
                for _ in 0..5 {
                    run(&mut straight, 1);
                    run(&mut back, 1);
                    let [a, b] = [&mut straight, &mut back].map(|run| {
                        let rows = rows(run.world_mut());
                        rows.into_iter()
                            .map(|row| [row[1], row[2], row[4], row[5]])
                            .collect::<Vec<_>>()
                    });
                    assert!(a == b, "{what}");
                }
            }
        }
    }
    assert!(came > 0 && went > 0, "{came} {went}");
}

#[test]
fn a_scene_without_flow_has_nothing_of_it() {
    let plain = overfall::plan(&common::dam()).expect("a plan");
    let flows = overfall::plan(&scene(sesph(), CFL)).expect("a plan");
    let stages = |plan: &overfall::Plan| {
        let names = plan.phases.iter().flat_map(|(_, stages)| stages.clone());
        names
            .filter(|name| name == "emit" || name == "outflow")
            .count()
    };
    assert_eq!((stages(&plain), stages(&flows)), (0, 2));
    let columns = |plan: &overfall::Plan| {
        let names = plan.bytes_per_particle.iter();
        names.filter(|(name, _)| *name == "emitter").count()
    };
    assert_eq!((columns(&plain), columns(&flows)), (0, 1));
    let resources = |scene: &Scene| {
        let simulation = simulation(scene);
        let world = simulation.world();
        let names = world
            .iter_resources()
            .map(|(_, info, ..)| format!("{}", info.name()));
        names.filter(|name| name.contains("flow::")).count()
    };
    assert_eq!(resources(&common::dam()), 0);
    assert!(resources(&scene(sesph(), CFL)) > 3);
    // The components of a particle.
    let components = |scene: &Scene| {
        let mut simulation = simulation(scene);
        let entity = common::state(simulation.world_mut())[0].0;
        let world = simulation.world();
        let of = world.inspect_entity(entity).expect("a particle");
        of.filter(|info| format!("{}", info.1.name()).contains("flow::"))
            .count()
    };
    assert_eq!(
        (components(&common::dam()), components(&scene(sesph(), CFL))),
        (0, 1)
    );
}

#[test]
fn particles_come_and_go_between_steps_alone() {
    let order = |tail: &str| {
        let text = format!(
            r#"(stages: [Run("gather"), Run("move_walls"), Run("rebuild_index"), Run("find_neighbours"), Run("density"),
                Run("divergence"), Run("clear_forces"), Run("gravity"), Run("wall_pressure"), Run("viscosity"),
                Run("pressure"), {tail}])"#
        );
        let order = Order::parse(&text).expect("an order");
        order
            .check(&scene(sesph(), CFL))
            .map_err(|error| error.to_string())
    };
    let fine = r#"Run("integrate"), Run("outflow"), Run("emit"), Run("reorder")"#;
    assert_eq!(order(fine), Ok(()));
    for (tail, part) in [
        (
            r#"Run("emit"), Run("integrate"), Run("reorder"), Run("outflow")"#,
            "`emit` changes which particles",
        ),
        (
            r#"Run("outflow"), Run("integrate"), Run("reorder"), Run("emit")"#,
            "`outflow` changes which particles",
        ),
        (
            r#"Run("integrate"), Run("reorder"), Run("outflow"), Every(2, [Run("emit")])"#,
            "too late",
        ),
        (
            r#"Run("integrate"), Run("reorder"), Run("outflow")"#,
            "never runs `emit`",
        ),
        (
            r#"Run("integrate"), Run("reorder"), Run("emit")"#,
            "never runs `outflow`",
        ),
    ] {
        let error = order(tail).expect_err(tail);
        assert!(error.contains(part), "{tail}: {error}");
    }
}

#[test]
fn a_world_takes_the_next_scene_after_one_with_flow() {
    let mut world = World::new();
    let scene = scene(methods()[3], CFL);
    let mut ends = Vec::new();
    for _ in 0..2 {
        overfall::install(&mut world, &scene).expect("a scene");
        for _ in 0..4 {
            overfall::advance(&mut world, 1.0 / 60.0).unwrap_or_else(|error| panic!("{error}"));
        }
        let world = &mut world;
        ends.push(
            rows(world)
                .into_iter()
                .map(|row| row[1..].to_vec())
                .collect::<Vec<_>>(),
        );
        overfall::uninstall(world).expect("it goes");
        assert_eq!(rows(world).len(), 0);
    }
    assert!(ends[0] == ends[1]);
}

/// Fluid that enters at 4 m/s when all is still: the step before was chosen without it.
#[test]
fn the_time_step_is_right_when_fluid_enters_late() {
    for control in ["Cfl(factor: 0.4, max: 0.05)", "Adaptive(max: 0.05)"] {
        let text = format!(
            "(name: \"late\", dimension: 2, spacing: 0.02, gravity: (0, 0, 0), time_step: {control},
            emitters: [(shape: Disc(center: (0, 0, 0), normal: (1, 0, 0), radius: 0.05), speed: 4, start: 0.5)],
            bodies: [(shape: Box(min: (0, 1, 0), max: (0.2, 1.2, 0)))])"
        );
        let scene = Scene::parse(&text, "late.ron", &[]).unwrap_or_else(|error| panic!("{error}"));
        assert!(matches!(
            scene.time_step,
            TimeStep::Cfl(_) | TimeStep::Adaptive(_)
        ));
        let mut simulation = simulation(&scene);
        while simulation.time() < 0.55 {
            let report = simulation
                .step()
                .unwrap_or_else(|error| panic!("{control}: {error}"));
            assert_eq!(report.taken_back, None);
            if report.max_speed > 1.0 {
                assert!(
                    report.dt * 4.0 <= 0.41 * scene.support_radius(),
                    "{control}: {report:?}"
                );
            }
        }
    }
}
