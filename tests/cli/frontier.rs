//! Frontier studies: errors are those of the case, runs are repeated and never made twice, what fails is shown.

use std::fs;
use std::path::Path;

use overfall::frontier::{FrontierPlan, Run, Runs};
use overfall::study::StudyKind;
use tempfile::TempDir;

use crate::support::{assert_exit, folder_with, names, overfall, read_json, stderr, stdout};

/// A coarse column that collapses; a step of a second fails.
pub(crate) const STUDY: &str = r#"(
    kind: Frontier,
    name: "fast",
    title: "Fast <and> right",
    truth: Case(name: "dam_break_koshizuka_oka", figures: ["rms distance of the front [L]"]),
    set: ["duration=0.1"],
    variants: [
        (name: "DFSPH", set: ["pressure=Dfsph"]),
        (name: "broken", set: ["time_step=Fixed(1)"]),
    ],
    grid: [(name: "N", values: Listed([4, 6]), set: ["spacing={0.146*v^-1}"])],
    repeats: 2,
)
"#;

/// A column in a tank with a gauge.
const SCENE: &str = r#"(
    name: "tiny",
    dimension: 2,
    spacing: 0.02,
    bodies: [(shape: Box(min: (0.0, 0.0, 0.0), max: (0.1, 0.2, 0.0)))],
    boundaries: [Tank(min: (0.0, 0.0, 0.0), max: (0.3, 0.3, 0.0))],
    gauges: [(name: "front", kind: Front(direction: (1, 0, 0)), every: Seconds(0.005))],
    duration: 0.1,
)
"#;

const FINE: &str = r#"(
    kind: Frontier,
    name: "fine",
    truth: Fine(scene: "tiny.ron", set: ["spacing=0.01"], gauges: [(gauge: "front")]),
    variants: [(name: "a"), (name: "b", set: ["spacing=0.01"])],
    repeats: 1,
)
"#;

pub(crate) fn folder(study: &str) -> TempDir {
    folder_with(&[("tiny.ron", SCENE), ("s.ron", study)])
}

fn study(folder: &TempDir, more: &[&str]) -> (String, String) {
    let output = overfall(
        folder,
        &[&["study", "s.ron", "--threads", "2"], more].concat(),
    );
    assert_exit(&output, 0);
    (stdout(&output).to_owned(), stderr(&output).to_owned())
}

fn runs(folder: &Path) -> Vec<Run> {
    Runs::read(&folder.join("runs.csv")).expect("runs").0
}

#[test]
fn a_study_gives_runs_and_a_chart_and_goes_on_where_it_was() {
    let folder = folder(STUDY);
    let (out, _) = study(&folder, &[]);
    let written = folder.path().join("out/fast");
    let first = runs(&written);
    assert_eq!(first.len(), 2 * 2 * 2);
    for run in &first {
        match run.variant.as_str() {
            "DFSPH" => assert!(
                run.error.is_some_and(|error| error > 0.0 && error < 1.0) && run.reason.is_empty(),
                "{run:?}"
            ),
            _ => assert!(
                run.error.is_none() && run.reason.contains("smaller time step"),
                "{run:?}"
            ),
        }
    }
    // Repeats have the same error.
    assert_eq!(first[0].error, first[1].error);
    assert_eq!((first[0].repeat, first[1].repeat), (1, 2));
    let command = "overfall run assets/cases/dam_break_koshizuka_oka/scene.ron --set duration=0.1 --set pressure=Dfsph \
                   --set spacing=0.0365";
    assert_eq!(first[0].command, command);
    for part in ["Fast <and> right", "* DFSPH, N ", "broken, N 4", "exploded"] {
        assert!(out.contains(part), "{part} is not in\n{out}");
    }
    let svg = fs::read_to_string(written.join("chart.svg")).expect("a chart");
    let svg = roxmltree::Document::parse(&svg).expect("well-formed XML");
    let texts = svg.descendants().filter(|node| node.has_tag_name("text"));
    let words: String = texts
        .filter_map(|node| node.text())
        .map(|text| format!("{}\n", text.trim()))
        .collect();
    for part in [
        "Fast <and> right",
        "broken",
        "exploded",
        "nothing is as good",
        "against the known values of dam_break_koshizuka_oka",
        "overfall 0.1.0",
    ] {
        assert!(words.contains(part), "{part} is not in\n{words}");
    }
    assert_eq!(
        read_json(&written.join("summary.json"))["figures"][0]["failed"],
        2
    );
    // Wall times would differ if a run were made again.
    let (_, notes) = study(&folder, &["--only", "DFSPH"]);
    assert!(
        notes.contains("4 runs are those of an older one"),
        "{notes}"
    );
    let kept = runs(&written);
    assert!(first.iter().all(|run| kept.contains(run)) && kept.len() == first.len());
    assert!(names(&written).contains(&"older_1".to_owned()));
    fs::write(
        folder.path().join("s.ron"),
        STUDY.replace("[4, 6]", "[4, 5, 6]"),
    )
    .expect("a file");
    let (_, notes) = study(&folder, &["--force"]);
    assert!(
        notes.contains("8 runs are those of an older one"),
        "{notes}"
    );
    assert_eq!(runs(&written).len(), 12);
}

