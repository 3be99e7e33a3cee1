//! Any content of a file or an override is read or refused: no reader panics or runs for ever.
//!
//! Texts of `tests/corpus` and of the shipped files are modified at random, identically in every run; `PROPTEST_CASES`
//! sets the number. Texts that once broke a reader belong into the corpus.

use std::fs;
use std::path::{Path, PathBuf};

use overfall::measure::Curve;
use overfall::step::Order;
use overfall::study::{Plan, Reference, StudyKind, stability::StabilityPlan};
use overfall::{
    loading::Override,
    scene::{AccelerationTable, MotionTable, Scene, SceneError, VelocityGrid},
};
use proptest::prelude::*;
use proptest::test_runner::{Config, RngSeed, TestCaseError, TestRunner};

/// Modified texts per reader; twice as many would still be cheap.
const CASES: u32 = 400;

/// Insertions: brackets, extreme numbers, names with a meaning.
const TOKENS: [&str; 40] = [
    "(",
    ")",
    "[",
    "]",
    "{",
    "}",
    ",",
    ":",
    "\"",
    "'",
    "\\",
    "/*",
    "*/",
    "//",
    "\n",
    "\r",
    "#",
    "r#",
    "r##\"",
    "\u{feff}",
    "ß",
    "\u{0}",
    "\u{1b}",
    "-",
    "1e39",
    "-1",
    "NaN",
    "inf",
    "0",
    "4294967296",
    "18446744073709551616",
    "1e-45",
    "None",
    "Some(",
    "()",
    "Pcisph",
    "Cfl",
    "Every(2, [",
    "..",
    "=",
];

/// The texts in a folder of the repository, by name.
fn texts(folder: &str) -> Vec<String> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join(folder);
    let mut files: Vec<PathBuf> = fs::read_dir(&root)
        .unwrap_or_else(|error| panic!("{}: {error}", root.display()))
        .map(|entry| entry.expect("an entry").path())
        .filter(|path| path.is_file())
        .collect();
    files.sort();
    let read = |path: &PathBuf| fs::read_to_string(path).expect("a text");
    files.iter().map(read).collect()
}

/// A modification of a text; positions are fractions of its length.
#[derive(Debug, Clone)]
enum Change {
    Remove(f64, usize),
    Double(f64, usize),
    Insert(f64, usize),
    Replace(f64, char),
    Cut(f64),
    Join(f64, usize, f64),
}

fn change() -> impl Strategy<Value = Change> {
    let at = 0.0..1.0;
    prop_oneof![
        (at.clone(), 1_usize..40).prop_map(|(at, length)| Change::Remove(at, length)),
        (at.clone(), 1_usize..40).prop_map(|(at, length)| Change::Double(at, length)),
        (at.clone(), 0..TOKENS.len()).prop_map(|(at, token)| Change::Insert(at, token)),
        (at.clone(), any::<char>()).prop_map(|(at, c)| Change::Replace(at, c)),
        at.clone().prop_map(Change::Cut),
        (at.clone(), 0_usize..100, at).prop_map(|(at, other, from)| Change::Join(at, other, from)),
    ]
}

fn changed(mut text: Vec<char>, changes: &[Change], corpus: &[String]) -> String {
    for change in changes {
        let place = |at: f64, length: usize| (at * length as f64) as usize;
        let length = text.len();
        match *change {
            Change::Remove(at, count) => {
                let at = place(at, length);
                text.drain(at..(at + count).min(length));
            }
            Change::Double(at, count) => {
                let at = place(at, length);
                let part = text[at..(at + count).min(length)].to_vec();
                text.splice(at..at, part);
            }
            Change::Insert(at, token) => {
                let at = place(at, length);
                text.splice(at..at, TOKENS[token].chars());
            }
            Change::Replace(at, c) => {
                if let Some(old) = text.get_mut(place(at, length)) {
                    *old = c;
                }
            }
            Change::Cut(at) => text.truncate(place(at, length)),
            Change::Join(at, other, from) => {
                let other: Vec<char> = corpus[other % corpus.len()].chars().collect();
                text.truncate(place(at, length));
                text.extend(&other[place(from, other.len())..]);
            }
        }
    }
    text.into_iter().collect()
}

