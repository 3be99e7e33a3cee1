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
    ("body_forces", "[Table(\"a.csv\")]", "did you mean `file: \"a.csv\"`?"),
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
