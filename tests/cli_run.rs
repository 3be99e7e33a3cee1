//! `overfall run` and `overfall check` as a user meets them: exit statuses, messages, files.
#![cfg(feature = "cli")]

#[path = "cli_support/mod.rs"]
mod support;

use std::fs;
use std::path::Path;
use std::process::Output;

use serde_json::Value;
use support::{folder_with, overfall};
use tempfile::TempDir;

/// 125 particles in a tank.
const TINY: &str = r#"(
    name: "tiny",
    spacing: 0.02,
    bodies: [(shape: Box(min: (0.0, 0.0, 0.0), max: (0.1, 0.1, 0.1)))],
    boundaries: [Tank(min: (0.0, 0.0, 0.0), max: (0.2, 0.2, 0.1))],
    time_step: Fixed(0.0005),
    pressure: Pcisph(not_converged: Accept),
    duration: 0.05,
    output: (frames_per_second: 400, pictures: false),
)
"#;

/// A folder with `tiny.ron` in it, to run in.
fn folder() -> TempDir {
    folder_with(&[("tiny.ron", TINY)])
}

fn stdout(output: &Output) -> &str {
    str::from_utf8(&output.stdout).expect("text on standard output")
}

fn stderr(output: &Output) -> &str {
    str::from_utf8(&output.stderr).expect("text on standard error")
}

#[track_caller]
fn assert_exit(output: &Output, status: i32) {
    assert_eq!(
        output.status.code(),
        Some(status),
        "{}\n{}",
        stdout(output),
        stderr(output)
    );
}

fn read_json(path: &Path) -> Value {
    serde_json::from_slice(&fs::read(path).expect("a JSON file")).expect("valid JSON")
}

/// The files in a folder by name, in order.
fn names(folder: &Path) -> Vec<String> {
    let mut names: Vec<_> = fs::read_dir(folder)
        .expect("a folder")
        .map(|entry| {
            let name = entry.expect("an entry").file_name();
            name.into_string().expect("a name in UTF-8")
        })
        .collect();
    names.sort();
    names
}

#[test]
fn help_names_every_command_and_option() {
    let folder = folder();
    let help = overfall(&folder, &["--help"]);
    assert_exit(&help, 0);
    for command in ["run", "check", "picture"] {
        assert!(stdout(&help).contains(command), "{}", stdout(&help));
    }
    let help = overfall(&folder, &["run", "--help"]);
    for option in [
        "--duration",
        "--steps",
        "--threads",
        "--set <PATH=VALUE>",
        "--out <DIR>",
        "--force",
        "--exact-times",
        "--frames-per-second",
        "--format",
        "--pictures",
        "--no-pictures",
        "--json",
        "--quiet",
    ] {
        assert!(stdout(&help).contains(option), "{option} is missing");
    }
}

#[test]
fn options_that_make_no_sense_are_refused() {
    let folder = folder();
    for arguments in [
        &["run"][..],
        &["walk", "tiny.ron"],
        &["run", "tiny.ron", "--duration", "-1"],
        &["run", "tiny.ron", "--duration", "inf"],
        &["run", "tiny.ron", "--duration", "1", "--steps", "3"],
        &["run", "tiny.ron", "--threads", "0"],
        &["run", "tiny.ron", "--frames-per-second", "NaN"],
        &["run", "tiny.ron", "--format", "xyz"],
        &["run", "tiny.ron", "--pictures=maybe"],
    ] {
        let output = overfall(&folder, arguments);
        assert_exit(&output, 2);
        assert!(!stderr(&output).is_empty());
    }
    assert!(!folder.path().join("out").exists());
}

#[test]
fn a_wrong_scene_is_refused_with_its_place() {
    let folder = folder();
    let wrong = TINY.replace("spacing:", "spacings:");
    fs::write(folder.path().join("wrong.ron"), wrong).expect("a scene file");
    for command in ["run", "check"] {
        let output = overfall(&folder, &[command, "wrong.ron"]);
        assert_exit(&output, 2);
        let text = stderr(&output);
        assert!(text.contains("wrong.ron:3:"), "{text}");
        assert!(text.contains("`spacing`"), "{text}");
        assert!(stdout(&output).is_empty());
    }
    assert!(!folder.path().join("out").exists());
}

#[test]
fn a_missing_scene_is_refused_with_its_name() {
    let folder = folder();
    let output = overfall(&folder, &["run", "nowhere.ron"]);
    assert_exit(&output, 2);
    assert!(stderr(&output).contains("nowhere.ron"));
}

