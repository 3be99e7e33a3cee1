//! Stability studies that are wrong: refused with their place and a remedy.

use std::fs;

use overfall::study::stability::StabilityPlan;

use crate::stability::{STUDY, folder};
use crate::support::{assert_exit, overfall, stderr};

fn plan(study: &str) -> Result<StabilityPlan, String> {
    let folder = folder(study);
    let path = folder.path().join("s.ron");
    let plan = StabilityPlan::load(&path, &[]);
    plan.map_err(|error| {
        error
            .to_string()
            .replace(&format!("{}/", folder.path().display()), "")
    })
}

/// Each case: a part of the study, its replacement, the place of the error, parts of the message.
#[test]
fn every_spoilt_study_is_refused_with_its_place_and_a_remedy() {
    #[rustfmt::skip]
    let cases: &[(&str, &str, &str, &[&str])] = &[
        ("title:", "titel:", "s.ron:4:5", &["did you mean `title`?"]),
        ("\"where\"", "\"a/b\"", "s.ron:3:11", &["without slashes"]),
        ("tiny.ron", "tony.ron", "s.ron:5:12", &["there is no file"]),
        ("\"hard & <fast>\"", "\"soft\"", "s.ron:8:16", &["given twice"]),
        ("    x: (name: \"rows\", values: Listed([3, 6]), set: [\"bodies.0.shape.max.y={0.02*v}\"]),\n", "",
            "s.ron:7:9", &["there is no `x`"]),
        ("[3, 6]", "[6, 3]", "s.ron:10:31", &["ascend"]),
        ("[3, 6]", "[]", "s.ron:10:31", &["ascend"]),
        ("[3, 6]", "[0, 6]", "s.ron:10:31", &["logarithmic", "scale: Linear"]),
        ("Listed([3, 6])", "Edge(stable: 1, unstable: 2, halvings: 3)", "s.ron:10:31", &["along the `y`"]),
        ("count: 3", "count: 1", "s.ron:11:47", &["from 2"]),
        ("{0.02*v}", "{v*0.02}", "s.ron:10:53", &["`{v*0.02}` is no value", "{0.01*v}"]),
        ("{0.02*v}", "0.1", "s.ron:10:52", &["write `{v}`"]),
        ("max.y={", "max.w={", "s.ron:10:53", &["has no entry `w`"]),
        ("Fixed({v})", "Fixed(-{v})", "s.ron:11:92", &["both ends of the axes are refused"]),
        ("stiffness=100", "stifness=100", "s.ron:7:30", &["did you mean `stiffness`?"]),
        ("[1, 2]", "[1, 1]", "s.ron:12:21", &["different"]),
        ("seed={v}", "seed=7", "s.ron:12:34", &["the seed in it"]),
        ("[2, 30]", "[30, 2]", "s.ron:13:12", &["ascend"]),
        ("[2, 30]", "[0, 2]", "s.ron:13:12", &["ascend"]),
        ("after:", "rules: (drift: 2), after:", "s.ron:13:20", &["that must be more"]),
        ("after:", "rules: (leek: 2), after:", "s.ron:13:13", &["did you mean `leak`?"]),
    ];
    for (part, instead, place, messages) in cases {
        assert!(STUDY.contains(part), "{part}");
        let message = match plan(&STUDY.replacen(part, instead, 1)) {
            Ok(_) => panic!("accepted: {instead}"),
            Err(message) => message,
        };
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
fn kinds_and_flags_of_the_wrong_study_are_refused() {
    let folder = folder(&STUDY.replace("Stability", "Stabilty"));
    let output = overfall(&folder, &["study", "s.ron"]);
    assert_exit(&output, 2);
    assert!(
        stderr(&output).contains("s.ron:2:11: unknown kind `Stabilty`; did you mean `Stability`?"),
        "{}",
        stderr(&output)
    );
    fs::write(folder.path().join("s.ron"), STUDY).expect("a file");
    let output = overfall(&folder, &["study", "s.ron", "--only", "sift"]);
    assert_exit(&output, 2);
    assert!(
        stderr(&output).contains("did you mean `soft`?"),
        "{}",
        stderr(&output)
    );
    assert!(!folder.path().join("out").exists());
    let output = overfall(&folder, &["run", "s.ron"]);
    assert_exit(&output, 2);
    assert!(
        stderr(&output).contains("this is a study"),
        "{}",
        stderr(&output)
    );
    let table = "(name: \"t\", scene: \"tiny.ron\", variants: [(name: \"a\")], block: Steps(1), columns: [(name: \
                 \"i\", measure: Iterations)])";
    fs::write(folder.path().join("s.ron"), table).expect("a file");
    let output = overfall(&folder, &["study", "s.ron", "--fresh"]);
    assert_exit(&output, 2);
    assert!(
        stderr(&output).contains("of kind Stability or Frontier"),
        "{}",
        stderr(&output)
    );
}
