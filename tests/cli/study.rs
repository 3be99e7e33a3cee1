//! Studies: the shipped ones are valid, a small one gives its table and chart, an invalid one is refused with its
//! place.

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;

use overfall::study::{Chart, Plan, StudyKind};
use tempfile::TempDir;

use crate::support::{assert_exit, folder_with, overfall, read_json, stderr, stdout};

/// 150 particles in a tank.
const SCENE: &str = r#"(
    name: "tiny",
    spacing: 0.02,
    bodies: [(shape: Box(min: (0.0, 0.0, 0.0), max: (0.1, 0.12, 0.1)))],
    boundaries: [Tank(min: (0.0, 0.0, 0.0), max: (0.2, 0.2, 0.1))],
    time_step: Fixed(0.0005),
    pressure: Pcisph(not_converged: Accept),
)
"#;

/// Two variants with reference figures, according to which `fine` is faster and has more tested pairs.
const STUDY: &str = r#"(
    name: "cells",
    title: "Cells <d> & pairs",
    scene: "tiny.ron",
    start: (time: 0.005),
    set: ["executor=SingleThreaded"],
    variants: [
        (name: "coarse", reference: "h"),
        (name: "fine, h/2", set: ["index.cell_size=0.5"], reference: "0.5 h"),
    ],
    warm_up: Steps(1),
    block: Steps(4),
    blocks: 3,
    columns: [
        (name: "tested", measure: TestedPairs, reference: "tested"),
        (name: "pairs", measure: Pairs),
        (name: "ratio", measure: TestedRatio),
        (name: "step", measure: Milliseconds([find_neighbours, pressure])),
        (name: "error", measure: LargestDensityError),
    ],
    reference: "known.csv",
    baseline: "coarse",
    chart: Ratios(columns: ["tested", "step"]),
)
"#;

const KNOWN: &str = "# units: none\nrow,tested\nh,10\n0.5 h,20\n";

/// A folder with the study `s.ron` and the files that it names.
pub(super) fn folder(study: &str) -> TempDir {
    folder_with(&[("tiny.ron", SCENE), ("known.csv", KNOWN), ("s.ron", study)])
}

#[test]
fn every_shipped_study_is_right_in_itself() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("assets/studies");
    let mut names = Vec::new();
    for entry in fs::read_dir(root).expect("the folder of the studies") {
        let path = entry.expect("an entry").path();
        if StudyKind::of(&path).unwrap_or_else(|error| panic!("{error}")) != StudyKind::Table {
            continue;
        }
        let plan = Plan::load(&path).unwrap_or_else(|error| panic!("{error}"));
        // `out/<name>` must be found from the file that was run.
        let stem = path.file_stem().and_then(|stem| stem.to_str());
        assert_eq!(stem, Some(plan.study.name.as_str()));
        names.push(plan.study.name);
    }
    names.sort();
    let orders = "orders_lists orders_reorder orders_stages";
    let tables = "table_1 table_2 table_3 table_4 table_5 table_6";
    assert_eq!(
        names.join(" "),
        format!("frontier {orders} particles {tables}")
    );
}

/// Fields of a table's lines by variant and column.
pub(super) fn figures(csv: &str) -> BTreeMap<(String, String), BTreeMap<String, String>> {
    let mut lines = csv.lines();
    let names: Vec<&str> = lines.next().expect("a header").split(',').collect();
    lines
        .map(|line| {
            // The only name with a comma, without its quotes.
            let line = line.replace("\"fine, h/2\"", "fine");
            let fields: BTreeMap<String, String> = (names.iter().zip(line.split(',')))
                .map(|(name, field)| ((*name).to_owned(), field.to_owned()))
                .collect();
            assert_eq!(fields.len(), names.len(), "{line}");
            (
                (fields["variant"].clone(), fields["column"].clone()),
                fields,
            )
        })
        .collect()
}

/// The texts of a chart.
fn words(chart: &Path) -> Vec<String> {
    let svg = fs::read_to_string(chart).expect("a chart");
    let svg = roxmltree::Document::parse(&svg).expect("well-formed XML");
    (svg.descendants())
        .filter(|node| node.has_tag_name("text"))
        .filter_map(|node| node.text())
        .map(|text| text.trim().to_owned())
        .collect()
}