#[test]
fn an_unknown_or_malformed_setting_is_refused() {
    let folder = folder();
    for (setting, named) in [
        ("spacin=0.01", "spacing"),
        ("spacing", "PATH=VALUE"),
        ("spacing=wide", "spacing=wide"),
        ("spacing=-1", "spacing"),
    ] {
        let output = overfall(&folder, &["run", "tiny.ron", "--set", setting]);
        assert_exit(&output, 2);
        assert!(stderr(&output).contains(named), "{}", stderr(&output));
    }
}

#[test]
fn check_prints_the_plan_and_writes_nothing() {
    let folder = folder();
    let output = overfall(&folder, &["check", "tiny.ron", "--threads", "3"]);
    assert_exit(&output, 0);
    let text = stdout(&output);
    for word in [
        "tiny",
        "particles",
        "boundary",
        "support radius",
        "particle mass",
        "neighbours",
        "time step",
        "Memory",
    ] {
        assert!(text.contains(word), "{word} is missing in\n{text}");
    }
    assert!(!folder.path().join("out").exists());
}

#[test]
fn a_run_writes_what_it_says_it_writes() {
    let folder = folder();
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
    // The start, and the end, which is at 1/400 s.
    let frames = ["frame_00000.vtu", "frame_00001.vtu"];
    assert_eq!(names(&out.join("frames")), frames);
    let series = fs::read_to_string(out.join("tiny.pvd")).expect("a series");
    for frame in frames {
        assert!(series.contains(&format!("frames/{frame}")), "{series}");
    }
}

