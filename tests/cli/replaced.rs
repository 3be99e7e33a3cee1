//! Results that `--force` replaces: the older ones stay as they are until the new ones are complete.

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;

use tempfile::TempDir;

use super::signals::{signal, spawn, wait, wait_until};
use crate::running::Running;
use crate::support::{
    assert_exit, command, folder_with_tiny, names, overfall, read_json, stderr, stdout,
};
use crate::{frontier, stability, study};

/// Files of a folder that are results, by name, with their content.
fn results(folder: &Path) -> BTreeMap<String, Vec<u8>> {
    let mut found = BTreeMap::new();
    for name in names(folder) {
        let path = folder.join(&name);
        if path.is_dir() && !name.starts_with("older_") && name != "unfinished" {
            let within = results(&path).into_iter();
            found.extend(within.map(|(file, bytes)| (format!("{name}/{file}"), bytes)));
        } else if path.is_file() && name != ".overfall_lock" {
            found.insert(name, fs::read(&path).expect("a file"));
        }
    }
    found
}

/// Waits until a program has done something; it must not end before.
fn wait_for(run: &mut Running, mut is_so: impl FnMut() -> bool) {
    wait_until("nothing appears", || {
        let ended = run.try_wait().expect("it can be waited for");
        assert_eq!(ended, None, "it ended");
        is_so()
    });
}

/// Stops a study that replaces an older one, by a kill and by Ctrl-C, and then lets it end.
fn replace(folder: &TempDir, out: &str, file: &str, [short, long]: [&str; 2]) {
    assert_ne!(short, long);
    let out = folder.path().join("out").join(out);
    let study = folder.path().join("s.ron");
    fs::write(&study, short).expect("a file");
    let arguments = ["study", "s.ron", "--quiet", "--threads", "2"];
    let force = [&arguments[..], &["--force"]].concat();
    assert_exit(&overfall(folder, &arguments), 0);
    let older = results(&out);
    assert!(older.len() >= 4, "{:?}", older.keys());
    let new = out.join("unfinished").join(file);
    let length = |path: &Path| fs::metadata(path).map_or(0, |file| file.len());
    for name in ["KILL", "INT"] {
        fs::write(&study, long).expect("a file");
        let mut run = spawn(command(folder).args(&force));
        // What the one before left is moved aside first.
        let aside = out.join("older_1");
        wait_for(&mut run, || name == "KILL" || aside.join(file).exists());
        let enough = length(&out.join(file)).max(length(&aside.join(file))) + 200;
        wait_for(&mut run, || length(&new) > enough);
        signal(&run, name);
        let (status, said) = wait(run);
        assert_eq!(status, (name == "INT").then_some(130), "{said}");
        assert!(results(&out) == older, "{name}: the older results changed");
        assert!(length(&new) > enough, "{name}: the new results are lost");
        if name == "INT" {
            assert!(said.contains("as they were"), "{said}");
            let summary = read_json(&out.join("unfinished/summary.json"));
            assert_eq!(summary["status"], "interrupted");
        }
    }
    fs::write(&study, short).expect("a file");
    let output = overfall(folder, &force);
    assert_exit(&output, 0);
    assert!(
        !stdout(&output).contains("unfinished"),
        "{}",
        stdout(&output)
    );
    let replaced = results(&out);
    assert!(replaced.keys().eq(older.keys()) && replaced != older);
    assert_eq!(read_json(&out.join("summary.json"))["status"], "done");
    // What was stopped is kept, each time once.
    let rest: Vec<String> = (names(&out).into_iter())
        .filter(|name| !older.contains_key(name) && name != ".overfall_lock")
        .collect();
    assert_eq!(rest, ["older_1", "older_2"]);
    assert!(length(&out.join("older_2").join(file)) > 0);
}

#[test]
fn a_table_is_replaced_when_the_new_one_is_complete() {
    let short = r#"(
        name: "table",
        scene: "tiny.ron",
        start: (time: 0.002),
        variants: [(name: "a"), (name: "b", set: ["reorder_interval=3"])],
        block: Steps(2),
        blocks: 2,
        columns: [(name: "iterations", measure: Iterations), (name: "wall", measure: TestedPairs)],
        chart: Ratios(columns: ["wall"]),
        baseline: "a",
    )"#;
    let columns: String = (0..40)
        .map(|k| format!("(name: \"c{k}\", measure: Iterations), "))
        .collect();
    let long = short
        .replace("blocks: 2", "blocks: 10000")
        .replace("columns: [(", &format!("columns: [{columns}("));
    replace(&study::folder(short), "table", "table.csv", [short, &long]);
}

#[test]
fn points_of_a_map_are_replaced_when_the_new_ones_are_complete() {
    let long = stability::STUDY.replace("count: 3", "count: 1000");
    let folder = stability::folder(stability::STUDY);
    replace(&folder, "where", "points.csv", [stability::STUDY, &long]);
}

