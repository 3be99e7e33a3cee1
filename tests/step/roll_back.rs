//! Roll-back of steps: after a shock that came too fast, two steps are rolled back to the bit, and the run continues.

use bevy_ecs::prelude::*;
use glam::Vec3;
use overfall::{
    Simulation, StepReport,
    scene::{Adaptive, Dfsph, IndexStructure, Neighbours, Pcisph, PressureMethod, Scene, TimeStep},
    state::{
        Clock, FailureCause,
        particle::{Density, Fluid, Position, Pressure, Velocity},
    },
    time_step::{AdaptiveTimeStep, adaptive::MOST_IN_A_ROW, roll_back::KeptState},
};

use crate::common::{self, bits, dam, methods, pcisph, run, simulation};

/// A drop is thrown into a pool at 6 m/s. The first time step is just short enough for its flight.
fn splash(pressure: PressureMethod) -> Scene {
    let scene = Scene::parse(
        r#"(
            name: "splash",
            spacing: 0.02,
            bodies: [
                (shape: Box(min: (0, 0, 0), max: (0.2, 0.08, 0.2))),
                (shape: Sphere(center: (0.1, 0.16, 0.1), radius: 0.05), velocity: (0, -6, 0)),
            ],
            boundaries: [Tank(min: (0, 0, 0), max: (0.2, 0.4, 0.2))],
            time_step: Adaptive(max: 5e-3, initial: 2.9e-3, density_error: 0.003),
            reorder_interval: 5,
        )"#,
        "splash.ron",
        &[],
    );
    Scene {
        pressure,
        ..scene.expect("a scene")
    }
}

fn adaptive(scene: Scene) -> Scene {
    let scheme = Adaptive {
        max: 1e-3,
        ..Adaptive::default()
    };
    Scene {
        time_step: TimeStep::Adaptive(scheme),
        ..scene
    }
}

fn clock(simulation: &Simulation) -> Clock {
    *simulation.world().resource::<Clock>()
}

/// Densities and pressures, by entity.
fn scalars(simulation: &mut Simulation) -> Vec<(Entity, u32, u32)> {
    let world = simulation.world_mut();
    let mut fluid = world.query_filtered::<(Entity, &Density, &Pressure), With<Fluid>>();
    let mut scalars: Vec<_> = fluid
        .iter(world)
        .map(|(entity, rho, p)| (entity, rho.0.to_bits(), p.0.to_bits()))
        .collect();
    scalars.sort_unstable();
    scalars
}

/// Makes the next step fail, whatever its length.
fn spoil(simulation: &mut Simulation) -> Entity {
    let entity = common::state(simulation.world_mut())[77].0;
    let world = simulation.world_mut();
    world.entity_mut(entity).insert(Velocity(Vec3::NAN));
    entity
}

#[test]
fn a_violent_impact_takes_steps_back_and_ends_well() {
    // δ-SPH passes it without a jump.
    let iterative = methods().into_iter().take(4);
    for mut pressure in iterative {
        if let PressureMethod::Dfsph(dfsph) = &mut pressure {
            // With its own limit it passes this impact without a jump.
            dfsph.max_density_error = 0.001;
        }
        let scene = splash(pressure);
        let TimeStep::Adaptive(scheme) = scene.time_step else {
            panic!("an adaptive scene");
        };
        let mut simulation = simulation(&scene);
        // The steps that remain.
        let mut steps: Vec<StepReport> = Vec::new();
        let mut roll_backs = 0;
        for _ in 0..150 {
            let failed_dt = clock(&simulation).next_dt;
            let report = simulation
                .step()
                .unwrap_or_else(|error| panic!("{pressure:?}: {error}"));
            let now = clock(&simulation);
            assert_eq!((report.step, report.time), (now.step, now.time));
            assert!(now.next_dt >= scheme.min && now.next_dt <= scheme.max);
            match &report.taken_back {
                Some(taken_back) => {
                    roll_backs += 1;
                    assert_eq!(report.dt, failed_dt);
                    assert!(now.next_dt <= 0.5 * failed_dt, "{taken_back:?}");
                    for _ in 1..taken_back.steps {
                        steps.pop();
                    }
                }
                None => {
                    assert!(report.max_density_error <= scheme.max_density_error);
                    if let Some(last) = steps.last() {
                        let jump = report.max_density_error - last.max_density_error;
                        assert!(jump <= 8.0 * scheme.density_error, "{pressure:?}: {jump}");
                    }
                    assert!(report.dt * report.max_speed <= 0.45 * scene.support_radius());
                    steps.push(report);
                }
            }
            assert_eq!(now.step, steps.len() as u64);
            assert_eq!(now.time, steps.last().map_or(0.0, |last| last.time));
        }
        assert!(roll_backs > 0, "{pressure:?}: nothing went wrong");
        assert!(
            now_slower(&mut simulation),
            "{pressure:?}: the drop was not stopped"
        );
    }
}

