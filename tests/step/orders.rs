//! Order files: the order of the stages is data, and a wrong one is refused before the first step.

use std::fs;

use glam::Vec3;
use overfall::{
    Simulation,
    neighbours::FluidNeighbours,
    plan,
    pressure::{DensityError, PressureSolve, first_force::FirstForce},
    scene::{Dfsph, Iisph, Neighbours, Pcisph, PressureMethod, Scene, TimeStep},
    state::{
        Clock, Positions, Pressures,
        particle::{Fluid, Position},
    },
    step::Product,
};

use crate::common::{self, bits, bits_after, dam, run, sesph, simulation};

/// A scene with a fixed time step and an order file of these stages, in a folder that lives as long.
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
    Run("viscosity"), Run("surface_tension"), Run("pressure"), Run("integrate"), Run("reorder")"#;

#[test]
fn the_default_order_written_out_gives_the_same_bits() {
    let expected = bits_after(&unordered(), 2, 25);
    for stages in [
        STAGES.to_owned(),
        format!("Every(1, [{STAGES}])"),
        format!("Repeat(1, [Every(1, [{STAGES}])])"),
        // What it makes depends on nothing that it made before.
        STAGES.replace(r#"Run("density")"#, r#"Repeat(2, [Run("density")])"#),
        // Slopes that the density pass kept are those of other lists then, and are calculated.
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

/// What a step left, to the bit: the state, pressures, and what the solve says.
fn everything(simulation: &mut Simulation) -> (Vec<[u32; 6]>, Vec<u32>, [u32; 4]) {
    let world = simulation.world_mut();
    let state = bits(world);
    let pressures = &world.resource::<Pressures>().0;
    let pressures = pressures.iter().map(|p| p.to_bits()).collect();
    let solve = world.resource::<PressureSolve>();
    let dt = world.resource::<Clock>().dt.to_bits();
    let DensityError { largest, mean, .. } = solve.error;
    let said = [solve.iterations, largest.to_bits(), mean.to_bits(), dt];
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

/// As [`ordered`], with lists that are found every so many steps and rows that stay where they are.
fn with_stale_lists(every: u32) -> (Scene, tempfile::TempDir) {
    let stages = STAGES.replace(
        r#"Run("find_neighbours")"#,
        &format!(r#"Every({every}, [Run("find_neighbours")])"#),
    );
    let stages = stages.replace(r#", Run("reorder")"#, "");
    ordered(&format!(
        "(stages: [{stages}], allow_stale: true, leave_out: [\"reorder\"])"
    ))
}

#[test]
fn stale_neighbours_are_kept_between_the_steps_that_find_them() {
    let (scene, _folder) = with_stale_lists(2);
    let mut simulation = simulation(&scene);
    let mut pairs = Vec::new();
    for _ in 0..40 {
        run(&mut simulation, 1);
        let lists = &simulation.world().resource::<FluidNeighbours>().lists;
        let rows = common::DAM_PARTICLES;
        pairs.push(
            (0..rows)
                .map(|row| lists.of(row).to_vec())
                .collect::<Vec<_>>(),
        );
    }
    for step in (0..40).step_by(2) {
        assert!(pairs[step] == pairs[step + 1], "step {}", step + 2);
    }
    assert!(pairs[0] != pairs[38], "nothing moved");
    let planned = plan(&scene).expect("a plan").phases;
    let lines: Vec<_> = planned.into_iter().flat_map(|(_, lines)| lines).collect();
    assert!(lines.contains(&"every 2 steps: find_neighbours".to_owned()));
}

#[test]
fn particles_may_come_and_go_while_neighbours_are_stale() {
    let stages = STAGES.replace(
        r#"Run("find_neighbours")"#,
        r#"Every(4, [Run("find_neighbours")])"#,
    );
    let (scene, _folder) = ordered(&format!("(stages: [{stages}], allow_stale: true)"));
    for change in 0..3 {
        let mut simulation = simulation(&scene);
        run(&mut simulation, 1);
        let world = simulation.world_mut();
        let particles = common::state(world);
        match change {
            0 => {
                world.spawn((Fluid, Position(Vec3::new(0.3, 0.3, 0.1))));
            }
            1 => {
                world.despawn(particles[common::DAM_PARTICLES - 1].0);
            }
            // The last row takes the place of the first, which other rows' lists name.
            _ => {
                world.despawn(particles[0].0);
            }
        }
        run(&mut simulation, 1);
        // The rows name other particles, so lists are found again although they are not due.
        let world = simulation.world();
        let (lists, positions) = (
            world.resource::<FluidNeighbours>(),
            world.resource::<Positions>(),
        );
        let h = scene.support_radius();
        for row in 0..positions.rows() {
            for &other in lists.lists.of(row) {
                let distance = positions.points()[row].distance(positions.points()[other as usize]);
                assert!(distance < 1.5 * h, "{row} and {other}: {distance}");
            }
        }
        run(&mut simulation, 4);
    }
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
    Run("viscosity")"#;
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
    // More rows than the last divergence solve had, in chunks of their own.
    let spawned = (0..3000).map(|k| {
        let [x, y] = [k % 60, k / 60].map(|k| 0.1 * k as f32);
        (Fluid, Position(Vec3::new(x, 5.0 + y, 20.0)))
    });
    simulation.world_mut().spawn_batch(spawned);
    run(&mut simulation, 4);
}

/// A drop in free fall for 0.1 s under an order with these stages; how far it fell \[m].
fn fall(stages: &str) -> f32 {
    let (ordered, _folder) = ordered(&format!(
        "(stages: [{stages}], allow_stale: true, leave_out: [\"reorder\"])"
    ));
    let scene = Scene::parse(
        "(name: \"fall\", spacing: 0.05, bodies: [(shape: Box(min: (0, 0, 0), max: (0.3, 0.3, 0.3)))],
          time_step: Fixed(0.001), reorder_interval: 50, pressure: Sesph(equation: Gas(stiffness: 1)))",
        "fall.ron",
        &[],
    );
    let scene = Scene {
        order: ordered.order.clone(),
        ..scene.expect("a scene")
    };
    let mut simulation = simulation(&scene);
    let height = |simulation: &mut Simulation| {
        let mut places = simulation.world_mut().query::<&Position>();
        let heights: Vec<f32> = places.iter(simulation.world()).map(|x| x.0.y).collect();
        heights.iter().sum::<f32>() / heights.len() as f32
    };
    let before = height(&mut simulation);
    run(&mut simulation, 100);
    before - height(&mut simulation)
}

#[test]
fn an_index_that_is_stale_slows_nothing_down() {
    let stages = STAGES.replace(r#", Run("reorder")"#, "");
    for stale in [
        stages.clone(),
        stages.replace(
            r#"Run("rebuild_index")"#,
            r#"Every(2, [Run("rebuild_index")])"#,
        ),
        stages.replace(
            r#"Run("rebuild_index"), Run("find_neighbours")"#,
            r#"Every(5, [Run("rebuild_index"), Run("find_neighbours")])"#,
        ),
    ] {
        let fallen = fall(&stale);
        // Semi-implicit Euler: g dt² n (n + 1)/2.
        assert!(
            (fallen - 9.81e-6 * 5050.0).abs() < 1e-5,
            "{stale}: {fallen} m"
        );
    }
}

#[test]
fn the_flow_of_data_says_what_is_stale() {
    let (scene, _folder) = with_stale_lists(5);
    let flow = plan(&scene).expect("a plan").flow;
    let of = |name: &str| {
        let found = flow.iter().find(|flow| flow.stage == name);
        found.unwrap_or_else(|| panic!("no {name} in {flow:?}"))
    };
    assert_eq!(of("find_neighbours").every, 5);
    assert_eq!(of("find_neighbours").writes, [Product::Neighbours]);
    assert!(of("density").reads.contains(&(Product::Neighbours, 4)));
    assert!(of("density").reads.contains(&(Product::Columns, 0)));
    assert_eq!(of("density").writes, [Product::Density]);
}