#[test]
fn a_run_as_fine_as_the_reference_has_no_error() {
    let folder = folder(FINE);
    let (out, _) = study(&folder, &[]);
    let written = folder.path().join("out/fine");
    let found = runs(&written);
    assert_eq!(found.len(), 2);
    assert!(
        found[0]
            .error
            .is_some_and(|error| error > 1e-4 && error < 0.5),
        "{:?}",
        found[0]
    );
    assert!(
        found[1].error.is_some_and(|error| error < 1e-6),
        "{:?}",
        found[1]
    );
    assert!(out.contains("error of front"), "{out}");
    let before = fs::read(written.join("reference.csv")).expect("curves");
    assert!(before.len() > 100);
    let (_, notes) = study(&folder, &["--force"]);
    assert!(
        notes.contains("2 runs are those of an older one"),
        "{notes}"
    );
    assert_eq!(
        fs::read(written.join("reference.csv")).expect("curves"),
        before
    );
}

/// Each case: a part of the study, its replacement, the place of the error, parts of the message.
#[test]
fn every_spoilt_study_is_refused_with_its_place_and_a_remedy() {
    #[rustfmt::skip]
    let cases: &[(&str, &str, &str, &str, &[&str])] = &[
        (STUDY, "repeats", "repeat", "s.ron:12:5", &["did you mean `repeats`?"]),
        (STUDY, "repeats: 2", "repeats: 0", "s.ron:12:14", &["from 1 to 100"]),
        (STUDY, "repeats: 2", "seconds: 0", "s.ron:12:14", &["above 0"]),
        (STUDY, "koshizuka_oka", "koshizuka", "s.ron:5:23", &["did you mean `dam_break_koshizuka_oka`?"]),
        (STUDY, "[\"rms distance of the front [L]\"]", "[]", "s.ron:5:59", &["name one"]),
        (STUDY, "\"broken\"", "\"DFSPH\"", "s.ron:9:16", &["given twice"]),
        (STUDY, "duration=0.1", "duration=-1", "s.ron:8:9", &["`duration=-1`", "above 0"]),
        (STUDY, "[4, 6]", "[6, 4]", "s.ron:11:32", &["ascend"]),
        (STUDY, "Listed([4, 6])", "Edge(stable: 1, unstable: 2, halvings: 3)", "s.ron:11:32", &["list the values"]),
        (STUDY, "{0.146*v^-1}", "0.01", "s.ron:11:53", &["write `{v}`"]),
        (FINE, "tiny.ron", "tony.ron", "s.ron:4:24", &["there is no file"]),
        (FINE, "(gauge: \"front\")", "(gauge: \"frond\")", "s.ron:4:68", &["did you mean `front`?"]),
        (FINE, "\"front\"", "\"front\", column: \"m\"", "s.ron:4:68", &["unknown column `m`"]),
        (FINE, "[(gauge: \"front\")]", "[]", "s.ron:4:67", &["name one"]),
    ];
    for (study, part, instead, place, messages) in cases {
        assert!(study.contains(part), "{part}");
        let folder = folder(&study.replacen(part, instead, 1));
        let message = match FrontierPlan::load(&folder.path().join("s.ron"), &[]) {
            Ok(_) => panic!("accepted: {instead}"),
            Err(error) => error.to_string(),
        };
        let message = message.replace(&format!("{}/", folder.path().display()), "");
        assert!(
            message.starts_with(&format!("{place}: ")),
            "{instead}: {message}"
        );
        for part in *messages {
            assert!(message.contains(part), "{instead}: {message}");
        }
    }
}

#[test]
fn a_figure_that_the_case_has_not_ends_the_study() {
    let folder = folder(&STUDY.replace("rms distance of the front", "rms distance of a front"));
    let output = overfall(&folder, &["study", "s.ron"]);
    assert_exit(&output, 2);
    let message = stderr(&output);
    assert!(
        message.contains("did you mean `rms distance of the front [L]`?"),
        "{message}"
    );
}

#[test]
fn every_shipped_frontier_is_right_in_itself() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("assets/studies");
    let mut found = Vec::new();
    for entry in fs::read_dir(root).expect("the folder of the studies") {
        let path = entry.expect("an entry").path();
        if StudyKind::of(&path).unwrap_or_else(|error| panic!("{error}")) != StudyKind::Frontier {
            continue;
        }
        let plan = FrontierPlan::load(&path, &[]).unwrap_or_else(|error| panic!("{error}"));
        let stem = path.file_stem().and_then(|stem| stem.to_str());
        assert_eq!(stem, Some(plan.study.name.as_str()));
        found.push(plan.study.name);
    }
    found.sort();
    let expected = [
        "corner_dam_break",
        "dam_break_2d",
        "drop",
        "hydrostatic",
        "taylor_green",
    ];
    assert_eq!(found, expected.map(|name| format!("frontier_{name}")));
}