/// Whether no particle is as fast as the drop was.
fn now_slower(simulation: &mut Simulation) -> bool {
    let state = common::state(simulation.world_mut());
    state.iter().all(|(_, _, v)| v.y > -5.5)
}

#[test]
fn steps_taken_back_and_taken_again_give_the_same_bits() {
    let structures = [IndexStructure::CompactHashing, IndexStructure::ZIndexSort];
    let from_means = PressureMethod::Dfsph(Dfsph {
        warm_start: 1.0,
        warm_start_steps: 3,
        ..Dfsph::default()
    });
    for pressure in methods().into_iter().chain([from_means]) {
        for structure in structures {
            let mut scene = Scene {
                pressure,
                reorder_interval: 5,
                neighbours: if structure == IndexStructure::ZIndexSort {
                    Neighbours::Recomputed
                } else {
                    Neighbours::Stored
                },
                ..adaptive(dam())
            };
            scene.index.structure = structure;
            // Rolled back from step 9 with nothing in between, and from step 11 across the reordering at the end of
            // step 10.
            for wrong in [9, 11] {
                let [mut straight, mut back] = [(); 2].map(|()| simulation(&scene));
                run(&mut straight, wrong - 2);
                let earlier = (bits(straight.world_mut()), scalars(&mut straight));
                let earlier_clock = clock(&straight);
                run(&mut straight, 1);

                run(&mut back, wrong - 1);
                spoil(&mut back);
                let report = back.step().expect("it goes back");
                let taken_back = report.taken_back.expect("it went wrong");
                assert_eq!(taken_back.steps, 2);
                assert!(matches!(taken_back.cause, FailureCause::NotFinite { .. }));
                let what = format!("{pressure:?} {structure:?} from step {wrong}");
                assert!(
                    (bits(back.world_mut()), scalars(&mut back)) == earlier,
                    "{what}: the state is another"
                );
                let stands = clock(&back);
                assert_eq!(
                    (stands.step, stands.time),
                    (earlier_clock.step, earlier_clock.time)
                );

                // With the time step of the first attempt, and on across the next reordering.
                back.world_mut().resource_mut::<Clock>().next_dt = earlier_clock.next_dt;
                for _ in 0..8 {
                    run(&mut back, 1);
                    assert_eq!(clock(&back), clock(&straight));
                    assert!(
                        bits(back.world_mut()) == bits(straight.world_mut()),
                        "{what}: other bits in step {}",
                        clock(&back).step
                    );
                    run(&mut straight, 1);
                }
            }
        }
    }
}

#[test]
fn a_fluid_of_other_particles_is_gone_back_to_by_no_more_than_the_step_that_failed() {
    for spawned in [true, false] {
        let mut simulation = simulation(&adaptive(dam()));
        run(&mut simulation, 5);
        let world = simulation.world_mut();
        if spawned {
            world.spawn((Fluid, Position(Vec3::new(0.3, 0.3, 0.1))));
        } else {
            let last = common::state(world)[common::DAM_PARTICLES - 1].0;
            world.despawn(last);
        }
        let spoilt = spoil(&mut simulation);
        let (before, stood) = (bits(simulation.world_mut()), clock(&simulation));
        // The cause persists: after a number of shorter steps it becomes an error.
        for _ in 0..MOST_IN_A_ROW.min(9) {
            let report = simulation.step().expect("it goes back");
            assert_eq!(report.taken_back.map(|back| back.steps), Some(1));
            assert_eq!((report.step, report.time), (stood.step, stood.time));
        }
        let error = (0..MOST_IN_A_ROW)
            .find_map(|_| simulation.step().err())
            .expect("going back comes to an end");
        assert!(matches!(error.cause, FailureCause::NotFinite { .. }));
        assert_eq!(error.particle.map(|particle| particle.0), Some(spoilt));
        assert!(bits(simulation.world_mut()) == before);
        assert!(simulation.step().is_err());
        simulation
            .world_mut()
            .entity_mut(spoilt)
            .insert(Velocity(Vec3::ZERO));
        run(&mut simulation, 3);
    }
}

