//! Runs that resume from a checkpoint: files, figures and rows are those of an uninterrupted run.

use std::fs;
use std::path::Path;

use overfall::output::Summary;
use tempfile::TempDir;

use crate::support::{TINY, assert_exit, folder_with, names, overfall, stderr};

/// The tiny scene with a gauge, an adaptive time step, and pictures.
fn folder() -> TempDir {
    let scene = TINY
        .replace("Fixed(0.0005)", "Cfl(factor: 0.2, min: 1e-5, max: 0.001)")
        .replace(
            "duration:",
            r#"gauges: [
        (name: "level", kind: Height(at: (0.05, 0, 0.05)), every: Steps(2), window: 0.002),
    ],
    duration:"#,
        );
    folder_with(&[("tiny.ron", &scene)])
}

/// The rows of a history without wall times.
fn history(folder: &Path) -> Vec<String> {
    let text = fs::read_to_string(folder.join("history.csv")).expect("a history");
    text.lines()
        .map(|row| row.split(',').take(13).collect::<Vec<_>>().join(","))
        .collect()
}

/// Asserts that the output of two runs is identical, except for wall times.
#[track_caller]
fn assert_same_run(a: &Path, b: &Path) {
    assert_eq!(history(a), history(b));
    for part in ["frames", "gauges"] {
        assert_eq!(names(&a.join(part)), names(&b.join(part)), "{part}");
        for name in names(&a.join(part)) {
            let [a, b] = [a, b].map(|run| fs::read(run.join(part).join(&name)).expect("a file"));
            assert!(a == b, "{part}/{name}");
        }
    }
    let [a, b] = [a, b].map(|run| {
        let series = fs::read_to_string(run.join("tiny.pvd")).expect("a series");
        let summary = Summary::read(&run.join("summary.json")).expect("a summary");
        let figures = (summary.steps, summary.frames, summary.simulated_s);
        (
            series,
            figures,
            summary.mean_iterations,
            summary.max_density_error,
        )
    });
    assert_eq!(a, b);
}

#[test]
fn a_run_goes_on_in_its_folder_as_if_it_had_not_stopped() {
    let folder = folder();
    let whole = ["run", "tiny.ron", "--steps", "40", "--out", "whole"];
    assert_exit(&overfall(&folder, &whole), 0);
    // The last checkpoint is that of step 15: later rows, readings and frames are written again.
    let part = [
        "run",
        "tiny.ron",
        "--steps",
        "19",
        "--out",
        "part",
        "--checkpoint",
        "5",
    ];
    assert_exit(&overfall(&folder, &part), 0);
    let rest = [
        "run",
        "tiny.ron",
        "--steps",
        "40",
        "--resume",
        "part",
        "--threads",
        "2",
    ];
    assert_exit(&overfall(&folder, &rest), 0);
    let [whole, part] = ["whole", "part"].map(|name| folder.path().join(name));
    assert_same_run(&whole, &part);
    assert!(names(&part).iter().all(|name| !name.starts_with("older_")));

    // From the file, then once more to the same end; then into another folder.
    let file = [
        "run",
        "tiny.ron",
        "--steps",
        "40",
        "--resume",
        "part/checkpoint.overfall",
    ];
    assert_exit(&overfall(&folder, &file), 0);
    assert_same_run(&whole, &part);
    assert_exit(
        &overfall(&folder, &[&file[..], &["--out", "other"]].concat()),
        0,
    );
    let other = folder.path().join("other");
    let (rows, all) = (history(&other), history(&whole));
    assert_eq!(rows[1..], all[16..]);
    for name in names(&other.join("frames")) {
        let [a, b] = [&other, &whole].map(|run| fs::read(run.join("frames").join(&name)).ok());
        assert!(a == b, "{name}");
    }
    assert_same_run(&whole, &part);
}

#[test]
fn what_cannot_be_resumed_is_refused_and_loses_nothing() {
    let folder = folder();
    let part = ["run", "tiny.ron", "--steps", "6", "--checkpoint", "3"];
    assert_exit(&overfall(&folder, &part), 0);
    let out = folder.path().join("out/tiny");
    let before = history(&out);
    let refused = |arguments: &[&str], words: &str| {
        let output = overfall(&folder, &[&["run", "tiny.ron"][..], arguments].concat());
        assert_exit(&output, 2);
        assert!(stderr(&output).contains(words), "{}", stderr(&output));
        assert_eq!(history(&out), before);
    };
    refused(&["--resume", "nothing"], "nothing");
    refused(&["--resume", "."], "--checkpoint");
    refused(&["--resume", "tiny.ron"], "no checkpoint of overfall");
    refused(
        &["--resume", "out/tiny", "--set", "gravity=(0,-1,0)"],
        "gravity",
    );
    refused(&["--resume", "out/tiny", "--force"], "--force");
    refused(&["--checkpoint", "5 parsecs"], "10min");
    let file = out.join("checkpoint.overfall");
    let mut bytes = fs::read(&file).expect("a checkpoint");
    bytes.truncate(bytes.len() / 2);
    fs::write(&file, &bytes).expect("a file");
    refused(&["--resume", "out/tiny"], "cut off");
}

