//! Order files: the order of the stages is data, and an invalid one is refused before the first step.

use std::fs;

use glam::Vec3;
use overfall::{
    Simulation, plan,
    pressure::{DensityError, SolverState, first_force::FirstForce},
    scene::{Dfsph, Iisph, Neighbours, Pcisph, PressureMethod, Scene, TimeStep},
    state::{
        Clock, Pressures,
        particle::{Fluid, Position},
    },
};

use crate::common::{self, bits, bits_after, dam, run, sesph, simulation};

/// A scene with a fixed time step and an order file with these stages, in a folder that exists as long as the second
/// value.
pub(super) fn ordered(stages: &str) -> (Scene, tempfile::TempDir) {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("order.ron");
    fs::write(&path, stages).expect("an order file");
    let scene = Scene {
        order: Some(path.display().to_string()),
        ..unordered()
    };
    (scene, folder)
}

pub(super) fn unordered() -> Scene {
    Scene {
        pressure: sesph(),
        time_step: TimeStep::Fixed(2e-4),
        ..dam()
    }
}

pub(super) const STAGES: &str = r#"Run("gather"), Run("rebuild_index"), Run("find_neighbours"), Run("density"),
    Run("divergence"), Run("clear_forces"), Run("gravity"),
    Run("wall_pressure"), Run("viscosity"), Run("surface_tension"), Run("pressure"), Run("integrate"), Run("reorder")"#;

