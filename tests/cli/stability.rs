//! Stability studies: every class is provoked, points are repeatable and never run twice, maps show what they hold.

use std::fs;
use std::ops::ControlFlow;
use std::path::Path;

use overfall::study::StudyKind;
use overfall::study::stability::{
    Class, Known, Reading, StabilityEvent, StabilityPlan, run_stability,
};
use tempfile::TempDir;

use crate::support::{assert_exit, folder_with, names, overfall, read_json, stderr, stdout};

/// A column of 5 × 6 particles in the plane.
const SCENE: &str = r#"(
    name: "tiny",
    dimension: 2,
    spacing: 0.02,
    kernel: CubicSpline,
    bodies: [(shape: Box(min: (0.0, 0.0, 0.0), max: (0.1, 0.12, 0.0)), jitter: (amplitude: 0.01))],
    boundaries: [Tank(min: (0.0, 0.0, 0.0), max: (0.1, 0.2, 0.0), open: true)],
    time_step: Fixed(0.0002),
    pressure: Sesph(equation: Gas(stiffness: 400)),
)
"#;

pub(crate) const STUDY: &str = r#"(
    kind: Stability,
    name: "where",
    title: "Where it runs",
    scene: "tiny.ron",
    variants: [
        (name: "soft", set: ["pressure.equation.stiffness=100"]),
        (name: "hard & <fast>"),
    ],
    x: (name: "rows", values: Listed([3, 6]), set: ["bodies.0.shape.max.y={0.02*v}"]),
    y: (name: "time step", unit: "s", values: Range(from: 2e-4, to: 2e-2, count: 3), set: ["time_step=Fixed({v})"]),
    seeds: (values: [1, 2], set: ["bodies.0.jitter.seed={v}"]),
    after: [2, 30],
)
"#;

pub(crate) fn folder(study: &str) -> TempDir {
    folder_with(&[("tiny.ron", SCENE), ("s.ron", study)])
}