/// Passes every text of a corpus to a reader, unmodified and then modified.
fn try_texts(corpus: &[String], read: impl Fn(&str)) {
    assert!(!corpus.is_empty());
    corpus.iter().for_each(|text| read(text));
    let mut runner = TestRunner::new(Config {
        rng_seed: RngSeed::Fixed(2011),
        failure_persistence: None,
        ..Config::with_cases(cases())
    });
    let input = (0..corpus.len(), prop::collection::vec(change(), 1..6));
    let tried = runner.run(&input, |(number, changes)| {
        let text = changed(corpus[number].chars().collect(), &changes, corpus);
        // The text itself is more useful than the modifications that led to it.
        std::panic::catch_unwind(std::panic::AssertUnwindSafe(|| read(&text)))
            .map_err(|_| TestCaseError::fail(format!("the reader panics for {text:?}")))
    });
    tried.unwrap_or_else(|error| panic!("{error}"));
}

fn cases() -> u32 {
    let asked = std::env::var("PROPTEST_CASES").ok();
    asked.and_then(|cases| cases.parse().ok()).unwrap_or(CASES)
}

/// An error gives place and reason in one line.
#[track_caller]
fn assert_says_something(message: &str) {
    assert!(message.contains(": "), "{message}");
    assert!(!message.contains("raw identifier"), "{message}");
}

fn parse(text: &str, overrides: &[Override]) -> Result<Scene, SceneError> {
    Scene::parse(text, "tests/corpus/scenes/s.ron", overrides)
}

#[test]
fn scenes_are_read_or_refused() {
    let corpus = [texts("tests/corpus/scenes"), texts("assets/scenes")].concat();
    try_texts(&corpus, |text| match parse(text, &[]) {
        Err(error) => assert_says_something(&error.to_string()),
        // A text that is read can be written and read back as the same.
        Ok(scene) => {
            let mut written = parse(&scene.to_ron().expect("a text"), &[]).expect("a scene");
            // Paths are relative to the file that contains them.
            let mut names: Vec<String> =
                scene.clone().files_mut().map(|name| name.clone()).collect();
            for (file, name) in written.files_mut().zip(names.drain(..)) {
                *file = name;
            }
            assert_eq!(written, scene);
        }
    });
}

#[test]
fn overrides_are_taken_or_refused() {
    let scene = texts("tests/corpus/scenes")
        .into_iter()
        .find(|text| parse(text, &[]).is_ok())
        .expect("a scene that is right");
    let corpus: Vec<String> = texts("tests/corpus/overrides")
        .iter()
        .flat_map(|text| text.lines().map(str::to_owned).collect::<Vec<_>>())
        .collect();
    try_texts(&corpus, |text| {
        if let Err(error) = Override::parse(text).and_then(|change| parse(&scene, &[change])) {
            assert_says_something(&error.to_string());
        }
    });
}

#[test]
fn orders_are_read_or_refused() {
    let scene = parse(&texts("assets/scenes")[0], &[]).expect("a shipped scene");
    let corpus = texts("tests/corpus/orders");
    try_texts(&corpus, |text| {
        if let Ok(order) = Order::parse(text) {
            let _ = order.check(&scene).map_err(|error| error.to_string());
        }
    });
}

#[test]
fn studies_are_read_or_refused() {
    let folder = tempfile::tempdir().expect("a folder");
    let scene = "(name: \"s\", dimension: 2, spacing: 0.1, bodies: [(shape: Box(min: (0, 0, 0), max: (1, 1, 0)))])";
    fs::write(folder.path().join("scene.ron"), scene).expect("a file");
    let study = folder.path().join("study.ron");
    let corpus = texts("tests/corpus/studies");
    try_texts(&corpus, |text| {
        fs::write(&study, text).expect("a file");
        if let Err(error) = Plan::load(&study) {
            assert_says_something(&error.to_string());
        }
        match StudyKind::of(&study) {
            Ok(_) => {}
            Err(error) => assert_says_something(&error.to_string()),
        }
        if let Err(error) = StabilityPlan::load(&study, &[]) {
            assert_says_something(&error.to_string());
        }
    });
    let whole = &corpus[0]
        .replace(", reference: \"row\"", "")
        .replace(", reference: \"x\"", "");
    fs::write(&study, whole).expect("a file");
    Plan::load(&study).unwrap_or_else(|error| panic!("{error}"));
}

