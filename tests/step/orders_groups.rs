//! Groups of an order: offsets, conditions, sub-steps of forces, forces within the pressure solve.

use bevy_ecs::prelude::*;
use overfall::{
    Phase, Simulation, plan,
    scene::Scene,
    state::particle::{Position, Velocity},
    step::{Accelerations, Clock, Product, Stage, Stages, Velocities},
};

use super::orders::{STAGES, ordered, unordered};
use crate::common::{self, bits_after, pcisph, run};

/// Steps in which stage `note` ran.
#[derive(Resource, Default)]
struct Noted(Vec<u64>);

const NOTE: Stage = Stage {
    needs: &[Product::Columns],
    wanted: |scene| scene.order.is_some(),
    install: |world, _| world.insert_resource(Noted::default()),
    ..Stage::new("note", Phase::Forces, |_| {
        (|mut noted: ResMut<Noted>, clock: Res<Clock>| noted.0.push(clock.step)).into_configs()
    })
};

/// Drag by the host \[1/s].
const DRAG: f32 = 40.0;

const SLOW_DOWN: Stage = Stage {
    needs: &[Product::Columns],
    makes: &[Product::Forces],
    ..Stage::new("slow_down", Phase::Forces, |_| {
        let slow = |mut accelerations: ResMut<Accelerations>, velocities: Res<Velocities>| {
            for (a, v) in accelerations.iter_mut().zip(velocities.iter()) {
                *a -= DRAG * v.truncate();
            }
        };
        slow.into_configs()
    })
};

/// A drop that falls without walls, in steps of 1 ms, under an order with these stages before pressure.
fn drop_with(stages: &str, pressure: &str) -> (Scene, tempfile::TempDir) {
    let all = r#"Run("gather"), Run("rebuild_index"), Run("find_neighbours"), Run("density"), Run("clear_forces")"#;
    let (ordered, folder) = ordered(&format!(
        "(stages: [{all}, {stages}, Run(\"integrate\")], leave_out: [\"viscosity\"])"
    ));
    let text = format!(
        "(name: \"drop\", spacing: 0.05,
          bodies: [(shape: Sphere(center: (0, 0, 0), radius: 0.12), velocity: (2, 0, 0))],
          time_step: Fixed(0.001), reorder_interval: 0, {pressure})"
    );
    let scene = Scene::parse(&text, "drop.ron", &[]).unwrap_or_else(|error| panic!("{error}"));
    let scene = Scene {
        order: ordered.order.clone(),
        ..scene
    };
    (scene, folder)
}

const GAS: &str = "pressure: Sesph(equation: Gas(stiffness: 1))";

fn with_host(scene: &Scene) -> Simulation {
    let mut stages = Stages::default();
    stages.register(NOTE).expect("a name");
    stages.register(SLOW_DOWN).expect("a name");
    let mut world = World::new();
    world.insert_resource(stages);
    Simulation::in_world(world, scene).unwrap_or_else(|error| panic!("{error}"))
}

/// Steps of a falling drop in which a group with stage `note` ran.
fn noted(group: &str) -> Vec<u64> {
    let stages = format!("Run(\"gravity\"), {group}, Run(\"pressure\")");
    let stages = stages.replace("NOTE", "stages: [Run(\"note\")]");
    let drag = "leave_out: [\"viscosity\", \"slow_down\"]";
    let (scene, folder) = drop_with(&stages, GAS);
    let path = folder.path().join("order.ron");
    let text = std::fs::read_to_string(&path).expect("an order");
    std::fs::write(&path, text.replace("leave_out: [\"viscosity\"]", drag)).expect("a file");
    let mut simulation = with_host(&scene);
    run(&mut simulation, 12);
    simulation.world().resource::<Noted>().0.clone()
}

#[test]
fn a_group_runs_in_the_first_step_and_from_its_offset_on() {
    assert_eq!(noted("Group(every: 3, offset: 1, NOTE)"), [0, 1, 4, 7, 10]);
    assert_eq!(noted("Group(every: 4, NOTE)"), [0, 4, 8]);
    assert_eq!(noted("Group(NOTE)").len(), 12);
    // Every fourth step of those with an odd number.
    let nested = "Group(every: 2, offset: 1, stages: [Group(every: 2, offset: 1, NOTE)])";
    assert_eq!(noted(nested), [0, 3, 7, 11]);
}