#[test]
fn the_default_order_written_out_gives_the_same_bits() {
    let expected = bits_after(&unordered(), 2, 25);
    for stages in [
        STAGES.to_owned(),
        format!("Every(1, [{STAGES}])"),
        format!("Repeat(1, [Every(1, [{STAGES}])])"),
        // Its products do not depend on its earlier products.
        STAGES.replace(r#"Run("density")"#, r#"Repeat(2, [Run("density")])"#),
        // The gradient factors of the density pass then belong to other lists, so they are computed again.
        STAGES.replace(
            r#"Run("density")"#,
            r#"Run("density"), Run("find_neighbours")"#,
        ),
    ] {
        let (scene, _folder) = ordered(&format!("(stages: [{stages}])"));
        assert!(bits_after(&scene, 2, 25) == expected, "{stages}");
    }
}

/// Whether viscosity sums the first pressure force.
fn sums_the_first_force(simulation: &Simulation) -> bool {
    simulation.world().contains_resource::<FirstForce>()
}

/// The result of a step, to the bit: the state, pressures, and the solver's report.
fn everything(simulation: &mut Simulation) -> (Vec<[u32; 6]>, Vec<u32>, [u32; 4]) {
    let world = simulation.world_mut();
    let state = bits(world);
    let pressures = world.resource::<Pressures>();
    let pressures = pressures.iter().map(|p| p.to_bits()).collect();
    let solve = world.resource::<SolverState>();
    let dt = world.resource::<Clock>().dt.to_bits();
    let DensityError { largest, mean, .. } = solve.error();
    let said = [solve.iterations(), largest.to_bits(), mean.to_bits(), dt];
    (state, pressures, said)
}

#[test]
fn a_first_force_summed_with_viscosity_is_the_same_to_the_bit() {
    let warm = Pcisph {
        warm_start: 0.5,
        ..Pcisph::default()
    };
    let exact = Pcisph {
        last_correction: true,
        ..warm
    };
    let means = Dfsph {
        warm_start_steps: 10,
        ..Dfsph::default()
    };
    let pressures = [
        PressureMethod::Pcisph(warm),
        PressureMethod::Pcisph(exact),
        PressureMethod::Iisph(Iisph::default()),
        PressureMethod::Dfsph(Dfsph::default()),
        PressureMethod::Dfsph(means),
    ];
    let without_walls = Scene {
        boundaries: Vec::new(),
        ..dam()
    };
    let recomputed = Scene {
        neighbours: Neighbours::Recomputed,
        ..dam()
    };
    for (scene, steps) in [(dam(), 25), (without_walls, 5), (recomputed, 5)] {
        for pressure in pressures {
            let together = Scene {
                pressure,
                ..scene.clone()
            };
            // As far as the order says, viscosity does not run in every step.
            let stages = STAGES.replace(r#"Run("viscosity")"#, r#"Every(1, [Run("viscosity")])"#);
            let (alone, _folder) = ordered(&format!("(stages: [{stages}])"));
            let alone = Scene {
                order: alone.order,
                ..together.clone()
            };
            let mut both = [together, alone].map(|scene| simulation(&scene));
            assert_eq!(both.each_ref().map(sums_the_first_force), [true, false]);
            for step in 0..steps {
                for simulation in &mut both {
                    if step == 2 {
                        // Far too long, so that it is halved and solved again.
                        simulation.world_mut().resource_mut::<Clock>().next_dt = 0.1;
                    }
                    run(simulation, 1);
                    assert!(simulation.world().resource::<Clock>().dt < 0.1);
                }
                let [together, alone] = both.each_mut().map(everything);
                assert!(together == alone, "step {step}, {pressure:?}");
            }
        }
    }
}

#[test]
fn a_first_force_is_summed_with_viscosity_only_where_the_solve_follows() {
    let iisph = |order| Scene {
        pressure: PressureMethod::Iisph(Iisph::default()),
        order,
        ..dam()
    };
    let viscosity = r#"Run("viscosity")"#;
    for (stages, expected) in [
        (STAGES.to_owned(), true),
        (
            STAGES.replace(viscosity, &format!("Repeat(2, [{viscosity}])")),
            false,
        ),
        (
            STAGES.replace(viscosity, &format!("{viscosity}, Run(\"density\")")),
            false,
        ),
        (
            STAGES.replace(r#"Run("pressure")"#, r#"Every(1, [Run("pressure")])"#),
            false,
        ),
        (
            STAGES.replace(r#"Run("pressure")"#, r#"Run("pressure"), Run("pressure")"#),
            false,
        ),
    ] {
        let (scene, _folder) = ordered(&format!("(stages: [{stages}])"));
        let simulation = simulation(&iisph(scene.order));
        assert_eq!(sums_the_first_force(&simulation), expected, "{stages}");
    }
    let cold = PressureMethod::Pcisph(Pcisph {
        warm_start: 0.0,
        ..Pcisph::default()
    });
    for pressure in [sesph(), cold] {
        assert!(!sums_the_first_force(&simulation(&Scene {
            pressure,
            ..dam()
        })));
    }
}

#[test]
fn a_repeated_force_counts_twice() {
    let twice = STAGES.replace(r#"Run("viscosity")"#, r#"Repeat(2, [Run("viscosity")])"#);
    let (scene, _folder) = ordered(&format!("(stages: [{twice}])"));
    let mut stronger = unordered();
    stronger.fluid.viscosity = match stronger.fluid.viscosity {
        overfall::scene::Viscosity::Artificial { alpha, sound_speed } => {
            overfall::scene::Viscosity::Artificial {
                alpha: 2.0 * alpha,
                sound_speed,
            }
        }
        other => other,
    };
    let [mut twice, mut stronger, mut once] = [&scene, &stronger, &unordered()].map(simulation);
    for simulation in [&mut twice, &mut stronger, &mut once] {
        run(simulation, 5);
    }
    let [twice, stronger, once] =
        [twice, stronger, once].map(|mut simulation| common::state(simulation.world_mut()));
    common::assert_near(&twice, &stronger, 1e-7);
    assert!(
        twice
            .iter()
            .zip(&once)
            .any(|(twice, once)| twice.1.distance(once.1) > 1e-6)
    );
}

#[test]
fn a_repeated_step_is_so_many_steps() {
    let (scene, _folder) = ordered(&format!("(stages: [Repeat(2, [{STAGES}])])"));
    let mut twice = simulation(&scene);
    run(&mut twice, 12);
    assert_eq!(twice.world().resource::<Clock>().step, 24);
    assert!(bits(twice.world_mut()) == bits_after(&unordered(), 2, 24));
}

#[test]
fn a_repetition_is_printed_in_its_order() {
    let lines = |stages: &str| {
        let (scene, _folder) = ordered(&format!("(stages: [{stages}])"));
        let phases = plan(&scene).expect("a plan").phases;
        let lines: Vec<String> = phases.into_iter().flat_map(|(_, lines)| lines).collect();
        lines.join(", ")
    };
    let forces = r#"Run("clear_forces"), Run("gravity"),
    Run("wall_pressure"), Run("viscosity")"#;
    let twice = STAGES.replace(forces, &format!("Repeat(2, [{forces}])"));
    let printed = lines(&twice);
    assert!(
        printed.contains("2 times { clear_forces, gravity, viscosity }, surface_tension"),
        "{printed}"
    );
    let over_phases = STAGES.replace(
        r#"Run("find_neighbours"), Run("density")"#,
        r#"Repeat(3, [Run("find_neighbours"), Repeat(2, [Run("density")])])"#,
    );
    let printed = lines(&over_phases);
    let expected = "3 times { find_neighbours, 2 times: density }, clear_forces, gravity";
    assert!(printed.contains(expected), "{printed}");
}

#[test]
fn a_divergence_solve_that_is_skipped_leaves_nothing_behind() {
    let stages = STAGES.replace(
        r#"Run("clear_forces"), Run("gravity")"#,
        r#"Every(3, [Run("divergence")]), Run("clear_forces"), Run("gravity")"#,
    );
    let (mut scene, _folder) = ordered(&format!("(stages: [{stages}], allow_stale: true)"));
    scene.pressure = overfall::scene::PressureMethod::Dfsph(overfall::scene::Dfsph::default());
    let mut simulation = simulation(&scene);
    run(&mut simulation, 1);
    // More rows than in the last divergence solve, in additional chunks.
    let spawned = (0..3000).map(|k| {
        let [x, y] = [k % 60, k / 60].map(|k| 0.1 * k as f32);
        (Fluid, Position(Vec3::new(x, 5.0 + y, 20.0)))
    });
    simulation.world_mut().spawn_batch(spawned);
    run(&mut simulation, 4);
}
