//! Trials of a scene on the command line: `check --cost` and `advise`.

use crate::support::{TINY, assert_exit, folder_with, overfall, stderr, stdout};
use serde_json::Value;

#[test]
#[expect(clippy::too_many_lines, reason = "a list of cases")]
fn check_says_what_every_part_costs_and_what_could_go() {
    let scene = TINY.replace(
        "duration:",
        "gauges: [(name: \"e\", kind: Energy)], duration:",
    );
    let folder = folder_with(&[("tiny.ron", &scene)]);
    let plain = overfall(&folder, &["check", "tiny.ron", "--quiet"]);
    assert!(!stdout(&plain).contains("Cost in"), "{}", stdout(&plain));
    let output = overfall(
        &folder,
        &[
            "check",
            "tiny.ron",
            "--quiet",
            "--cost",
            "--steps",
            "6",
            "--threads",
            "1",
        ],
    );
    assert_exit(&output, 0);
    let text = stdout(&output);
    for part in [
        "the scene is fine",
        "Cost in 6 steps",
        "find_neighbours",
        "ms a step",
        "viscosity",
        "bytes for a fluid particle",
        "without gauges",
        "without viscosity",
        "neighbours recomputed",
        "ten times the tolerance",
        "time step by the motion",
        "Within 1 %",
        "--set 'neighbours=Recomputed'",
    ] {
        assert!(text.contains(part), "{part} is not in\n{text}");
    }
    let output = overfall(
        &folder,
        &[
            "check",
            "tiny.ron",
            "--quiet",
            "--cost",
            "--steps=3",
            "--error",
            "1e9 %",
            "--json",
        ],
    );
    assert_exit(&output, 0);
    let json: Value = serde_json::from_str(stdout(&output)).expect("JSON");
    let cost = &json["cost"];
    assert_eq!(cost["steps"], 3);
    let savings = cost["savings"].as_array().expect("savings");
    let gauges = savings
        .iter()
        .find(|of| of["what"] == "without gauges")
        .expect("gauges");
    assert_eq!(gauges["difference"], 0.0);
    // Of an error without limit everything that saves memory could go.
    let recomputed = savings
        .iter()
        .find(|of| of["what"] == "neighbours recomputed")
        .expect("neighbours");
    assert_eq!(recomputed["could_go"], true);
    assert!(
        json["cost"]["phases"]
            .as_array()
            .is_some_and(|phases| phases.len() == 8)
    );
    for wrong in ["0", "-1", "much", "NaN"] {
        let output = overfall(
            &folder,
            &["check", "tiny.ron", "--cost", &format!("--error={wrong}")],
        );
        assert_exit(&output, 2);
    }
    assert_exit(
        &overfall(&folder, &["check", "tiny.ron", "--error", "1%"]),
        2,
    );
}

#[test]
fn advice_is_lines_to_paste_and_the_next_cheaper() {
    let scene = TINY.replace("spacing: 0.02", "spacing: 0.025");
    let folder = folder_with(&[("tiny.ron", &scene)]);
    let arguments = [
        "advise",
        "tiny.ron",
        "--quiet",
        "--threads",
        "1",
        "--time",
        "0.05",
        "--error",
    ];
    let output = overfall(&folder, &[&arguments[..], &["1000%"]].concat());
    assert_exit(&output, 0);
    let text = stdout(&output);
    for part in [
        "errors of `energy`",
        "The cheapest that hold 1000 %",
        "    pressure: ",
        "    time_step: Cfl(factor: 0.",
    ] {
        assert!(text.contains(part), "{part} is not in\n{text}");
    }
    assert!(
        text.contains("The next cheaper, ") || text.contains("None of the others is cheaper."),
        "{text}"
    );
    // The lines run.
    let (_, after) = text.split_once("The cheapest that hold").expect("found");
    let sets: Vec<String> = after
        .lines()
        .skip(1)
        .filter(|line| line.starts_with("    "))
        .map(str::trim)
        .map(|line| line.trim_end_matches(',').replacen(": ", "=", 1))
        .collect();
    assert!(!sets.is_empty(), "{text}");
    let mut check = vec!["check", "tiny.ron", "--quiet"];
    for set in &sets {
        check.extend(["--set", set]);
    }
    assert_exit(&overfall(&folder, &check), 0);
    let output = overfall(&folder, &[&arguments[..], &["1e-9%", "--json"]].concat());
    assert_exit(&output, 1);
    let json: Value = serde_json::from_str(stdout(&output)).expect("JSON");
    assert!(
        json["chosen"].is_null()
            && json["tried"]
                .as_array()
                .is_some_and(|tried| tried.len() > 10)
    );
    assert!(
        stderr(&output).contains("no setting holds"),
        "{}",
        stderr(&output)
    );
    let output = overfall(
        &folder,
        &["advise", "tiny.ron", "--time", "0.01", "--measure", "enrgy"],
    );
    assert_exit(&output, 2);
    assert!(
        stderr(&output).contains("did you mean `energy`?"),
        "{}",
        stderr(&output)
    );
}