#[test]
fn a_study_gives_its_table_its_chart_and_a_summary() {
    let folder = folder(STUDY);
    let output = overfall(&folder, &["study", "s.ron", "--threads", "1"]);
    let out = stdout(&output);
    assert_exit(&output, 0);
    let written = folder.path().join("out/cells");

    let csv = fs::read_to_string(written.join("table.csv")).expect("a table");
    let figures = figures(&csv);
    assert_eq!(figures.len(), 2 * 5, "{csv}");
    let field = |variant: &str, column: &str, name: &str| {
        figures[&(variant.to_owned(), column.to_owned())][name].clone()
    };
    let number = |variant: &str, column: &str, name: &str| -> f64 {
        let text = field(variant, column, name);
        text.parse()
            .unwrap_or_else(|_| panic!("{variant}, {column}, {name}: {text:?}"))
    };
    for variant in ["coarse", "fine"] {
        assert_eq!(field(variant, "step", "unit"), "ms");
        assert_eq!(field(variant, "step", "blocks"), "3");
        assert_eq!(field(variant, "step", "steps"), "12");
        assert_eq!(field(variant, "step", "failure"), "");
        assert_eq!(field(variant, "step", "reference"), "");
        assert!(number(variant, "step", "value") > 0.0);
        assert!(number(variant, "step", "low") <= number(variant, "step", "value"));
        assert!(number(variant, "step", "value") <= number(variant, "step", "high"));
        assert!(number(variant, "error", "value") > 0.0);
        // Every particle is tested with itself and with all entries of its list.
        assert!(number(variant, "tested", "value") >= number(variant, "pairs", "value") + 150.0);
    }
    // The same motion: same initial state, same method.
    let pairs = |variant| number(variant, "pairs", "value");
    assert!((pairs("coarse") - pairs("fine")).abs() < 0.01 * pairs("coarse"));
    // The reference figures state the opposite of the truth.
    assert!(number("fine", "tested", "ratio") < 1.0);
    assert_eq!(number("fine", "tested", "reference_ratio"), 2.0);
    assert_eq!(field("fine", "tested", "rank"), "1");
    assert_eq!(field("fine", "tested", "reference_rank"), "2");
    assert_eq!(field("coarse", "tested", "order"), "differs");

    for part in [
        "Cells <d> & pairs",
        "tested",
        "coarse",
        "fine, h/2",
        "≠",
        "step [ms]",
    ] {
        assert!(out.contains(part), "{part} is not in\n{out}");
    }

    let words = words(&written.join("chart.svg"));
    for label in [
        "Cells <d> & pairs",
        "≠ coarse",
        "≠ fine, h/2",
        "tested, ratio to coarse [-]",
        "step, ratio to coarse [-]",
        "2.00 (20.00)",
    ] {
        assert!(
            words.iter().any(|word| word == label),
            "{label} is not among {words:?}"
        );
    }

    let summary = read_json(&written.join("summary.json"));
    assert_eq!(summary["status"], "done");
    assert_eq!(summary["threads"], 1);
    assert_eq!(summary["rows"][1]["steps"], 12);
}

#[test]
fn a_variant_that_fails_says_so_and_the_others_go_on() {
    let study = STUDY
        .replace("index.cell_size=0.5", "time_step=Fixed(0.5)")
        .replace(
            "chart: Ratios(columns: [\"tested\", \"step\"])",
            "chart: Points(x: \"step\", y: [\"ratio\", \"tested\"])",
        );
    let folder = folder(&study);
    let output = overfall(&folder, &["study", "s.ron", "--out", "here"]);
    let out = stdout(&output);
    assert_exit(&output, 0);
    assert!(out.contains("fine, h/2 failed: step"), "{out}");
    let csv = fs::read_to_string(folder.path().join("here/table.csv")).expect("a table");
    let figures = figures(&csv.replace("\"step", "step"));
    let fine = &figures[&("fine".to_owned(), "ratio".to_owned())];
    assert_eq!((fine["value"].as_str(), fine["blocks"].as_str()), ("", "0"));
    assert!(fine["failure"].contains("step"), "{csv}");
    let words = words(&folder.path().join("here/chart.svg"));
    for label in ["step [ms]", "ratio", "tested", "coarse"] {
        assert!(
            words.iter().any(|word| word == label),
            "{label} is not among {words:?}"
        );
    }
}

