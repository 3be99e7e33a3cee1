//! Order files that are refused before the first step, each with its reason.

use bevy_ecs::prelude::*;
use overfall::{Simulation, install, plan, scene::Scene, step::InstallError};

use super::orders::{STAGES, ordered, unordered};
use crate::common::bits_after;

/// The stages with one replaced, and the rest of the order file.
fn check(stages: &str, rest: &str, change: impl Fn(&mut Scene)) -> Result<(), String> {
    let (mut scene, _folder) = ordered(&format!("(stages: [{stages}]{rest})"));
    change(&mut scene);
    plan(&scene).map(|_| ()).map_err(|error| error.to_string())
}

#[test]
fn time_may_not_wait_for_itself() {
    for stages in [
        format!("Every(2, [{STAGES}])"),
        format!("Every(1000, [{STAGES}])"),
        format!("Every(1, [Every(3, [{STAGES}])])"),
        format!("Repeat(2, [Every(2, [{STAGES}])])"),
        STAGES.replace(r#"Run("integrate")"#, r#"Every(2, [Run("integrate")])"#),
        STAGES.replace(
            r#"Run("pressure"), Run("integrate")"#,
            r#"Every(2, [Run("pressure"), Run("integrate")])"#,
        ),
    ] {
        for rest in ["", ", allow_stale: true"] {
            let error = check(&stages, rest, |_| {}).expect_err(&stages);
            assert!(error.contains("it alone counts the steps"), "{error}");
        }
    }
}

#[test]
fn counts_that_overflow_or_never_end_are_refused_at_once() {
    let most = u32::MAX;
    for (stages, reason) in [
        (
            format!("Every({most}, [Every({most}, [Every({most}, [{STAGES}])])])"),
            "nested `Every`",
        ),
        (format!("Repeat(400000000, [{STAGES}])"), "stages"),
        (
            STAGES.replace(r#"Run("density")"#, r#"Repeat(10000, [Run("density")])"#),
            "at most 256",
        ),
        (
            format!("Repeat({most}, [Repeat({most}, [Repeat({most}, [{STAGES}])])])"),
            "at most 256",
        ),
    ] {
        let error = check(&stages, "", |_| {}).expect_err(&stages);
        assert!(error.contains(reason), "{error}");
    }
    // An empty list, very often.
    let mut empty = format!("Repeat({most}, [])");
    for _ in 0..20 {
        empty = format!("Repeat(2, [{empty}])");
    }
    let stages = format!("{empty}, {STAGES}");
    assert_eq!(check(&stages, "", |_| {}), Ok(()));
    let (scene, _folder) = ordered(&format!("(stages: [{stages}])"));
    assert!(bits_after(&scene, 1, 2) == bits_after(&unordered(), 1, 2));
}

#[test]
fn what_is_left_over_by_row_does_not_outlive_a_reordering() {
    for (stage, every, interval, accepted) in [
        ("find_neighbours", 5, 7, false),
        ("find_neighbours", 5, 25, true),
        ("find_neighbours", 5, 0, true),
        ("find_neighbours", 2, 1, false),
        ("density", 3, 20, false),
        ("density", 4, 20, true),
        ("pressure", 2, 5, false),
        ("viscosity", 2, 5, true),
    ] {
        let stages = STAGES.replace(
            &format!("Run(\"{stage}\")"),
            &format!("Every({every}, [Run(\"{stage}\")])"),
        );
        let checked = check(&stages, ", allow_stale: true", |scene| {
            scene.reorder_interval = interval;
        });
        match checked {
            Ok(()) => assert!(accepted, "{stage} every {every}, {interval}"),
            Err(error) => assert!(
                !accepted && error.contains("`reorder`"),
                "{stage} every {every}, {interval}: {error}"
            ),
        }
    }
    // Also within one step.
    let within = STAGES.replace(
        r#"Run("density")"#,
        r#"Run("reorder"), Run("gather"), Run("rebuild_index"), Run("density")"#,
    );
    let error = check(&within, ", allow_stale: true", |_| {}).expect_err("lists of other rows");
    assert!(error.contains("`reorder`"), "{error}");
}

#[test]
fn a_stage_that_the_scene_wants_is_missed_unless_it_is_left_out() {
    for stage in ["viscosity", "surface_tension", "reorder"] {
        let stages = STAGES.replace(&format!("Run(\"{stage}\")"), "");
        let stages = stages.replace(",,", ",").replace(", ,", ",");
        let stages = stages.trim_end_matches([' ', ',', '\n']);
        let stages = stages.replace(",\n    ,", ",");
        let error = check(&stages, "", |_| {}).expect_err("physics that is missing");
        assert!(error.contains(&format!("never runs `{stage}`")), "{error}");
        let leave_out = format!(", leave_out: [\"{stage}\"]");
        assert_eq!(check(&stages, &leave_out, |_| {}), Ok(()));
        let both = check(STAGES, &leave_out, |_| {}).expect_err("both");
        assert!(both.contains("remove one"), "{both}");
        // A scene that does not need it misses nothing.
        let plain = |scene: &mut Scene| {
            scene.reorder_interval = 0;
            scene.fluid.viscosity = overfall::scene::Viscosity::None;
            scene.fluid.surface_tension = overfall::scene::SurfaceTension::None;
        };
        assert_eq!(check(&stages, "", plain), Ok(()));
    }
    let slip = check(STAGES, ", leave_out: [\"viscosty\"]", |_| {}).expect_err("a slip");
    assert!(slip.contains("did you mean `viscosity`?"), "{slip}");
}

#[test]
fn a_wrong_order_is_refused_with_its_path_and_the_reason() {
    let cases = [
        (
            STAGES.replace("\"density\"", "\"densty\""),
            "did you mean `density`?",
        ),
        (
            STAGES.replace(r#"Run("find_neighbours"),"#, ""),
            "needs neighbours",
        ),
        (
            STAGES.replace(r#"Run("clear_forces"), Run("gravity"),"#, ""),
            "needs accelerations without pressure",
        ),
        (
            STAGES.replace(r#"Run("integrate"),"#, ""),
            "never runs `integrate`",
        ),
        (
            STAGES.replace(r#"Run("density")"#, r#"Every(2, [Run("density")])"#),
            "left over from an earlier step",
        ),
        (format!("{STAGES}, Run(\"density\")"), "needs the columns"),
        (format!("Repeat(0, [{STAGES}])"), "count of 0"),
        (STAGES.replace(r#"Run("density")"#, "Run(density)"), "1:"),
    ];
    for (stages, reason) in cases {
        let (scene, _folder) = ordered(&format!("(stages: [{stages}])"));
        let path = scene.order.clone().expect("a path");
        let error = match Simulation::with_threads(&scene, 1) {
            Ok(_) => panic!("accepted: {stages}"),
            Err(error) => error,
        };
        assert!(matches!(error, InstallError::Order { place: Some(_), .. }));
        let text = error.to_string();
        assert!(
            text.contains(&path) && text.contains(reason),
            "{stages}: {text}"
        );
        let planned = plan(&scene).expect_err("no plan either").to_string();
        assert_eq!(planned, text);
    }
}

#[test]
fn an_absent_order_file_is_named() {
    let (scene, folder) = ordered("");
    drop(folder);
    let error = Simulation::with_threads(&scene, 1).err().expect("no file");
    assert!(matches!(error, InstallError::OrderFile { .. }), "{error}");
    assert!(error.to_string().contains("order.ron"), "{error}");
}

#[test]
fn a_refused_order_leaves_the_world_as_it_was() {
    let (wrong, _folder) = ordered("(stages: [])");
    let mut world = World::new();
    let entities = |world: &mut World| world.query::<Entity>().iter(world).count();
    let before = entities(&mut world);
    install(&mut world, &wrong).expect_err("an order without stages");
    assert_eq!(entities(&mut world), before);
    install(&mut world, &unordered()).expect("the world is free");
}

#[test]
fn columns_are_never_stale() {
    for stages in [
        STAGES.replace(r#"Run("gather")"#, r#"Every(2, [Run("gather")])"#),
        STAGES.replace(
            r#"Run("gather"), Run("rebuild_index")"#,
            r#"Every(2, [Run("gather"), Run("rebuild_index")])"#,
        ),
        STAGES.replace(r#"Run("gather"), "#, ""),
    ] {
        let stages = stages.replace(r#", Run("reorder")"#, "");
        let rest = ", allow_stale: true, leave_out: [\"reorder\"]";
        let error = check(&stages, rest, |_| {}).expect_err(&stages);
        assert!(
            error.contains("needs the columns") && error.contains("`gather` makes it"),
            "{error}"
        );
        assert!(!error.contains("allow_stale"), "{error}");
    }
}

#[test]
fn rows_are_reordered_at_one_interval() {
    let stages = STAGES.replace(r#"Run("reorder")"#, r#"Every(7, [Run("reorder")])"#);
    let error = check(&stages, "", |_| {}).expect_err("two intervals");
    assert!(error.contains("`reorder_interval`"), "{error}");
}

#[test]
fn an_error_names_the_line_and_column_of_its_item() {
    for (stages, line, column) in [
        ("\n  Run(\"gather\"),\n  Run(\"density\")", 3, 3),
        (
            "\n  Run(\"gather\"),\n  Every(2, [Run(\"gather\"),\n    Run(\"nothing\")])",
            4,
            5,
        ),
        (
            "Run(\"gather\"),\n Repeat(3, [\n\n      Every(0, [])])",
            4,
            7,
        ),
    ] {
        let (scene, _folder) = ordered(&format!("(stages: [{stages}])"));
        let path = scene.order.clone().expect("a path");
        let error = plan(&scene).expect_err(stages).to_string();
        assert!(
            error.starts_with(&format!("{path}:{line}:{column}: ")),
            "{error}"
        );
    }
    let (scene, _folder) = ordered(&format!("(stages: [{STAGES}],\n leave_out: [\"nothing\"])"));
    let path = scene.order.clone().expect("a path");
    let error = plan(&scene).expect_err("no such stage").to_string();
    let line = 2 + STAGES.matches('\n').count();
    assert!(error.starts_with(&format!("{path}:{line}:14: ")), "{error}");
}
