//! Output of a run with gauges, and their description in `check`.

use std::fs;

use tempfile::TempDir;

use crate::support::{TINY, assert_exit, folder_with, names, overfall, stderr, stdout};

/// The tiny scene with two gauges, one of them with a reference.
fn folder_with_gauges() -> TempDir {
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
    folder_with(&[("tiny.ron", &scene), ("known.csv", known)])
}

#[test]
fn check_lists_gauges() {
    let folder = folder_with_gauges();
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
}

#[test]
fn gauges_write_a_file_each_and_a_chart_beside_what_is_known() {
    let folder = folder_with_gauges();
    assert_exit(&overfall(&folder, &["run", "tiny.ron", "--quiet"]), 0);
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
    // One in the legend; later reference data are not drawn.
    let circles = picture
        .descendants()
        .filter(|node| node.has_tag_name("circle"));
    assert_eq!(circles.count(), 4);

    // The copy of the scene is complete: it can be run.
    let copy = folder.path().join("out/tiny/scene/scene.ron");
    let copy = copy.to_str().expect("a path");
    assert_exit(
        &overfall(
            &folder,
            &["run", copy, "--quiet", "--out", "again", "--steps", "3"],
        ),
        0,
    );
    assert!(folder.path().join("again/gauges/level.svg").is_file());
    assert_exit(
        &overfall(&folder, &["run", "tiny.ron", "--quiet", "--force"]),
        0,
    );
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
    let run = overfall(&folder, &["run", "tiny.ron", "--quiet"]);
    assert_eq!(run.status.code(), Some(2), "{}", stderr(&run));
    assert!(stderr(&run).contains("e.csv"), "{}", stderr(&run));
}