#[test]
fn tables_of_figures_are_read_or_refused() {
    let corpus = [texts("tests/corpus/tables"), texts("assets/reference")].concat();
    try_texts(&corpus, |text| {
        if let Err((line, message)) = Reference::parse(text) {
            assert!(line >= 1 && line <= 1 + text.lines().count() && !message.is_empty());
        }
    });
}

#[test]
fn figures_of_gauges_are_read_or_refused() {
    let corpus = [texts("tests/corpus/tables"), texts("assets/reference")].concat();
    let file = Path::new("f.csv");
    try_texts(&corpus, |text| {
        for columns in [[None; 2], [Some("t"), None], [None, Some("")]] {
            match Curve::parse(text, file, columns, |[t, y]| (t, y)) {
                Err(error) => assert_says_something(&error.to_string()),
                Ok(curve) => {
                    let points = &curve.points;
                    assert!(points.is_sorted_by(|a, b| a.0 <= b.0) && !points.is_empty());
                    let times = points.iter().map(|point| point.0);
                    for time in times.chain([f64::NAN, f64::INFINITY, -1e308]) {
                        let _ = curve.at(time);
                    }
                }
            }
        }
    });
}

/// Tables that walls, forces and velocities follow: what is read is finite at any time and place.
#[test]
fn tables_of_motions_are_read_or_refused() {
    let folder = tempfile::tempdir().expect("a folder");
    let file = folder.path().join("table.csv");
    let corpus = [texts("tests/corpus/motions"), texts("tests/corpus/tables")].concat();
    let read = std::cell::Cell::new([0; 3]);
    let count = |kind: usize| {
        let mut all = read.get();
        all[kind] += 1;
        read.set(all);
    };
    let times = [0.0, 0.3, 0.9, -1.0, 1e30, 1e300];
    try_texts(&corpus, |text| {
        fs::write(&file, text).expect("a file");
        match MotionTable::load(&file) {
            Err(error) => assert_says_something(&error.to_string()),
            Ok(table) => {
                count(0);
                assert!(
                    times.iter().all(|time| !table.way(*time).is_nan()),
                    "{text:?}"
                );
            }
        }
        match AccelerationTable::load(&file) {
            Err(error) => assert_says_something(&error.to_string()),
            Ok(table) => {
                count(1);
                let means = times.map(|time| table.mean(time, 0.01));
                assert!(means.iter().all(|mean| !mean.is_nan()), "{text:?}");
            }
        }
        match VelocityGrid::load(&file) {
            Err(error) => assert_says_something(&error.to_string()),
            Ok(grid) => {
                count(2);
                let places = times.map(|x| grid.at(glam::DVec3::new(x, 0.5, -x)));
                assert!(places.iter().all(|velocity| !velocity.is_nan()), "{text:?}");
            }
        }
    });
    assert!(
        read.get().iter().all(|count| *count > 0),
        "{:?}",
        read.get()
    );
}

/// In a text of several source lines, a missing backslash leaves a run of spaces in the message.
#[test]
fn texts_have_no_runs_of_spaces() {
    fn files(folder: &Path, out: &mut Vec<PathBuf>) {
        for entry in fs::read_dir(folder).expect("a folder") {
            let path = entry.expect("an entry").path();
            if path.is_dir() {
                files(&path, out);
            } else if path.extension().is_some_and(|end| end == "rs") {
                out.push(path);
            }
        }
    }
    let mut sources = Vec::new();
    files(
        &Path::new(env!("CARGO_MANIFEST_DIR")).join("src"),
        &mut sources,
    );
    assert!(sources.len() > 100);
    for path in sources {
        let text = fs::read_to_string(&path).expect("a text");
        for (number, line) in text.lines().enumerate() {
            let line = line.trim();
            let is_comment = line.starts_with("//");
            // Within quotation marks: words, a run of three spaces, words.
            let mut parts = line.split("   ");
            let before = parts.next().unwrap_or_default();
            let after = parts.last().unwrap_or_default().trim_start();
            let is_word = |c: char| c.is_alphanumeric() || "`{},;:".contains(c);
            let is_run = before.contains('"')
                && before.ends_with(is_word)
                && after.starts_with(is_word)
                && !before.ends_with("\\n");
            assert!(
                is_comment || !is_run,
                "{}:{}: {line}",
                path.display(),
                number + 1
            );
        }
    }
}
