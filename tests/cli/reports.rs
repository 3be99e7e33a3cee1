//! Results for programs: JSON of every command, provenance, where time went, fields, schema, completions, carets.

use std::fs;

use serde_json::Value;

use crate::support::{TINY, assert_exit, folder_with, folder_with_tiny, overfall, stderr, stdout};

fn parsed(text: &str) -> Value {
    serde_json::from_str(text).unwrap_or_else(|error| panic!("{error}: {text}"))
}

fn assert_provenance(summary: &Value) {
    let known = &summary["provenance"];
    assert_eq!(known["version"], env!("CARGO_PKG_VERSION"), "{summary}");
    let date = known["date"].as_str().expect("a date");
    assert!(date.len() == 20 && date.ends_with('Z'), "{date}");
    assert!(
        known["command"]
            .as_array()
            .is_some_and(|words| words.len() > 1),
        "{known}"
    );
    assert!(
        known["instruction_set"].is_string() && known["cores"].as_u64() > Some(0),
        "{known}"
    );
}

#[test]
fn a_run_says_where_it_comes_from_and_where_time_went() {
    let folder = folder_with_tiny();
    let output = overfall(
        &folder,
        &[
            "run",
            "tiny.ron",
            "--steps",
            "3",
            "--json",
            "--quiet",
            "--pictures",
        ],
    );
    assert_exit(&output, 0);
    assert!(stderr(&output).is_empty(), "{}", stderr(&output));
    let summary = parsed(stdout(&output));
    assert_provenance(&summary);
    let parts = summary["wall_s_by_part"].as_object().expect("parts");
    for part in [
        "setting up",
        "steps",
        "writer: frames",
        "writer: pictures",
        "contact sheet",
    ] {
        assert!(parts.contains_key(part), "{part} is missing: {parts:?}");
    }
    let main: f64 = parts
        .iter()
        .filter(|part| !part.0.starts_with("writer"))
        .filter_map(|part| part.1.as_f64())
        .sum();
    assert!(
        main <= summary["wall_s"].as_f64().expect("a time") + 1e-3,
        "{summary}"
    );
    let file = fs::read_to_string(folder.path().join("out/tiny/summary.json")).expect("a summary");
    assert_eq!(parsed(&file), summary);
    let text = overfall(&folder, &["run", "tiny.ron", "--steps", "3", "--force"]);
    assert!(
        stdout(&text).contains("wall time") && stdout(&text).contains("writer: frames"),
        "{}",
        stdout(&text)
    );
}

/// `check` takes the options of the run, and says what the run would do with them.
#[test]
fn check_takes_what_run_takes() {
    let folder = folder_with_tiny();
    let options = [
        "tiny.ron",
        "--set",
        "spacing=0.01",
        "--duration",
        "0.02",
        "--frames-per-second",
        "10",
        "--out",
        "there",
        "--format",
        "ply",
        "--pictures",
        "--threads",
        "2",
        "--exact-times",
        "--checkpoint",
        "30",
        "--force",
    ];
    let output = overfall(&folder, &[&["check"], &options[..]].concat());
    assert_exit(&output, 0);
    for part in [
        "1000 fluid",
        "0.02 s, about",
        "there (ply, pictures), 10 frames per second",
        "threads         2",
    ] {
        assert!(
            stdout(&output).contains(part),
            "{part} is missing: {}",
            stdout(&output)
        );
    }
    let output = overfall(
        &folder,
        &[&["check"], &options[..], &["--json", "--quiet"]].concat(),
    );
    let plan = parsed(stdout(&output));
    assert_eq!(
        (&plan["particles"], &plan["threads"]),
        (&1000.into(), &2.into()),
        "{plan}"
    );
    assert!((plan["duration_s"].as_f64().expect("a time") - 0.02).abs() < 1e-6);
    assert!(
        plan["time_step_limits"]
            .as_array()
            .is_some_and(|limits| !limits.is_empty())
    );
    assert!(!folder.path().join("there").exists() && !folder.path().join("out").exists());
    let output = overfall(&folder, &["check", "tiny.ron", "--resume", "nowhere"]);
    assert_exit(&output, 2);
}

const STUDY: &str = r#"(
    name: "small",
    scene: "tiny.ron",
    blocks: 1,
    block: Steps(2),
    variants: [(name: "stored"), (name: "recomputed", set: ["neighbours=Recomputed"])],
    columns: [(name: "ms", measure: Milliseconds([density, pressure]))],
)"#;