/// A run that would end before its checkpoint would only remove output; rows that somebody took away are told of.
#[test]
fn an_end_before_the_checkpoint_is_refused_and_lost_rows_are_told() {
    let folder = folder();
    let first = [
        "run",
        "tiny.ron",
        "--quiet",
        "--steps",
        "12",
        "--out",
        "part",
        "--checkpoint",
        "10",
    ];
    assert_exit(&overfall(&folder, &first), 0);
    let part = folder.path().join("part");
    let before = history(&part);
    let again = ["run", "tiny.ron", "--quiet", "--resume", "part"];
    for (end, part) in [
        ("--steps=9", "ends at 9 steps"),
        ("--duration=0.0001", "ends at 0.0001 s"),
    ] {
        let refused = overfall(&folder, &[&again[..], &[end]].concat());
        assert_exit(&refused, 2);
        let errors = stderr(&refused);
        assert!(
            errors.contains("after 10 steps") && errors.contains(part),
            "{errors}"
        );
    }
    assert_eq!(history(&part), before);
    let text = fs::read_to_string(part.join("history.csv")).expect("a history");
    let rows: Vec<&str> = text.lines().collect();
    for (kept, told) in [(11, ""), (4, "3 of the 10 rows"), (0, "0 of the 10 rows")] {
        fs::write(part.join("history.csv"), rows[..kept].join("\n") + "\n").expect("a file");
        let resumed = overfall(&folder, &[&again[..], &["--steps=11"]].concat());
        assert_exit(&resumed, 0);
        let errors = stderr(&resumed);
        assert!(
            errors.contains(told) && errors.contains("are lost") != told.is_empty(),
            "{errors}"
        );
    }
}

#[cfg(unix)]
mod killed {
    use std::time::Duration;

    use super::*;
    use crate::signals::{LONG, folder, signal, spawn, wait, wait_until};
    use crate::support::command;

    #[test]
    fn runs_that_are_killed_and_interrupted_go_on_from_their_last_checkpoint() {
        let folder = folder();
        assert!(LONG.contains("long"));
        let out = folder.path().join("out/long");
        let file = out.join("checkpoint.overfall");
        let first = ["run", "long.ron", "--quiet", "--checkpoint", "2"];
        let again = [&first[..], &["--resume", "out/long"]].concat();
        for round in 0..4 {
            let before = fs::read(&file).ok();
            let arguments = if round == 0 { &first[..] } else { &again[..] };
            let mut run = spawn(command(&folder).args(arguments));
            wait_until("no newer checkpoint appears", || {
                fs::read(&file).ok() != before
            });
            // At any point of the step, or while files are written.
            std::thread::sleep(Duration::from_millis(7 * round));
            run.kill().expect("a running program");
            run.wait().expect("its end");
        }
        let before = fs::read(&file).expect("a checkpoint");
        let run = spawn(command(&folder).args(&again[..]));
        wait_until("no newer checkpoint appears", || {
            fs::read(&file).ok().as_ref() != Some(&before)
        });
        signal(&run, "INT");
        let (status, text) = wait(run);
        assert_eq!(status, Some(130), "{text}");
        let steps = Summary::read(&out.join("summary.json"))
            .expect("a summary")
            .steps;
        let goal = (steps + 3).to_string();
        let rest = ["run", "long.ron", "--quiet", "--steps", &goal];
        assert_exit(
            &overfall(&folder, &[&rest[..], &["--resume", "out/long"]].concat()),
            0,
        );
        assert_exit(
            &overfall(&folder, &[&rest[..], &["--out", "whole"]].concat()),
            0,
        );
        let whole = folder.path().join("whole");
        assert_eq!(history(&out), history(&whole));
        assert_eq!(names(&out.join("frames")), names(&whole.join("frames")));
        for name in names(&whole.join("frames")) {
            let [a, b] = [&out, &whole].map(|run| fs::read(run.join("frames").join(&name)).ok());
            assert!(a == b, "{name}");
        }
    }
}

/// Nobody finds out after a night that an order left no checkpoint.
#[test]
fn orders_that_hinder_checkpoints_are_told_of_at_the_start() {
    let folder = folder();
    let order = |lists: &str| {
        let text = include_str!("../../assets/orders/default.ron")
            .replace(r#"Run("find_neighbours")"#, lists)
            .replace("    ],", "    ], allow_stale: true,");
        fs::write(folder.path().join("order.ron"), text).expect("an order");
        let run = [
            "run",
            "tiny.ron",
            "--quiet",
            "--set=order=\"order.ron\"",
            "--set=reorder_interval=0",
            "--steps=1",
            "--checkpoint=1",
            "--force",
        ];
        overfall(&folder, &run)
    };
    let rare = order(r#"Every(500, [Run("find_neighbours")])"#);
    assert_exit(&rare, 0);
    let told = "warning: with this order a checkpoint is possible every 500 steps only";
    assert!(stderr(&rare).contains(told), "{}", stderr(&rare));
    let never = order(
        r#"Every(2, [Run("find_neighbours")]), Group(every: 2, offset: 1, stages: [Run("find_neighbours")])"#,
    );
    assert_exit(&never, 2);
    let told = "--checkpoint: with this order no checkpoint is possible";
    assert!(stderr(&never).contains(told), "{}", stderr(&never));
    let often = order(r#"Every(2, [Run("find_neighbours")])"#);
    assert_exit(&often, 0);
    assert_eq!(stderr(&often), "");
}