#[test]
fn runs_of_a_frontier_are_replaced_when_the_new_ones_are_complete() {
    let long = frontier::STUDY
        .replace("repeats: 2", "repeats: 100")
        .replace("[4, 6]", "[4, 6, 12, 16]");
    let folder = frontier::folder(frontier::STUDY);
    replace(&folder, "fast", "runs.csv", [frontier::STUDY, &long]);
}

/// A study that was to replace another goes on where it stopped, and replaces it in the end.
#[test]
fn a_table_that_was_stopped_goes_on_and_replaces_the_older_one() {
    let text = |block: u32| {
        format!(
            "(name: \"on\", scene: \"tiny.ron\", start: (time: 0.002), variants: [(name: \"a\")], block: Steps({block}),
              blocks: 6, columns: [(name: \"iterations\", measure: Iterations)])"
        )
    };
    let folder = study::folder(&text(2));
    let quiet = ["study", "s.ron", "--quiet"];
    assert_exit(&overfall(&folder, &quiet), 0);
    let out = folder.path().join("out/on");
    let older = results(&out);
    fs::write(folder.path().join("s.ron"), text(20)).expect("a file");
    let mut run = spawn(command(&folder).args(quiet).arg("--force"));
    wait_until("no progress appears", || {
        let ended = run.try_wait().expect("it can be waited for").is_some();
        ended || out.join("unfinished/progress.overfall").exists()
    });
    let _ = run.kill();
    let is_done = run.wait().expect("its end").success();
    assert!(is_done || results(&out) == older);
    assert_exit(&overfall(&folder, &[&quiet[..], &["--resume"]].concat()), 0);
    let table = fs::read_to_string(out.join("table.csv")).expect("a table");
    assert!(
        table.contains(",120,") && !out.join("unfinished").exists(),
        "{table}"
    );
}

#[test]
fn a_run_is_replaced_when_the_new_one_is_done_and_resumes_where_it_stopped() {
    let folder = folder_with_tiny();
    let out = folder.path().join("out/tiny");
    assert_exit(
        &overfall(&folder, &["run", "tiny.ron", "--steps=9", "--quiet"]),
        0,
    );
    let older = results(&out);
    let long = ["run", "tiny.ron", "--duration=1000", "--quiet", "--force"];
    for name in ["KILL", "INT"] {
        let mut run = spawn(command(&folder).args(long));
        // What the one before left is moved aside first.
        let aside = out.join("older_1");
        wait_for(&mut run, || {
            name == "KILL" || aside.join("overfall_manifest.txt").exists()
        });
        wait_for(&mut run, || {
            out.join("unfinished/frames/frame_00003.vtu").exists()
        });
        signal(&run, name);
        let (status, said) = wait(run);
        assert_eq!(status, (name == "INT").then_some(130), "{said}");
        assert!(results(&out) == older, "{name}: the older run changed");
    }
    assert!(out.join("older_1/frames/frame_00003.vtu").exists());
    let steps = read_json(&out.join("unfinished/summary.json"))["steps"]
        .as_u64()
        .expect("a number");
    // A run that fails replaces nothing, either.
    let end = format!("--steps={}", steps + 3);
    let failing = [
        "run",
        "tiny.ron",
        "--steps=9",
        "--quiet",
        "--force",
        "--out=other",
    ];
    assert_exit(&overfall(&folder, &failing), 0);
    let other = folder.path().join("other");
    let before = results(&other);
    let wrong = [
        "--set=time_step=Fixed(1)",
        "--set=pressure=Pcisph(not_converged: Stop)",
    ];
    let output = overfall(&folder, &[&failing[..], &wrong].concat());
    assert_exit(&output, 1);
    assert!(results(&other) == before && stderr(&output).contains("as they were"));
    // Resumed, it goes on where it stopped, and then takes the place of the older one.
    let resumed = ["run", "tiny.ron", "--resume=out/tiny", &end, "--json"];
    let output = overfall(&folder, &resumed);
    assert_exit(&output, 0);
    assert!(!out.join("unfinished").exists());
    let summary = read_json(&out.join("summary.json"));
    assert_eq!(summary["steps"], steps + 3);
    assert_eq!(summary["status"], "done");
    let frames = summary["frames"].as_u64().expect("a number");
    assert_eq!(names(&out.join("frames")).len() as u64, frames);
    let history = fs::read_to_string(out.join("history.csv")).expect("a history");
    assert_eq!(
        history
            .lines()
            .filter(|line| !line.starts_with('#'))
            .count() as u64,
        steps + 4
    );
    assert_exit(&overfall(&folder, &["picture", "out/tiny"]), 0);
}