#[test]
fn a_study_takes_overrides_and_prints_json() {
    let folder = folder_with_tiny();
    fs::write(folder.path().join("study.ron"), STUDY).expect("a study");
    let output = overfall(
        &folder,
        &[
            "study",
            "study.ron",
            "--set",
            "duration=0.01",
            "--json",
            "--quiet",
            "--out",
            "o",
        ],
    );
    assert_exit(&output, 0);
    assert!(stderr(&output).is_empty(), "{}", stderr(&output));
    let summary = parsed(stdout(&output));
    assert_provenance(&summary);
    let rows = summary["rows"].as_array().expect("rows");
    assert!(
        rows.iter().all(|row| row["figures"]
            .as_object()
            .is_some_and(|figures| !figures.is_empty())),
        "{summary}"
    );
    let output = overfall(
        &folder,
        &["study", "study.ron", "--set", "spacings=1", "--out", "p"],
    );
    assert_exit(&output, 2);
    assert!(
        stderr(&output).contains("--set spacings=1") && stderr(&output).contains("`spacing`"),
        "{}",
        stderr(&output)
    );
}

#[test]
fn cases_are_listed_as_json() {
    let folder = folder_with_tiny();
    let output = overfall(&folder, &["validate", "--list", "--json"]);
    assert_exit(&output, 0);
    assert!(
        parsed(stdout(&output))["cases"]
            .as_array()
            .is_some_and(|cases| cases.len() > 3)
    );
}

#[test]
fn fields_and_schema_come_from_the_types() {
    let folder = folder_with_tiny();
    let output = overfall(&folder, &["fields"]);
    assert_exit(&output, 0);
    for part in ["spacing", "Laminar(…)", "m²/s", "required", "WallMotion"] {
        assert!(
            stdout(&output).contains(part),
            "{part} is missing: {}",
            stdout(&output)
        );
    }
    let some = overfall(&folder, &["fields", "oscillation"]);
    assert!(stdout(&some).contains("Oscillation") && !stdout(&some).contains("rest_density"));
    assert_exit(&overfall(&folder, &["fields", "no such thing"]), 2);
    let schema = overfall(&folder, &["schema"]);
    assert!(parsed(stdout(&schema))["properties"]["spacing"]["description"].is_string());
    assert_eq!(
        stdout(&schema),
        stdout(&overfall(&folder, &["fields", "--json"]))
    );
}

#[test]
fn shells_complete_every_command() {
    let folder = folder_with_tiny();
    for shell in ["bash", "zsh", "fish"] {
        let output = overfall(&folder, &["completions", shell]);
        assert_exit(&output, 0);
        for part in ["validate", "frames-per-second", "completions"] {
            assert!(stdout(&output).contains(part), "{shell}: {part} is missing");
        }
    }
    assert_exit(&overfall(&folder, &["completions", "csh"]), 2);
}

/// The line that an error speaks of, in the file that it is in, with carets under the place.
#[test]
fn errors_show_their_line() {
    let folder = folder_with(&[
        ("tiny.ron", &TINY.replace("spacing:", "spaceing:")),
        (
            "parts.ron",
            &TINY
                .replace("bodies:", "include: \"walls.ron\",\n    bodies:")
                .replacen(
                    "boundaries: [Tank(min: (0.0, 0.0, 0.0), max: (0.2, 0.2, 0.1))],",
                    "",
                    1,
                ),
        ),
        (
            "walls.ron",
            "(boundaries: [\n    Tunk(min: (0.0, 0.0, 0.0), max: (0.2, 0.2, 0.1)),\n])",
        ),
    ]);
    for (scene, place, line, carets) in [
        (
            "tiny.ron",
            "tiny.ron:3:5: ",
            "3 |     spaceing: 0.02,",
            "^^^^^^^^",
        ),
        (
            "parts.ron",
            "walls.ron:2:5: ",
            "2 |     Tunk(min: (0.0, 0.0, 0.0)",
            "^^^^",
        ),
    ] {
        let output = overfall(&folder, &["check", scene]);
        assert_exit(&output, 2);
        let text = stderr(&output);
        assert!(text.starts_with(&format!("error: {place}")), "{text}");
        assert!(text.contains(line), "{text}");
        let under = text
            .lines()
            .find(|line| line.contains('^'))
            .expect("carets");
        assert!(under.ends_with(&format!("|     {carets}")), "{text}");
    }
}
