//! Values written as in another language or format.

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
