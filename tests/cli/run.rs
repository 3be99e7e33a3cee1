//! `overfall run` as its user sees it: exit statuses, messages, files.

use std::fs;

use serde_json::Value;

use crate::support::{assert_exit, folder_with_tiny, names, overfall, read_json, stderr, stdout};

#[test]
fn a_run_writes_what_it_says_it_writes() {
    let folder = folder_with_tiny();
    let output = overfall(&folder, &["run", "tiny.ron", "--steps", "5", "--quiet"]);
    assert_exit(&output, 0);
    assert!(stderr(&output).is_empty(), "{}", stderr(&output));
    for word in ["tiny: done after 5 steps", "ms", "density error", "phase"] {
        assert!(stdout(&output).contains(word), "{}", stdout(&output));
    }
    let out = folder.path().join("out/tiny");
    assert_eq!(
        names(&out),
        [
            ".overfall_lock",
            "boundary.vtu",
            "frames",
            "history.csv",
            "overfall_manifest.txt",
            "scene",
            "summary.json",
            "tiny.pvd"
        ]
    );
    assert_eq!(names(&out.join("scene")), ["scene.ron"]);

    let summary = read_json(&out.join("summary.json"));
    for key in [
        "scene",
        "particles",
        "boundary_particles",
        "threads",
        "steps",
        "simulated_s",
        "wall_s",
        "ms_per_step",
        "ms_per_phase",
        "mean_iterations",
        "max_density_error",
        "mean_density_error",
        "peak_rss_bytes",
    ] {
        assert!(summary.get(key).is_some(), "{key} is missing in {summary}");
    }
    assert_eq!(summary["scene"], "tiny");
    assert_eq!(summary["status"], "done");
    assert_eq!(summary["steps"], 5);
    assert_eq!(summary["particles"], 125);
    assert_ne!(summary["boundary_particles"], 0);
    assert_ne!(summary["instruction_set"], "");
    let simulated = summary["simulated_s"].as_f64().expect("a number");
    assert!((simulated - 0.0025).abs() < 1e-6, "{simulated}");

    let history = fs::read_to_string(out.join("history.csv")).expect("a history");
    assert_eq!(history.lines().count(), 1 + 5, "{history}");
    // The start and the end, which is at 1/400 s.
    let frames = ["frame_00000.vtu", "frame_00001.vtu"];
    assert_eq!(names(&out.join("frames")), frames);
    let series = fs::read_to_string(out.join("tiny.pvd")).expect("a series");
    for frame in frames {
        assert!(series.contains(&format!("frames/{frame}")), "{series}");
    }
}

#[test]
fn frames_lie_at_multiples_of_their_interval() {
    let folder = folder_with_tiny();
    let output = overfall(
        &folder,
        &[
            "run",
            "tiny.ron",
            "--duration",
            "0.01",
            "--frames-per-second",
            "500",
            "--format",
            "vtu,ply",
            "--quiet",
        ],
    );
    assert_exit(&output, 0);
    let out = folder.path().join("out/tiny");
    let summary = read_json(&out.join("summary.json"));
    assert_eq!(
        (&summary["steps"], &summary["frames"]),
        (&20.into(), &6.into())
    );
    assert_eq!(names(&out.join("frames")).len(), 2 * 6);
    let series = fs::read_to_string(out.join("tiny.pvd")).expect("a series");
    for multiple in ["0\"", "0.002", "0.004", "0.006", "0.008"] {
        assert!(
            series.contains(&format!("timestep=\"{multiple}")),
            "{series}"
        );
    }
}