/// The readings of a study's only point.
fn point(scene: &str, set: &str, rules: &str) -> Reading {
    let study = format!(
        "(kind: Stability, name: \"one\", scene: \"tiny.ron\", variants: [(name: \"it\")],
          x: (name: \"x\", values: Listed([1]), set: [{set}]),
          y: (name: \"y\", values: Listed([0.12]), set: [\"duration={{v}}\"]),
          after: [5, 100], rules: ({rules}))"
    );
    let folder = folder_with(&[("tiny.ron", scene), ("s.ron", &study)]);
    let plan = StabilityPlan::load(&folder.path().join("s.ron"), &[])
        .unwrap_or_else(|error| panic!("{error}"));
    let readings = run_stability(&plan, 1, &Known::default(), "", &mut |_| {
        ControlFlow::Continue(())
    });
    assert_eq!(readings.len(), 2, "{readings:?}");
    readings[1].clone()
}

#[test]
fn every_class_is_provoked() {
    let class = |set: &str, rules: &str| {
        let reading = point(SCENE, set, rules);
        (reading.class, reading)
    };
    let (stable, of) = class("\"name=a{v}\"", "");
    assert_eq!(stable, Class::Stable, "{of:?}");
    assert!(
        (of.steps, of.reason.as_str()) == (100, "") && of.cost.is_some_and(|cost| cost > 0.0),
        "{of:?}"
    );
    let (exploded, of) = class("\"time_step=Fixed({0.05*v})\"", "");
    assert_eq!(exploded, Class::Exploded, "{of:?}");
    assert!(of.steps < 100 && !of.reason.is_empty(), "{of:?}");
    // Sound at 1 m/s is slower than the fall through the depth.
    let (compressed, of) = class(
        "\"pressure.equation.stiffness={v}\", \"time_step=Fixed(0.004)\"",
        "",
    );
    assert_eq!(compressed, Class::Compressed, "{of:?}");
    let set = "\"pressure=Iisph(min_iterations: 1, max_iterations: {v}, max_density_error: 1e-7, not_converged: \
               Accept)\"";
    let (missed, of) = class(set, "");
    assert_eq!(missed, Class::NotConverged, "{of:?}");
    assert!(of.not_converged > 2 && of.iterations >= 1.0, "{of:?}");
    let (stopped, of) = class(&set.replace("Accept", "Stop"), "");
    assert!(
        stopped == Class::NotConverged && of.reason.contains("did not converge"),
        "{of:?}"
    );
    let (drifting, of) = class(
        "\"bodies.0.jitter.amplitude={0.1*v}\"",
        "drift: 1e-6, explosion: 1e3",
    );
    assert_eq!(drifting, Class::Drifting, "{of:?}");
    let (late, of) = class("\"name=a{v}\"", "seconds: 1e-9");
    assert_eq!(late, Class::OutOfTime, "{of:?}");
    // Fluid beyond the edge of its floor.
    let floor = SCENE.replace(
        "Tank(min: (0.0, 0.0, 0.0), max: (0.1, 0.2, 0.0), open: true)",
        "Box(min: (0.2, -0.1, 0.0), max: (0.3, 0.0, 0.0))",
    );
    let leaking = point(
        &floor,
        "\"pressure.equation.stiffness=4\", \"time_step=Fixed({0.004*v})\"",
        "explosion: 1e9, drift: 1e9",
    );
    assert_eq!(leaking.class, Class::Leaking, "{leaking:?}");
    assert!(leaking.leaked > 0.9, "{leaking:?}");
    // A box that fluid leaves.
    let domain = SCENE.replace(
        "time_step:",
        "domain: (min: (-1, -1, -1), max: (1, 0.3, 1)), time_step:",
    );
    let set = "\"bodies.0.velocity.y={3*v}\", \"pressure.equation.stiffness=4\", \"time_step=Fixed(0.004)\"";
    let left = point(&domain, set, "");
    assert_eq!(left.class, Class::Leaking, "{left:?}");
}

/// A scene that a value itself makes wrong is a point, not the end of the study.
#[test]
fn what_a_value_makes_wrong_is_a_refused_point() {
    let study = STUDY.replace(
        "Listed([3, 6]), set: [\"bodies.0.shape.max.y={0.02*v}\"]",
        "Listed([0.5, 2]), set: [\"support={v}\"]",
    );
    let folder = folder(&study);
    let plan = StabilityPlan::load(&folder.path().join("s.ron"), &[])
        .unwrap_or_else(|error| panic!("{error}"));
    let readings = run_stability(&plan, 2, &Known::default(), "", &mut |_| {
        ControlFlow::Continue(())
    });
    for reading in &readings {
        assert_eq!(
            reading.class == Class::Refused,
            reading.x == 0.5,
            "{reading:?}"
        );
        assert!(
            reading.x != 0.5 || reading.reason.contains("support"),
            "{reading:?}"
        );
    }
    assert_eq!(readings.len(), 2 * 2 * 3 * 2 * 2);
}

fn points(folder: &Path) -> Vec<Reading> {
    let text = fs::read_to_string(folder.join("points.csv")).expect("points");
    let rows: String = text
        .lines()
        .filter(|line| !line.starts_with('#'))
        .map(|line| format!("{line}\n"))
        .collect();
    csv::Reader::from_reader(rows.as_bytes())
        .deserialize()
        .map(|row| row.expect("a reading"))
        .collect()
}

/// The texts of a picture.
fn words(path: &Path) -> String {
    let svg = fs::read_to_string(path).expect("a map");
    let svg = roxmltree::Document::parse(&svg).expect("well-formed XML");
    let texts = svg.descendants().filter(|node| node.has_tag_name("text"));
    texts
        .filter_map(|node| node.text())
        .map(|text| format!("{}\n", text.trim()))
        .collect()
}

#[test]
#[expect(clippy::too_many_lines, reason = "a list of cases")]
fn a_study_gives_points_and_maps_and_goes_on_where_it_was() {
    let folder = folder(STUDY);
    let run = |more: &[&str]| {
        let output = overfall(
            &folder,
            &[&["study", "s.ron", "--threads", "2"], more].concat(),
        );
        assert_exit(&output, 0);
        (stdout(&output).to_owned(), stderr(&output).to_owned())
    };
    let (out, _) = run(&[]);
    let written = folder.path().join("out/where");
    let first = points(&written);
    assert_eq!(first.len(), 2 * 2 * 3 * 2 * 2);
    let class = |variant: &str, y: f64, after: u64| -> Vec<Class> {
        let of = |reading: &&Reading| {
            reading.variant == variant && reading.y == y && reading.after == after
        };
        first
            .iter()
            .filter(of)
            .map(|reading| reading.class)
            .collect()
    };
    assert_eq!(class("soft", 2e-4, 30), [Class::Stable; 4]);
    assert_eq!(class("hard & <fast>", 2e-2, 30), [Class::Exploded; 4]);
    assert!(
        first
            .windows(2)
            .all(|pair| pair[0].variant == pair[1].variant || pair[1].variant != "soft")
    );
    let command = "overfall run tiny.ron --set bodies.0.shape.max.y=0.06 --set 'time_step=Fixed(2e-4)' --set \
                   bodies.0.jitter.seed=1 --steps 30";
    assert!(
        first.iter().any(|reading| reading.command == command),
        "{}",
        first[0].command
    );
    for part in [
        "Where it runs",
        "soft, after 30 steps",
        "stable up to time step = ",
        "of the limit by sound",
        "exploded",
    ] {
        assert!(out.contains(part), "{part} is not in\n{out}");
    }
    let words = words(&written.join("map_2_hard____fast_.svg"));
    for part in [
        "Where it runs: hard & <fast>",
        "stable",
        "exploded",
        "limit by sound",
        "after 2 steps",
        "after 30 steps",
        "time step [s]",
        "rows",
        "0.001",
        "5",
        "overfall 0.1.0",
    ] {
        assert!(words.contains(part), "{part} is not in\n{words}");
    }
    assert!(!words.contains("leaking"), "{words}");
    let summary = read_json(&written.join("summary.json"));
    assert_eq!(
        (summary["status"].as_str(), summary["reused"].as_u64()),
        (Some("done"), Some(0))
    );
    assert_eq!(
        summary["maps"][0]["classes"]["stable"].as_u64(),
        Some(
            class("soft", 2e-4, 30).len() as u64
                + class("soft", 2e-3, 30)
                    .iter()
                    .filter(|of| **of == Class::Stable)
                    .count() as u64
        )
    );

    // Wall times would differ if a point were run again.
    let (_, notes) = run(&[]);
    assert!(
        notes.contains("24 points are those of an older run"),
        "{notes}"
    );
    assert_eq!(points(&written), first);
    assert!(names(&written).contains(&"older_1".to_owned()));
    // The points of the other variant are kept.
    run(&["--force", "--only", "soft"]);
    assert_eq!(points(&written).len(), first.len());
    // A study with a value more runs that alone.
    let wider = STUDY.replace("Listed([3, 6])", "Listed([3, 4, 6])");
    fs::write(folder.path().join("s.ron"), wider).expect("a file");
    let (_, notes) = run(&["--force"]);
    assert!(
        notes.contains("24 points are those of an older run"),
        "{notes}"
    );
    let more = points(&written);
    assert_eq!(more.len(), first.len() * 3 / 2);
    assert!(first.iter().all(|reading| more.contains(reading)));
    let (_, notes) = run(&["--force", "--fresh", "--only", "soft"]);
    assert!(!notes.contains("older run"), "{notes}");
    assert!(
        points(&written)
            .iter()
            .all(|reading| reading.variant == "soft")
    );
}

#[test]
fn an_edge_is_between_a_stable_and_an_unstable_value() {
    let study = STUDY.replace(
        "Range(from: 2e-4, to: 2e-2, count: 3)",
        "Edge(stable: 1e-4, unstable: 4e-2, halvings: 4)",
    );
    let plan = {
        let folder = folder(&study);
        let path = folder.path().join("s.ron");
        let plan = StabilityPlan::load(&path, &[]).unwrap_or_else(|error| panic!("{error}"));
        let mut seen = 0;
        let readings = run_stability(&plan, 2, &Known::default(), "", &mut |event| {
            seen += usize::from(matches!(event, StabilityEvent::Point { .. }));
            ControlFlow::Continue(())
        });
        // Two variants, two values of x, two seeds; both ends and four values between.
        assert_eq!((seen, readings.len()), (8 * 6, 2 * 8 * 6));
        for variant in ["soft", "hard & <fast>"] {
            let of = |class: bool| {
                let runs = readings
                    .iter()
                    .filter(|of| of.variant == variant && of.x == 6.0 && of.after == 30);
                let runs = runs.filter(|of| of.seed == Some(1));
                runs.filter(move |of| (of.class == Class::Stable) == class)
                    .map(|of| of.y)
                    .collect::<Vec<f64>>()
            };
            let stable = of(true).into_iter().fold(0.0, f64::max);
            let unstable = of(false).into_iter().fold(f64::INFINITY, f64::min);
            // The logarithm of 400, halved four times.
            assert!(
                stable < unstable && unstable / stable < 1.46,
                "{variant}: {stable} {unstable}"
            );
        }
        plan
    };
    assert_eq!(plan.maps.len(), 2);
}

#[test]
fn every_shipped_map_is_right_in_itself() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("assets/studies");
    let mut found = 0;
    for entry in fs::read_dir(root).expect("the folder of the studies") {
        let path = entry.expect("an entry").path();
        if StudyKind::of(&path).unwrap_or_else(|error| panic!("{error}")) != StudyKind::Stability {
            continue;
        }
        let plan = StabilityPlan::load(&path, &[]).unwrap_or_else(|error| panic!("{error}"));
        let stem = path.file_stem().and_then(|stem| stem.to_str());
        assert_eq!(stem, Some(plan.study.name.as_str()));
        assert!(
            plan.study
                .seeds
                .as_ref()
                .is_some_and(|seeds| seeds.values.len() == 5)
        );
        found += 1;
    }
    assert_eq!(found, 8);
}