#[test]
fn at_the_least_time_step_a_shock_is_an_error_that_says_so() {
    let mut scene = splash(pcisph());
    scene.time_step = TimeStep::Adaptive(Adaptive {
        min: 3.1e-3,
        ..Adaptive::default()
    });
    let mut simulation = simulation(&scene);
    let before = bits(simulation.world_mut());
    let error = simulation.step().expect_err("6 m/s");
    assert!(error.to_string().contains("more than 0.45 h"), "{error}");
    let (entity, _) = error.particle.expect("the fastest");
    let velocity = simulation.world().get::<Velocity>(entity);
    assert_eq!(velocity.map(|v| v.0.y), Some(-6.0));
    assert!(bits(simulation.world_mut()) == before);
}

#[test]
fn where_nothing_happens_the_time_step_grows_to_its_limit_and_nothing_is_taken_back() {
    for pressure in methods() {
        let scene = Scene::parse(
            r#"(
                name: "still",
                spacing: 0.02,
                bodies: [(shape: Box(min: (0, 0, 0), max: (0.12, 0.12, 0.12)))],
                boundaries: [Tank(min: (0, 0, 0), max: (0.12, 0.2, 0.12))],
                time_step: Adaptive(initial: 3e-4, max: 4e-4),
            )"#,
            "still.ron",
            &[],
        );
        let scene = Scene {
            pressure,
            ..scene.expect("a scene")
        };
        let mut simulation = simulation(&scene);
        let mut dt = 0.0;
        // With a growth of 0.2 % it takes 145 steps from the first to the largest, and a few more if DFSPH starts with
        // many iterations.
        for _ in 0..250 {
            let report = simulation
                .step()
                .unwrap_or_else(|error| panic!("{pressure:?}: {error}"));
            assert_eq!(report.taken_back, None, "{pressure:?}");
            let many = report.iterations > 10;
            assert!(
                many || report.dt >= 0.997 * dt,
                "{pressure:?}: {} after {dt}",
                report.dt
            );
            dt = report.dt;
        }
        assert_eq!(dt, 4e-4, "{pressure:?}");
    }
}

#[test]
fn the_number_of_threads_changes_no_bit_of_a_run_that_goes_back() {
    let mut went_back = false;
    for pressure in methods() {
        let scene = splash(pressure);
        let runs = [1, 3].map(|threads| {
            let mut simulation = Simulation::with_threads(&scene, threads).expect("a scene");
            let reports = (0..40).map(|_| simulation.step().expect("a step").taken_back);
            let taken_back: Vec<_> = reports.collect();
            (taken_back, bits(simulation.world_mut()))
        });
        went_back |= runs[0].0.iter().any(Option::is_some);
        assert!(runs[0] == runs[1], "{pressure:?}");
    }
    assert!(went_back);
}

#[test]
fn nothing_of_it_is_in_a_world_that_does_not_ask_for_it() {
    for time_step in [TimeStep::Fixed(1e-3), TimeStep::default()] {
        let simulation = simulation(&Scene { time_step, ..dam() });
        assert!(!simulation.world().contains_resource::<KeptState>());
        assert!(!simulation.world().contains_resource::<AdaptiveTimeStep>());
    }
}

#[test]
fn an_order_that_uses_what_is_left_over_cannot_go_back() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("order.ron");
    let stages = r#"(stages: [Run("gather"), Run("rebuild_index"), Every(2, [Run("find_neighbours")]),
        Run("density"), Run("clear_forces"), Run("gravity"), Run("wall_pressure"),
        Run("viscosity"), Run("surface_tension"), Run("pressure"), Run("integrate")], allow_stale: true,
        leave_out: ["reorder"])"#;
    std::fs::write(&path, stages).expect("an order file");
    let scene = Scene {
        order: Some(path.display().to_string()),
        pressure: PressureMethod::Pcisph(Pcisph::default()),
        ..dam()
    };
    overfall::plan(&scene).expect("a stale order");
    let error = overfall::plan(&adaptive(scene)).expect_err("steps back over stale lists");
    assert!(error.to_string().contains("taken back"), "{error}");
}

#[test]
fn a_step_ends_at_a_time_that_a_host_asks_for_and_the_next_has_its_length_again() {
    for time_step in [
        TimeStep::Fixed(3e-4),
        TimeStep::Cfl(Default::default()),
        TimeStep::Adaptive(Default::default()),
    ] {
        let scene = Scene { time_step, ..dam() };
        let mut simulation = simulation(&scene);
        for until in [1e-3, 1.9e-3, 2e-3] {
            while simulation.time() < until {
                let report = simulation.step_until(until).expect("a step");
                assert!(report.time <= until);
            }
            assert_eq!(simulation.time(), until);
        }
        // The last step was shortened a lot; the next is not.
        let short = clock(&simulation).dt;
        let report = simulation.step().expect("a step");
        assert!(report.dt > 1.5 * short, "{} after {short}", report.dt);
    }
}