#[test]
fn frames_lie_at_multiples_of_their_interval() {
    let folder = folder();
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
    let folder = folder();
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
    // No series: ParaView reads none of PLY files.
    assert!(!out.join("coarse.pvd").exists());
    assert_eq!(names(&out.join("frames")).len(), 2);

    // The scene that is kept can be run as it is, and says the same.
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
    let folder = folder();
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
fn a_second_run_moves_the_first_aside_or_replaces_it_and_touches_nothing_else() {
    let folder = folder();
    let run = |duration: &str, more: &[&str]| {
        let arguments = [
            "run",
            "tiny.ron",
            "--duration",
            duration,
            "--out=here",
            "--quiet",
        ];
        assert_exit(&overfall(&folder, &[&arguments, more].concat()), 0);
        names(&folder.path().join("here/frames")).len()
    };
    let long = run("0.02", &[]);
    fs::write(folder.path().join("here/frames/notes.txt"), "mine").expect("a file");
    fs::write(folder.path().join("here/frames/scan_00001.vtu"), "mine").expect("a file");
    let short = run("0.01", &[]);
    assert_eq!((long, short), (9, 5 + 2));
    let aside = folder.path().join("here/older_1");
    assert_eq!(names(&aside.join("frames")).len(), 9);
    assert_eq!(read_json(&aside.join("summary.json"))["simulated_s"], 0.02);
    assert_eq!(run("0.005", &["--force"]), 3 + 2);
    assert!(!folder.path().join("here/older_2").exists());
}

#[test]
fn files_of_the_users_are_never_overwritten() {
    // A name that a run writes, and whether it is one of the run's inputs as well.
    for name in [
        "history.csv",
        "summary.json",
        "contact_sheet.png",
        "tiny.pvd",
        "scene/scene.ron",
        "frames/frame_00003.vtu",
        "pictures/frame_00000.png",
        "history.csv.partial",
        "overfall_manifest.txt",
    ] {
        let folder = folder();
        let path = folder.path().join(name);
        fs::create_dir_all(path.parent().expect("a folder")).expect("a folder");
        fs::write(&path, "mine").expect("a file");
        for force in [&[][..], &["--force"]] {
            let arguments = ["run", "tiny.ron", "--steps=1", "--out=.", "--pictures"];
            let output = overfall(&folder, &[&arguments, force].concat());
            assert_exit(&output, 2);
            assert!(stderr(&output).contains("--out"), "{}", stderr(&output));
        }
        assert_eq!(fs::read_to_string(&path).expect("a file"), "mine", "{name}");
        assert!(!folder.path().join("tiny.ron.partial").exists());
    }
}

#[test]
fn inputs_that_lie_in_the_folder_stay_as_they_are() {
    let order = include_str!("../assets/orders/default.ron");
    let cube = |size: f32| {
        let mut text = String::new();
        for k in 0..8 {
            let at = |bit: i32| size * f32::from(u8::from(k & bit != 0));
            text.push_str(&format!("v {} {} {}\n", at(1), at(2), at(4)));
        }
        text + "f 1 3 4 2\nf 5 6 8 7\nf 1 2 6 5\nf 3 7 8 4\nf 1 5 7 3\nf 2 4 8 6\n"
    };
    let scene = TINY
        .replace(
            "boundaries: [",
            "boundaries: [Mesh(file: \"mesh_1.obj\", translation: (0.5, 0, 0)), Mesh(file: \"mesh_0.obj\", translation: (1, 0, 0)), ",
        )
        .replace("duration:", "order: \"order.ron\", duration:");
    let files = [
        ("scene.ron", scene.as_str()),
        ("mesh_0.obj", &cube(0.1)),
        ("mesh_1.obj", &cube(0.2)),
        ("order.ron", order),
    ];
    let folder = folder_with(&files);
    for more in [&[][..], &[], &["--force"]] {
        let arguments = ["run", "scene.ron", "--steps=1", "--out=.", "--quiet"];
        assert_exit(&overfall(&folder, &[&arguments, more].concat()), 0);
        for (name, text) in files {
            let kept = fs::read_to_string(folder.path().join(name)).expect("a file");
            assert_eq!(kept, text, "{name}");
        }
    }
    assert_eq!(
        names(&folder.path().join("scene")),
        ["mesh_1.obj", "mesh_2.obj", "order.ron", "scene.ron"]
    );
    // The copy of an older run is an input, too.
    let again = ["run", "scene/scene.ron", "--steps=1", "--out=.", "--force"];
    let output = overfall(&folder, &again);
    assert_exit(&output, 2);
    assert!(
        stderr(&output).contains("it is read"),
        "{}",
        stderr(&output)
    );
    assert!(folder.path().join("scene/scene.ron").exists());
}

#[test]
fn scenes_whose_names_map_to_one_folder_are_told_apart() {
    let folder = folder();
    for name in ["a b", "a_b", "a?b"] {
        let set = format!("name={name}");
        let arguments = ["run", "tiny.ron", "--steps=0", "--quiet", "--set", &set];
        assert_exit(&overfall(&folder, &arguments), 0);
    }
    let out = folder.path().join("out");
    let mut scenes: Vec<_> = names(&out)
        .iter()
        .map(|name| read_json(&out.join(name).join("summary.json"))["scene"].clone())
        .collect();
    scenes.sort_by_key(ToString::to_string);
    assert_eq!(scenes, ["a b", "a?b", "a_b"]);
}

#[test]
fn a_run_ends_where_it_should_and_frames_at_their_multiples_if_asked() {
    let folder = folder();
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
fn names_do_not_command_the_terminal() {
    let folder = folder();
    let evil = "x\u{1b}[2J\u{9b}31m\r\u{202e}{wide_msg}";
    let wrong = TINY.replace("tiny", evil);
    fs::write(folder.path().join(format!("{evil}.ron")), wrong).expect("a scene file");
    let set = format!("{evil}=1");
    let file = format!("{evil}.ron");
    for arguments in [
        &["run", &file, "--steps=1"][..],
        &["run", &file, "--steps=1", "--json"],
        &["check", &file],
        &["check", evil],
        &["check", "tiny.ron", "--set", &set],
        &["run", "tiny.ron", "--duration", evil],
        &["picture", evil],
        &["study", &file],
        &[evil],
    ] {
        let output = overfall(&folder, arguments);
        for text in [stdout(&output), stderr(&output)] {
            let commands = |c: char| c != '\n' && (c.is_control() || c == '\u{202e}');
            assert!(!text.contains(commands), "{arguments:?}: {text:?}");
        }
    }
    let output = overfall(&folder, &["run", &file, "--steps=1", "--json", "--force"]);
    let summary: Value = serde_json::from_str(stdout(&output)).expect("JSON");
    assert_eq!(summary["scene"], evil);
}

#[test]
fn slips_on_the_command_line_are_answered() {
    let folder = folder();
    for (duration, answer) in [("0,05", "0.05"), ("1s", "SI units"), ("long", "a number")] {
        let output = overfall(&folder, &["run", "tiny.ron", "--duration", duration]);
        assert_exit(&output, 2);
        assert!(stderr(&output).contains(answer), "{}", stderr(&output));
    }
    let arguments = [
        "run",
        "tiny.ron",
        "--set=pressure=Pcisph(max_iterations: 3, max_density_error: 1e-6)",
        "--quiet",
    ];
    let output = overfall(&folder, &arguments);
    assert_exit(&output, 1);
    for remedy in [
        "did not converge",
        "time_step",
        "max_iterations",
        "max_density_error",
        "not_converged=Accept",
    ] {
        assert!(stderr(&output).contains(remedy), "{}", stderr(&output));
    }
}

#[test]
fn a_folder_that_cannot_be_made_is_named() {
    let folder = folder();
    let output = overfall(
        &folder,
        &["run", "tiny.ron", "--steps=1", "--out=tiny.ron/deep"],
    );
    assert_exit(&output, 1);
    assert!(
        stderr(&output).contains("tiny.ron/deep"),
        "{}",
        stderr(&output)
    );
    assert!(stdout(&output).is_empty());
}

#[test]
fn a_scene_without_steps_writes_its_start() {
    let folder = folder();
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
    let folder = folder();
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

#[test]
fn gauges_write_a_file_each_and_a_chart_beside_what_is_known() {
    let scene = TINY.replace(
        "duration: 0.05",
        r#"gauges: [
            (name: "p", kind: Pressure(at: (0.05, 0.02, 0.05)), every: Seconds(0.01), window: 0.01),
            (name: "level", kind: Height(at: (0.05, 0, 0.05)),
             reference: (file: "known.csv", time: "t", value: "h", scale: (1, 0.01))),
        ],
        duration: 0.05"#,
    );
    let known = "# A source & its <notes>\nh,t\n10,0\n9,0.02\n9,0.04\n1,9\n";
    let folder = folder_with(&[("tiny.ron", &scene), ("known.csv", known)]);
    let check = overfall(&folder, &["check", "tiny.ron"]);
    assert_exit(&check, 0);
    for line in [
        "Gauges",
        "every 0.01 s, means over 0.01 s",
        "every step, beside known.csv",
        "pressure_Pa, neighbours, mean_pressure_Pa",
    ] {
        assert!(stdout(&check).contains(line), "{line}: {}", stdout(&check));
    }

    assert_exit(&overfall(&folder, &["run", "tiny.ron", "-q"]), 0);
    let out = folder.path().join("out/tiny");
    let gauges = out.join("gauges");
    assert_eq!(names(&gauges), ["level.csv", "level.svg", "p.csv"]);
    let rows = |name: &str| -> Vec<Vec<String>> {
        let text = fs::read_to_string(gauges.join(name)).expect("a file");
        let fields = |line: &str| line.split(',').map(str::to_owned).collect();
        text.lines().map(fields).collect()
    };
    let level = rows("level.csv");
    assert_eq!(level[0], ["step", "t_s", "height_m"]);
    assert_eq!(level.len(), 101, "a row a step");
    let last: f64 = level[100][2].parse().expect("a number");
    assert!((0.05..0.12).contains(&last), "{last}");
    let p = rows("p.csv");
    assert_eq!(
        p[0],
        [
            "step",
            "t_s",
            "pressure_Pa",
            "neighbours",
            "mean_pressure_Pa"
        ]
    );
    assert_eq!(p.len(), 6);
    let svg = fs::read_to_string(gauges.join("level.svg")).expect("a chart");
    let picture = roxmltree::Document::parse(&svg).expect("XML");
    let texts: Vec<_> = picture
        .descendants()
        .filter_map(|node| node.text())
        .collect();
    for text in [
        "tiny: level",
        "height_m",
        "measured",
        "reference",
        "A source & its <notes>",
    ] {
        assert!(
            texts.iter().any(|found| found.trim() == text),
            "{text}: {texts:?}"
        );
    }
    // One in the legend; what is known of later times is not drawn.
    let circles = picture
        .descendants()
        .filter(|node| node.has_tag_name("circle"));
    assert_eq!(circles.count(), 4);

    // The copy of the scene runs by itself.
    let copy = folder.path().join("out/tiny/scene/scene.ron");
    let copy = copy.to_str().expect("a path");
    assert_exit(
        &overfall(
            &folder,
            &["run", copy, "-q", "--out", "again", "--steps", "3"],
        ),
        0,
    );
    assert!(folder.path().join("again/gauges/level.svg").is_file());
    assert_exit(&overfall(&folder, &["run", "tiny.ron", "-q", "--force"]), 0);
    assert_eq!(names(&gauges), ["level.csv", "level.svg", "p.csv"]);
}

#[test]
fn a_gauge_file_of_somebody_elses_is_in_the_way() {
    let scene = TINY.replace(
        "duration: 0.05",
        "gauges: [(name: \"e\", kind: Energy)], duration: 0.05",
    );
    let folder = folder_with(&[("tiny.ron", &scene)]);
    fs::create_dir_all(folder.path().join("out/tiny/gauges")).expect("a folder");
    fs::write(folder.path().join("out/tiny/gauges/e.csv"), "mine").expect("a file");
    let run = overfall(&folder, &["run", "tiny.ron", "-q"]);
    assert_eq!(run.status.code(), Some(2), "{}", stderr(&run));
    assert!(stderr(&run).contains("e.csv"), "{}", stderr(&run));
}
