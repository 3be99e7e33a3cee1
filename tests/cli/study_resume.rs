//! Studies that are killed and go on.
#![cfg(unix)]

use std::fs;
use std::path::Path;

use super::signals::{spawn, wait_until};
use super::study::{figures, folder};
use crate::support::{assert_exit, command, overfall, stderr};

/// Figures that do not depend on the machine, by variant and column.
fn exact(table: &Path) -> Vec<String> {
    let csv = fs::read_to_string(table).expect("a table");
    let figures = figures(&csv);
    let exact = figures
        .iter()
        .filter(|((_, column), _)| column == "iterations" || column == "error");
    exact
        .map(|(key, fields)| format!("{key:?} {}", fields["value"]))
        .collect()
}

#[test]
fn a_study_that_is_killed_goes_on_and_repeats_nothing() {
    let study = r#"(
        name: "long",
        scene: "tiny.ron",
        start: (time: 0.002),
        variants: [(name: "a"), (name: "b", set: ["reorder_interval=3"]), (name: "bad", set: ["time_step=Fixed(1)"])],
        block: Steps(4),
        blocks: 12,
        columns: [(name: "iterations", measure: Iterations), (name: "error", measure: MeanDensityError),
            (name: "distance", measure: Distance)],
    )"#;
    let folder = folder(study);
    let whole = overfall(&folder, &["study", "s.ron", "--quiet", "--out", "whole"]);
    assert_exit(&whole, 0);
    let arguments = ["study", "s.ron", "--quiet", "--out", "part"];
    let file = folder.path().join("part/progress.overfall");
    for round in 0..3 {
        let before = fs::read(&file).ok();
        let rest = if round == 0 { &[][..] } else { &["--resume"] };
        let mut run = spawn(command(&folder).args(arguments).args(rest));
        wait_until("no progress appears", || {
            let ended = run.try_wait().expect("it can be waited for").is_some();
            ended || fs::read(&file).ok() != before
        });
        let _ = run.kill();
        run.wait().expect("its end");
    }
    assert_exit(
        &overfall(&folder, &[&arguments[..], &["--resume"]].concat()),
        0,
    );
    let [part, whole] =
        ["part", "whole"].map(|run| exact(&folder.path().join(run).join("table.csv")));
    assert_eq!(part, whole);
    assert!(part.len() >= 4, "{part:?}");
    // Once more: there is nothing left to do. And another study is refused.
    assert_exit(
        &overfall(&folder, &[&arguments[..], &["--resume"]].concat()),
        0,
    );
    fs::write(
        folder.path().join("s.ron"),
        study.replace("Steps(4)", "Steps(5)"),
    )
    .expect("a file");
    let output = overfall(&folder, &[&arguments[..], &["--resume"]].concat());
    assert_exit(&output, 2);
    assert!(
        stderr(&output).contains("has changed since"),
        "{}",
        stderr(&output)
    );
    let none = overfall(&folder, &["study", "s.ron", "--resume", "--out", "none"]);
    assert_exit(&none, 2);
}