#[test]
fn a_refused_study_has_exit_status_2_and_writes_nothing() {
    let folder = folder(&STUDY.replace("cell_size=0.5", "cell_sise=0.5"));
    let output = overfall(&folder, &["study", "s.ron"]);
    assert_exit(&output, 2);
    let message = stderr(&output);
    assert!(message.starts_with("error: s.ron:9:35: "), "{message}");
    assert!(message.contains("did you mean `cell_size`?"), "{message}");
    assert!(!folder.path().join("out").exists());
    assert_exit(&overfall(&folder, &["study", "none.ron"]), 2);
}

#[test]
fn a_study_overwrites_nothing_that_no_study_wrote() {
    let folder = folder(STUDY);
    let table = folder.path().join("table.csv");
    fs::write(&table, "mine").expect("a file");
    for force in [&[][..], &["--force"]] {
        let output = overfall(&folder, &[&["study", "s.ron", "--out=."], force].concat());
        assert_exit(&output, 2);
        assert_eq!(fs::read_to_string(&table).expect("a file"), "mine");
    }
}

/// Each case: a part of the study, its replacement, the place of the error, parts of the message.
#[test]
fn every_spoilt_study_is_refused_with_its_place_and_a_remedy() {
    #[rustfmt::skip]
    let cases: &[(&str, &str, &str, &[&str])] = &[
        ("warm_up:", "warmup:", "s.ron:11:5", &["unknown field `warmup`", "did you mean `warm_up`?"]),
        ("find_neighbours, pressure", "find_neighbors", "s.ron:18:47", &["did you mean `find_neighbours`?"]),
        ("LargestDensityError", "MaxDensityError", "s.ron:19:34", &["unknown variant `MaxDensityError`",
            "LargestDensityError"]),
        ("    block: Steps(4),\n", "", "s.ron:1:1", &["the field `block`", "no default"]),
        ("tiny.ron", "tony.ron", "s.ron:4:12", &["there is no file", "tony.ron"]),
        ("\"cells\"", "\"a/b\"", "s.ron:2:11", &["without slashes"]),
        ("blocks: 3", "blocks: 0", "s.ron:13:13", &["at least 1"]),
        ("Steps(4)", "Steps(0)", "s.ron:12:12", &["it is 0 steps", "at least 1 step"]),
        ("Steps(4)", "Steps(18446744073709551615)", "s.ron:12:12", &["at most 1000000000 steps"]),
        ("Steps(4)", "Time(1e30)", "s.ron:12:12", &["at most 1000000000 steps or 1000000 s"]),
        ("Steps(4)", "Time(NaN)", "s.ron:12:12", &["it is NaN s", "above 0 s"]),
        ("Steps(4)", "Time(-1)", "s.ron:12:12", &["above 0"]),
        ("time: 0.005", "time: 0", "s.ron:5:19", &["above 0"]),
        ("executor=SingleThreaded", "executor=Fast", "s.ron:6:11", &["unknown variant `Fast`", "SingleThreaded"]),
        ("executor=SingleThreaded", "executor", "s.ron:6:11", &["expected PATH=VALUE"]),
        ("executor=SingleThreaded", "spacing=-1", "s.ron:6:11", &["above 0"]),
        ("cell_size=0.5", "cell_size=2", "s.ron:9:35", &["at most 1"]),
        ("index.cell_size=0.5", "spacing=0.01", "s.ron:9:34", &["changes the particles", "make it a case"]),
        ("\"fine, h/2\"", "\"coarse\"", "s.ron:9:16", &["given twice"]),
        ("reference: \"0.5 h\"", "reference: \"0.5h\"", "s.ron:9:70", &["reference row `0.5h`",
            "did you mean `0.5 h`?"]),
        ("reference: \"tested\"", "reference: \"test\"", "s.ron:15:59", &["did you mean `tested`?"]),
        ("known.csv", "unknown.csv", "s.ron:21:16", &["there is no file"]),
        ("baseline: \"coarse\"", "baseline: \"course\"", "s.ron:22:15", &["did you mean `coarse`?"]),
        ("[\"tested\", \"step\"]", "[\"tested\", \"stop\"]", "s.ron:23:39", &["did you mean `step`?"]),
        ("Ratios(columns: [\"tested\", \"step\"])", "Points(x: \"steps\", y: [\"ratio\"])", "s.ron:23:22",
            &["did you mean `step`?"]),
        ("[find_neighbours, pressure]", "[]", "s.ron:18:33", &["name one"]),
    ];
    for (part, instead, place, messages) in cases {
        assert!(STUDY.contains(part), "{part}");
        let folder = folder(&STUDY.replacen(part, instead, 1));
        let message = match Plan::load(&folder.path().join("s.ron")) {
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
fn a_wrong_line_of_the_figures_is_named() {
    let folder = folder(STUDY);
    fs::write(folder.path().join("known.csv"), "row,tested\nh,ten\n").expect("a file");
    let error = Plan::load(&folder.path().join("s.ron")).expect_err("ten is no number");
    let message = error.to_string();
    assert!(
        message.contains("known.csv:2:1: `ten` is not a number"),
        "{message}"
    );
}

#[test]
fn cases_multiply_the_rows_and_have_scenes_of_their_own() {
    let study = STUDY.replace(
        "    variants: [",
        "    cases: [(name: \"a\", set: [\"spacing=0.025\"]), (name: \"b\", start: (time: 0.001), block: \
         Time(0.002))],\n    variants: [",
    );
    let folder = folder(&study);
    let plan = Plan::load(&folder.path().join("s.ron")).expect("a study");
    let spacings: Vec<f32> = (plan.cases.iter())
        .flat_map(|case| case.variants.iter().map(|variant| variant.scene.spacing))
        .collect();
    assert_eq!(spacings, [0.025, 0.025, 0.02, 0.02]);
    let starts: Vec<f32> = (plan.cases.iter())
        .filter_map(|case| case.start.as_ref().map(|(_, time)| *time))
        .collect();
    assert_eq!(starts, [0.005, 0.001]);
    assert!(matches!(plan.study.chart, Some(Chart::Ratios { .. })));
}

#[test]
fn gauges_are_measures() {
    let scene = SCENE.replace(
        "time_step:",
        "gauges: [(name: \"e\", kind: Energy, reference: (file: \"curve.csv\")), (name: \"h\", kind: Height(at: \
         (0.05, 0, 0.05)), every: Steps(2))], time_step:",
    );
    let study = |columns: &str| {
        format!(
            "(name: \"gauged\", scene: \"tiny.ron\", variants: [(name: \"a\"), (name: \"b\", set: [\"spacing=0.025\"])],
              warm_up: Steps(1), block: Steps(4), blocks: 3, columns: [{columns}])"
        )
    };
    let curve = "t,kinetic\n0,0\n1,0\n";
    let right = study(
        "(name: \"last\", measure: Gauge(gauge: \"e\", statistic: Last)),
         (name: \"most\", measure: Gauge(gauge: \"e\", column: \"kinetic_energy_J\", statistic: Greatest)),
         (name: \"error\", measure: Gauge(gauge: \"e\", statistic: Error)),
         (name: \"height\", measure: Gauge(gauge: \"h\", column: \"height_m\"))",
    );
    let files =
        |study: &str| folder_with(&[("tiny.ron", &scene), ("curve.csv", curve), ("s.ron", study)]);
    let folder = files(&right);
    let output = overfall(&folder, &["study", "s.ron", "--threads", "1"]);
    assert_exit(&output, 0);
    let csv = fs::read_to_string(folder.path().join("out/gauged/table.csv")).expect("a table");
    let figures = figures(&csv);
    let field =
        |column: &str, name: &str| figures[&("a".to_owned(), column.to_owned())][name].clone();
    let number = |column: &str| -> f64 { field(column, "value").parse().expect("a number") };
    // The water falls freely: its last value is the largest, and the distance from the reference is smaller.
    assert!(
        number("last") > 0.0 && number("last") == number("most"),
        "{csv}"
    );
    assert!(
        number("error") > 0.0 && number("error") < number("most"),
        "{csv}"
    );
    assert!((0.08..0.14).contains(&number("height")), "{csv}");
    assert_eq!(
        (field("most", "unit"), field("height", "unit")),
        ("J".into(), "m".into())
    );

    for (columns, message) in [
        (
            "(name: \"x\", measure: Gauge(gauge: \"g\"))",
            "unknown gauge `g`",
        ),
        (
            "(name: \"x\", measure: Gauge(gauge: \"h\", column: \"heigth_m\"))",
            "did you mean `height_m`?",
        ),
        (
            "(name: \"x\", measure: Gauge(gauge: \"h\", statistic: Error))",
            "has no `reference`",
        ),
    ] {
        let wrong = study(columns);
        let folder = files(&wrong);
        let output = overfall(&folder, &["study", "s.ron"]);
        let error = stderr(&output);
        assert_exit(&output, 2);
        assert!(
            error.contains(message) && error.contains("s.ron:2:"),
            "{error}"
        );
    }
}