#[test]
fn a_group_with_a_condition_runs_when_it_holds() {
    // At the start of step k the time is k ms; the last step left 2 m/s along x and 9.81 k mm/s down.
    assert_eq!(
        noted("Group(when: Time(above: 0.0055, below: 0.0085), NOTE)"),
        [6, 7, 8]
    );
    let speed = (4.0_f64 + (9.81e-3_f64 * 7.5).powi(2)).sqrt();
    assert_eq!(
        noted(&format!("Group(when: MaxSpeed(above: {speed}), NOTE)")),
        [8, 9, 10, 11]
    );
    // The last step of the first one is none.
    assert_eq!(noted("Group(when: MaxSpeed(below: 1), NOTE)"), [0]);
    assert_eq!(
        noted("Group(when: MaxAcceleration(above: 9), NOTE)"),
        (1..12).collect::<Vec<_>>()
    );
    assert!(noted("Group(when: TimeStep(below: 0.0009), NOTE)").is_empty());
    assert!(noted("Group(when: Iterations(above: 0), NOTE)").is_empty());
    assert_eq!(
        noted("Group(every: 2, when: Time(above: 0.0055), NOTE)"),
        [6, 8, 10]
    );
}

#[test]
#[expect(clippy::too_many_lines, reason = "a list of cases")]
fn groups_that_mean_nothing_are_refused_with_the_reason() {
    let group = |stages: &str, what: &str| STAGES.replace(&format!("Run(\"{what}\")"), stages);
    for (stages, reason) in [
        (
            group("Group(every: 0, stages: [])", "gravity"),
            "count of 0",
        ),
        (
            group("Group(every: 2, offset: 2, stages: [])", "gravity"),
            "from 0 to 1",
        ),
        (
            group("Group(when: MaxSpeed(), stages: [])", "gravity"),
            "has no range",
        ),
        (
            group(
                "Group(when: Time(above: 2, below: 1), stages: [])",
                "gravity",
            ),
            "has no range",
        ),
        (
            group("Group(when: Time(above: inf), stages: [])", "gravity"),
            "has no range",
        ),
        (
            group(
                "Group(when: Time(above: 1), stages: [Run(\"integrate\")])",
                "integrate",
            ),
            "has to run in every step",
        ),
        (
            group(
                "Group(when: Time(above: 1), stages: [Run(\"reorder\")])",
                "reorder",
            ),
            "has to run in every step",
        ),
        (
            group(
                "Group(when: Time(above: 1), stages: [Run(\"density\")])",
                "density",
            ),
            "only under a condition",
        ),
        (
            group("SubSteps(2, [Run(\"clear_forces\")])", "clear_forces"),
            "adds no force",
        ),
        (
            group("SubSteps(2, [Run(\"density\")])", "density"),
            "adds no force",
        ),
        (
            group("SubSteps(0, [Run(\"gravity\")])", "gravity"),
            "count of 0",
        ),
        (
            group("SubSteps(300, [Run(\"gravity\")])", "gravity"),
            "at most 256",
        ),
        (
            group("SubSteps(2, [InPressure([])])", "pressure"),
            "within another",
        ),
        (
            group("InPressure([Run(\"integrate\")])", "pressure"),
            "adds no force",
        ),
        (
            group("InPressure([SubSteps(2, [])])", "pressure"),
            "within another",
        ),
    ] {
        let (scene, _folder) = ordered(&format!("(stages: [{stages}], allow_stale: true)"));
        let scene = Scene {
            pressure: pcisph(),
            ..scene
        };
        let error = plan(&scene).expect_err(&stages).to_string();
        assert!(error.contains(reason), "{stages}: {error}");
        assert!(error.contains("order.ron:"), "{error}");
    }
    let inside = STAGES.replace(r#"Run("pressure")"#, "InPressure([])");
    let (scene, _folder) = ordered(&format!("(stages: [{inside}])"));
    let error = plan(&scene).expect_err("SESPH").to_string();
    assert!(error.contains("iterates"), "{error}");
}

#[test]
fn a_rare_product_that_is_also_made_under_a_condition_is_an_experiment() {
    let rare = r#"Every(4, [Run("find_neighbours")]),
        Group(when: MaxSpeed(above: 0.1), stages: [Run("find_neighbours")])"#;
    let stages = STAGES.replace(r#"Run("find_neighbours")"#, rare);
    let (scene, _folder) = ordered(&format!("(stages: [{stages}], allow_stale: true)"));
    let planned = plan(&scene).expect("a plan");
    let lines: Vec<_> = planned
        .phases
        .into_iter()
        .flat_map(|(_, lines)| lines)
        .collect();
    let conditional = "when MaxSpeed(above: 0.1): find_neighbours".to_owned();
    assert!(lines.contains(&conditional), "{lines:?}");
    common::run(&mut common::simulation(&scene), 10);
}

#[test]
fn one_sub_step_and_no_force_within_pressure_change_no_bit() {
    let sub_step = STAGES.replace(
        r#"Run("gravity"),
    Run("wall_pressure"), Run("viscosity")"#,
        r#"SubSteps(1, [Run("gravity"), Run("wall_pressure"), Run("viscosity")])"#,
    );
    let inside = STAGES.replace(r#"Run("pressure")"#, "InPressure([])");
    assert!(sub_step != STAGES && inside != STAGES);
    // δ-SPH has a stage more.
    for pressure in &common::methods()[..4] {
        let pressure = *pressure;
        let expected = bits_after(
            &Scene {
                pressure,
                ..unordered()
            },
            2,
            20,
        );
        for stages in [&sub_step, &inside] {
            if pressure == common::sesph() && *stages == inside {
                continue;
            }
            let (scene, _folder) = ordered(&format!("(stages: [{stages}])"));
            let scene = Scene { pressure, ..scene };
            for threads in [1, 3] {
                assert!(
                    bits_after(&scene, threads, 20) == expected,
                    "{pressure:?}: {stages}"
                );
            }
        }
    }
}

/// Velocity of a drop along x after one step of 1 ms \[m/s]; it begins with 2.
fn slowed(stages: &str, pressure: &str) -> f32 {
    let (scene, folder) = drop_with(stages, pressure);
    let path = folder.path().join("order.ron");
    let text = std::fs::read_to_string(&path).expect("an order");
    let text = text.replace(
        "leave_out: [\"viscosity\"]",
        "leave_out: [\"viscosity\", \"note\"]",
    );
    std::fs::write(&path, text).expect("a file");
    let mut simulation = with_host(&Scene {
        gravity: glam::Vec3::ZERO,
        ..scene
    });
    simulation.world_mut().resource_mut::<Clock>().next_dt = 0.01;
    run(&mut simulation, 1);
    let mut velocities = simulation.world_mut().query::<(&Velocity, &Position)>();
    let all: Vec<f32> = velocities
        .iter(simulation.world())
        .map(|(v, _)| v.0.x)
        .collect();
    all.iter().sum::<f32>() / all.len() as f32
}

/// Drag in one explicit step, in n sub-steps, and implicitly: `v (1 − k dt)`, `v (1 − k dt/n)^n`, `v/(1 + k dt)`.
#[test]
fn sub_steps_and_forces_within_pressure_see_the_velocities_that_they_change() {
    let step = DRAG * 0.01;
    let iterated = "pressure: Iisph(min_iterations: 40)";
    let rest = r#"Run("gravity")"#;
    for (stages, pressure, expected) in [
        (
            format!("{rest}, Run(\"slow_down\"), Run(\"pressure\")"),
            GAS,
            1.0 - step,
        ),
        (
            format!("{rest}, SubSteps(4, [Run(\"slow_down\")]), Run(\"pressure\")"),
            GAS,
            (1.0 - step / 4.0).powi(4),
        ),
        (
            format!("{rest}, SubSteps(100, [Run(\"slow_down\")]), Run(\"pressure\")"),
            GAS,
            (1.0 - step / 100.0).powi(100),
        ),
        (
            format!("{rest}, InPressure([Run(\"slow_down\")])"),
            iterated,
            1.0 / (1.0 + step),
        ),
    ] {
        let found = slowed(&stages, pressure) / 2.0;
        assert!(
            (found - expected).abs() < 1e-4,
            "{stages}: {found}, not {expected}"
        );
    }
}