#[test]
fn the_options_are_in_the_scene_that_is_kept() {
    let folder = folder_with_tiny();
    let arguments = [
        "run",
        "tiny.ron",
        "--set",
        "spacing=0.05",
        "--steps=1",
        "--duration=3",
    ];
    assert_exit(&overfall(&folder, &arguments), 2);
    let arguments = [
        "run",
        "tiny.ron",
        "--set",
        "spacing=0.025",
        "--set",
        "name=coarse",
        "--steps=1",
        "--format=ply",
        "--quiet",
    ];
    assert_exit(&overfall(&folder, &arguments), 0);
    let out = folder.path().join("out/coarse");
    // No series, because ParaView reads no series of PLY files.
    assert!(!out.join("coarse.pvd").exists());
    assert_eq!(names(&out.join("frames")).len(), 2);

    // The stored scene can be run as it is and gives the same result.
    let again = [
        "run",
        "out/coarse/scene/scene.ron",
        "--steps=1",
        "--out=again",
        "--quiet",
    ];
    assert_exit(&overfall(&folder, &again), 0);
    let read = |path: &str| fs::read_to_string(folder.path().join(path)).expect("a scene");
    assert_eq!(
        read("out/coarse/scene/scene.ron"),
        read("again/scene/scene.ron")
    );
    let particles = |path: &str| read_json(&folder.path().join(path))["particles"].clone();
    assert_eq!(particles("again/summary.json"), 64);
}

#[test]
fn json_goes_to_standard_output_alone() {
    let folder = folder_with_tiny();
    let output = overfall(
        &folder,
        &["run", "tiny.ron", "--steps=2", "--json", "--threads=1"],
    );
    assert_exit(&output, 0);
    let summary: Value = serde_json::from_str(stdout(&output)).expect("JSON and nothing else");
    assert_eq!(summary["threads"], 1);
    assert_eq!(
        summary,
        read_json(&folder.path().join("out/tiny/summary.json"))
    );
}

#[test]
fn a_run_ends_where_it_should_and_frames_at_their_multiples_if_asked() {
    let folder = folder_with_tiny();
    for duration in ["0.0001", "0.00125", "0.003", "1e-9"] {
        let arguments = [
            "run",
            "tiny.ron",
            "--duration",
            duration,
            "--json",
            "--force",
        ];
        let output = overfall(&folder, &arguments);
        assert_exit(&output, 0);
        let summary: Value = serde_json::from_str(stdout(&output)).expect("JSON");
        let expected: f64 = duration.parse().expect("a number");
        assert_eq!(summary["simulated_s"], expected);
    }
    let arguments = [
        "run",
        "tiny.ron",
        "--duration=0.01",
        "--frames-per-second=300",
        "--exact-times",
        "--quiet",
        "--force",
    ];
    assert_exit(&overfall(&folder, &arguments), 0);
    let out = folder.path().join("out/tiny");
    let series = fs::read_to_string(out.join("tiny.pvd")).expect("a series");
    for time in [0.0, 1.0 / 300.0, 2.0 / 300.0, 0.01] {
        assert!(series.contains(&format!("timestep=\"{time}\"")), "{series}");
    }
    let kept = fs::read_to_string(out.join("scene/scene.ron")).expect("a scene");
    assert!(kept.contains("exact_times: true"), "{kept}");
}

#[test]
fn a_scene_without_steps_writes_its_start() {
    let folder = folder_with_tiny();
    let output = overfall(&folder, &["run", "tiny.ron", "--steps=0", "--json"]);
    assert_exit(&output, 0);
    let summary = read_json(&folder.path().join("out/tiny/summary.json"));
    assert_eq!(
        (&summary["steps"], &summary["frames"]),
        (&0.into(), &1.into())
    );
    assert_eq!(summary["particles"], 125);
}

#[test]
fn a_run_that_fails_says_why_and_keeps_the_last_good_state() {
    let folder = folder_with_tiny();
    // 50 mm a step, with a support radius of 40 mm.
    let output = overfall(
        &folder,
        &[
            "run",
            "tiny.ron",
            "--set",
            "bodies.0.velocity.x=100",
            "--quiet",
        ],
    );
    assert_exit(&output, 1);
    assert!(
        stderr(&output).starts_with("error: step 1 at"),
        "{}",
        stderr(&output)
    );
    assert!(
        stdout(&output).starts_with("tiny: failed"),
        "{}",
        stdout(&output)
    );
    let out = folder.path().join("out/tiny");
    let summary = read_json(&out.join("summary.json"));
    assert_eq!(summary["status"], "failed");
    let failure = summary["failure"].as_str().expect("a failure");
    assert!(failure.starts_with("step 1 at"), "{failure}");
    assert_eq!(summary["particles"], 125);
    assert_eq!(names(&out.join("frames")), ["frame_00000.vtu"]);
}
