//! Checkpoints of runs whose order has groups.

use overfall::{
    checkpoint::{self, Checkpoint},
    scene::{Dfsph, Iisph, PressureMethod, Scene, TimeStep},
};

use super::orders::{STAGES, ordered};
use crate::common::{self, bits, pcisph, run};

/// Runs two simulations on, the second from a checkpoint of the first.
fn assert_resumes(scene: &Scene, before: usize) {
    let mut whole = common::simulation(scene);
    run(&mut whole, before);
    let checkpoint = Checkpoint::of(whole.world_mut()).unwrap_or_else(|error| panic!("{error}"));
    let mut part = common::simulation(scene);
    checkpoint.restore(part.world_mut()).expect("its state");
    run(&mut whole, 11);
    run(&mut part, 11);
    assert!(
        bits(part.world_mut()) == bits(whole.world_mut()),
        "{before} steps"
    );
}

#[test]
fn runs_with_groups_resume_to_the_bit() {
    let groups = STAGES.replace(
        r#"Run("viscosity"), Run("surface_tension"), Run("pressure")"#,
        r#"Group(every: 3, offset: 1, when: MaxSpeed(above: 0.1), stages: [Run("viscosity")]),
            Every(2, [SubSteps(2, [Run("surface_tension")])]),
            InPressure([Group(every: 2, stages: [Run("viscosity")])])"#,
    );
    assert!(groups != STAGES);
    for (pressure, time_step) in [
        (PressureMethod::Iisph(Iisph::default()), "Fixed"),
        (PressureMethod::Dfsph(Dfsph::default()), "Cfl"),
        (pcisph(), "Adaptive"),
    ] {
        let (scene, _folder) = ordered(&format!("(stages: [{groups}])"));
        let scene = Scene {
            pressure,
            time_step: match time_step {
                "Fixed" => scene.time_step,
                "Cfl" => TimeStep::default(),
                _ => TimeStep::Adaptive(overfall::scene::Adaptive::default()),
            },
            reorder_interval: 6,
            ..scene
        };
        // One is the step after a reordering.
        for before in [1, 4, 5, 6] {
            assert_resumes(&scene, before);
        }
    }
}

#[test]
fn checkpoints_wait_until_all_stale_products_are_due() {
    let with = |groups: &str| {
        let stages = STAGES.replace(r#", Run("reorder")"#, "");
        let stages = stages.replace(r#"Run("find_neighbours")"#, groups);
        ordered(&format!(
            "(stages: [{stages}], allow_stale: true, leave_out: [\"reorder\"])"
        ))
    };
    let (scene, _folder) = with(r#"Group(every: 5, offset: 3, stages: [Run("find_neighbours")])"#);
    let mut simulation = common::simulation(&scene);
    run(&mut simulation, 4);
    assert_eq!(checkpoint::steps_until_possible(simulation.world_mut()), 4);
    assert_resumes(&scene, 8);
    let (scene, _folder) = with(
        r#"Group(every: 2, offset: 1, stages: [Run("find_neighbours")]), Every(4, [Run("find_neighbours")])"#,
    );
    let mut simulation = common::simulation(&scene);
    run(&mut simulation, 4);
    let error = Checkpoint::of(simulation.world_mut()).expect_err("never");
    assert!(
        error.to_string().contains("no checkpoint is possible"),
        "{error}"
    );
}

#[test]
fn an_order_with_other_groups_is_of_another_run() {
    let of = |group: &str| {
        ordered(&format!(
            "(stages: [{}])",
            STAGES.replace(r#"Run("viscosity")"#, group)
        ))
    };
    let (first, _a) = of(r#"Group(when: MaxSpeed(above: 0.5), stages: [Run("viscosity")])"#);
    let (second, _b) = of(r#"Group(when: MaxSpeed(above: 0.6), stages: [Run("viscosity")])"#);
    let mut simulation = common::simulation(&first);
    run(&mut simulation, 2);
    let checkpoint = Checkpoint::of(simulation.world_mut()).expect("a checkpoint");
    let mut other = common::simulation(&Scene {
        order: second.order,
        ..first
    });
    let error = checkpoint
        .restore(other.world_mut())
        .expect_err("another order");
    assert!(error.to_string().contains("another run"), "{error}");
}
