//! Values written as in another language or format.

use overfall::{loading::Override, scene::Scene};

use super::errors::{SCENE, refusal};

/// A value written as in another language or format is answered with what a scene writes there.
#[test]
fn slips_of_other_languages_are_answered_in_the_files_words() {
    for (line, fragments) in [
        ("pictures: yes", &["did you mean `true`?"][..]),
        ("pictures: 0", &["did you mean `false`?"]),
        ("pictures: True", &["did you mean `true`?"]),
        ("formats: [\"vtu\"]", &["no quotes", "did you mean `Vtu`?"]),
    ] {
        let text = SCENE.replacen("duration:", &format!("output: (\n{line}),\n duration:"), 1);
        let error = refusal(&text);
        assert!(error.starts_with("s.ron:10:11: "), "{line}: {error}");
        assert!(
            fragments.iter().all(|part| error.contains(part)),
            "{line}: {error}"
        );
    }
    let mut wrong = Vec::new();
    for (line, fragments) in [
        (
            "gravity: (0, -9,81, 0)",
            &["decimal point", "did you mean `(0, -9.81, 0)`?"][..],
        ),
        (
            "gravity: (x: 0, y: -1, z: 0)",
            &["did you mean `(0, -1, 0)`?"],
        ),
        (
            "order: default",
            &["double quotes", "did you mean `\"default\"`?"],
        ),
        ("order: 'mine.ron'", &["did you mean `\"mine.ron\"`?"]),
        (
            "reorder_interval: 1.5",
            &["expected a whole number, found `1.5`"],
        ),
        ("reorder_interval: 1e2", &["did you mean `100`?"]),
        ("support: 4/2", &["no division"]),
        ("support: 2; kernel: CubicSpline", &["separated by commas"]),
        ("# a comment\nsupport: 2", &["a comment begins with `//`"]),
        ("\"support\": 2", &["the name of a field has no quotes"]),
        (
            "index: \"UniformGrid\"",
            &["did you mean `(structure: UniformGrid)`?"],
        ),
        (
            "gauges: [(name: e, kind: Energy)]",
            &["did you mean `\"e\"`?"],
        ),
        (
            "gauges: [(name: \"e\", kind: \"energy\")]",
            &["did you mean `Energy`?"],
        ),
        (
            "gauges: [(name: \"e\", kind: Energy, every: Steps(1.5))]",
            &["whole number"],
        ),
        (
            "gauges: [(name: \"e\", kind: Energy, every: Seconds(0,5))]",
            &["did you mean `Seconds(0.5)`?"],
        ),
        (
            "gauges: [(name: \"e\", kind: Energy, every: Seconds(5ms))]",
            &["did you mean `0.005`?"],
        ),
    ] {
        let error = refusal(&SCENE.replacen("duration:", &format!("{line}, duration:"), 1));
        if !fragments.iter().all(|part| error.contains(part)) {
            wrong.push(format!("{line}: {error}"));
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

/// A field, a value that is none of it, a part of the answer.
#[rustfmt::skip]
const WITHIN: [(&str, &str, &str); 21] = [
    ("time_step", "Cfl(0.4)", "did you mean `factor: 0.4`?"),
    ("time_step", "Cfl(factor: 0,4)", "did you mean `0.4`?"),
    ("time_step", "1ms", "Fixed(0.001)`?"),
    ("time_step", "\"0.001\"", "Fixed(0.001)`?"),
    ("time_step", "Cfl(dt: 1)", "unknown field `dt` in `Cfl`"),
    ("pressure", "Dfsph(max_density_error: 1%)", "did you mean `0.01`?"),
    ("pressure", "WCSPH", "did you mean `Sesph`?"),
    ("fluid", "(viscosity: Laminar(0.01))", "did you mean `kinematic_viscosity: 0.01`?"),
    ("fluid", "(viscosity: Artificial(0.1))", "the name of a field (alpha, sound_speed) before `0.1`"),
    ("fluid", "(density: 900)", "did you mean `rest_density`?"),
    ("dimension", "3.0", "did you mean"),
    ("kernel", "WendlandC2()", "no bracket belongs here; did you mean"),
    ("gravity", "none", "expected a vector of three numbers, `(x, y, z)`, found `none`"),
    ("gravity", "{x: 0, y: -1}", "expected a vector of three numbers"),
    ("domain", "((0, 0, 0), (1, 1, 1))", "did you mean `min: (0, 0, 0)`?"),
    ("domain", "Box(min: (-9, -9, -9), max: (9, 9, 9))", "min, max, without the name `Box`; did you mean"),
    ("output", "(fps: 25)", "did you mean `frames_per_second`?"),
    ("neighbours", "Lists", "did you mean `Stored`?"),
    ("outflow", "[Box(min: (0, 0, 0), max: (1, 1, 1))]", "min, max, without the name `Box`; did you mean"),
    ("gauges", "[(name: \"a\", kind: Energy, every: 0.1s)]", "did you mean `Seconds(0.1)`?"),
    ("body_forces", "[Table(\"a.csv\")]", "file: \"a.csv\""),
];

/// What is wrong within a value is said of an override as of a file.
#[test]
fn overrides_are_answered_as_files_are() {
    let mut wrong = Vec::new();
    for (field, value, part) in WITHIN {
        let lines: Vec<&str> = SCENE
            .lines()
            .filter(|line| !line.trim_start().starts_with(&format!("{field}:")))
            .collect();
        let text =
            lines
                .join("\n")
                .replacen("duration:", &format!("{field}: {value}, duration:"), 1);
        let change = Override::parse(&format!("{field}={value}")).expect("an override");
        let of_override = Scene::parse(SCENE, "s.ron", &[change]).expect_err("refused");
        for said in [refusal(&text), of_override.to_string()] {
            if !said.contains(part) {
                wrong.push(format!("{field}: {value}: {said}"));
            }
        }
    }
    for (line, part) in [
        ("include: base.ron", "paths in double quotes"),
        ("output: include(water.ron)", "a path in double quotes"),
        (
            "periodic: (x: 1)",
            "expected two numbers, `(from, to)`, found `1`",
        ),
        ("t_end: 3", "did you mean `duration`?"),
        ("dt: 3", "did you mean `time_step`?"),
        ("dx: 3", "did you mean `spacing`?"),
        (
            "support: 2.0, kernel: CubicSpline, h: 3",
            "did you mean `support`?",
        ),
    ] {
        let said = refusal(&SCENE.replacen("duration:", &format!("{line}, duration:"), 1));
        if !said.contains(part) {
            wrong.push(format!("{line}: {said}"));
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

/// A number with a unit that is not known here is not given another meaning, and one that is known keeps its own.
#[test]
fn only_units_that_are_known_are_converted() {
    let mut wrong = Vec::new();
    for (value, meant) in [
        ("2ms", Some("0.002")),
        ("5 %", Some("0.05")),
        ("3 m/s", Some("3")),
        ("2e-3s", Some("2e-3")),
        ("360deg", None),
        ("2.0h", None),
        ("36 km/h", None),
        ("2in", None),
        ("1e", None),
        ("0.001 Pa s", None),
    ] {
        let said = refusal(&SCENE.replacen("duration: 1", &format!("duration: {value}"), 1));
        let right = match meant {
            Some(meant) => said.contains(&format!("did you mean `{meant}`?")),
            None => said.contains("in SI units, without `") && !said.contains("did you mean"),
        };
        if !right {
            wrong.push(format!("{value}: {said}"));
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

/// Lines of a file, and a part of the answer.
#[rustfmt::skip]
const LINES: [(&str, &str); 16] = [
    ("gravity: (0, −9.81, 0)", "did you mean `-9.81`?"),
    ("order: “o.ron”", "did you mean `\"o.ron\"`?"),
    ("gravity: (y: -9.81)", "expected a vector of three numbers, `(x, y, z)`, found `(y: -9.81)`"),
    ("fluid: (viscosity: 0.001 Pa s)", "expected one of None, Laminar, Artificial, found `0.001 Pa s`"),
    ("support: 2,, kernel: CubicSpline", "a comma too many"),
    ("order: \"o.ron, support: 2", "no closing quote"),
    ("gauges: [(\"e\", kind: Energy)]", "before"),
    ("body: []", "did you mean `bodies`?"),
    ("obstacles: []", "did you mean `boundaries`?"),
    ("drain: []", "did you mean `outflow`?"),
    ("inlets: []", "did you mean `emitters`?"),
    ("probes: []", "did you mean `gauges`?"),
    ("cfl: 0.4", "did you mean `time_step`?"),
    ("gauges: [(name: \"e\", type: Energy)]", "did you mean `kind`?"),
    ("gauges: [(name: \"e\", kind: Energy, interval: 0.1)]", "did you mean `every`?"),
    ("emitters: [(shape: Slit(center: (0, 0, 0)), speed: 1)]", "did you mean `Rectangle`?"),
];

#[test]
fn slips_in_lines_are_answered_with_what_was_meant() {
    let without: Vec<&str> = SCENE
        .lines()
        .filter(|line| !line.trim_start().starts_with("fluid:"))
        .collect();
    let without = without.join("\n");
    let mut wrong = Vec::new();
    for (line, part) in LINES {
        let said = refusal(&without.replacen("duration:", &format!("{line}, duration:"), 1));
        if !said.contains(part) {
            wrong.push(format!("{line}: {said}"));
        }
    }
    let line =
        "bodies: [(shape: Box(min: (0, 0, 0), max: (1, 1, 1)), velocity_gradient: 1)], bodies";
    let said = refusal(&SCENE.replacen("bodies", line, 1));
    if !said.contains("three rows of three numbers") {
        wrong.push(said);
    }
    let said = refusal(&SCENE.replacen("Fixed(0.001)", "1/1000", 1));
    if !said.contains("there is no division") {
        wrong.push(said);
    }
    let mesh = "[Mesh(\"a.obj\", side: Inside)]";
    let said = refusal(&SCENE.replacen("[Tank(min: (0, 0, 0), max: (2, 2, 1))]", mesh, 1));
    if !said.contains("before this text") {
        wrong.push(said);
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

#[test]
fn slips_in_overrides_are_answered_with_what_was_meant() {
    let mut wrong = Vec::new();
    for (change, part) in [
        ("time_step.Fixed.x=1", "has no"),
        (
            "pressure.Pcisph.max_density_error=0.1",
            "did you mean `pressure.max_density_error=0.1`?",
        ),
        (
            "bodies.0.shape.box.max=(1, 1, 1)",
            "did you mean `bodies.0.shape.max=(1, 1, 1)`?",
        ),
        ("gauges.0.every=Steps(1)", "`gauges` is empty"),
        ("spacing=0.05,dimension=3", "`--set dimension=3`"),
        (
            "gravity=(0 -9.81 0)",
            "did you mean `gravity=(0, -9.81, 0)`?",
        ),
        ("gravity=(0, −9.81, 0)", "did you mean"),
    ] {
        let change = Override::parse(change).expect("an override");
        let said = Scene::parse(SCENE, "s.ron", &[change])
            .expect_err("refused")
            .to_string();
        if !said.contains(part) {
            wrong.push(said);
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

/// Brackets, names and blanks that are others', and the value that is meant. Lines stand before `duration`.
#[rustfmt::skip]
const NAMES: [(&str, &str); 17] = [
    ("boundaries: [(shape: Tank(min: (0, 0, 0), max: (2, 2, 1)), open: true)]",
        "did you mean `Tank(min: (0, 0, 0), max: (2, 2, 1), open: true)`?"),
    ("boundaries: [(Tank(min: (0, 0, 0), max: (2, 2, 1)))]", "did you mean `Tank(min: (0, 0, 0), max: (2, 2, 1))`?"),
    ("time_step: (Fixed: 0.001)", "did you mean `Fixed(0.001)`?"),
    ("pressure: [Dfsph]", "did you mean `Dfsph`?"),
    ("pressure: (method: Iisph)", "did you mean `Iisph`?"),
    ("pressure: Dfsph{max_density_error: 0.01}", "round here"),
    ("pressure: Dfsph[max_density_error: 0.01]", "round here"),
    ("index: (UniformGrid)", "did you mean `structure: UniformGrid`?"),
    ("index: (type: UniformGrid)", "did you mean `structure: UniformGrid`?"),
    ("viscosity: 0.01", "did you mean `fluid: (viscosity: 0.01)`?"),
    ("density: 1000", "did you mean `fluid: (rest_density: 1000)`?"),
    ("fluid: (viscosity: Laminar(mu: 0.001))", "divided by the density"),
    ("fluid: (rest_density: 1,000)", "write `1.000` or `1000`"),
    ("fluid.viscosity: 0.1", "`fluid: (viscosity: …)`"),
    ("order: \"C:\\Users\\me.ron\"", "write folders with `/`"),
    ("bodies: [(shape: \"box\")]", "no quotes belong here"),
    ("support:\u{a0}2", "U+00A0"),
];

/// The scene without the fields that a line gives.
fn with_line(line: &str) -> String {
    let name = line.split([':', '.']).next().unwrap_or_default();
    let lines = SCENE.lines();
    let others = lines.filter(|other| !other.trim_start().starts_with(&format!("{name}:")));
    let others: Vec<&str> = others.collect();
    let text = others.join("\n");
    let at = if name == "duration" {
        "output:"
    } else {
        "duration:"
    };
    text.replacen(at, &format!("{line}, {at}"), 1)
}

#[test]
fn brackets_and_names_of_others_are_answered_with_what_was_meant() {
    let mut wrong = Vec::new();
    for (line, part) in NAMES {
        let said = refusal(&with_line(line));
        if !said.contains(part) {
            wrong.push(format!("{line}: {said}"));
        }
    }
    let change = Override::parse("time_step.Cfl=0.4").expect("an override");
    Scene::parse(SCENE, "s.ron", &[change]).expect_err("refused");
    let text = SCENE.replacen("Fixed(0.001)", "Cfl()", 1);
    let change = Override::parse("time_step.Fixed=0.001").expect("an override");
    let said = Scene::parse(&text, "s.ron", &[change]).expect_err("refused");
    if !said
        .to_string()
        .contains("did you mean `time_step=Fixed(0.001)`?")
    {
        wrong.push(said.to_string());
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

/// Tables as other programs write them.
#[test]
fn slips_in_tables_are_answered_with_what_was_meant() {
    use overfall::scene::MotionTable;
    let folder = tempfile::tempdir().expect("a folder");
    let file = folder.path().join("motion.csv");
    for (text, part) in [
        ("t x\n0 0\n1 0.1\n", "separated by blanks; write commas"),
        (
            "t [s],x [m]\n0,0\n",
            "unknown column `t [s]`; did you mean `t`?",
        ),
        ("t_s,x\n0,0\n", "unknown column `t_s`; did you mean `t`?"),
        ("t,x\n0,0\n1\n", ":3: there is no figure in column `x`"),
        ("t,x\n0,\n", ":2: there is no figure in column `x`"),
    ] {
        std::fs::write(&file, text).expect("a table");
        let said = MotionTable::load(&file).expect_err("refused").to_string();
        assert!(said.contains(part), "{text}: {said}");
    }
}
