//! Arguments of `overfall run` and `overfall check`: mistakes are refused with their place and the remedy.

use std::fs;

use serde_json::Value;

use crate::support::{TINY, assert_exit, folder_with, folder_with_tiny, overfall, stderr, stdout};

#[test]
fn help_names_every_command_and_option() {
    let folder = folder_with_tiny();
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
    let folder = folder_with_tiny();
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

/// A number that is none is answered in words, a negative one, too.
#[test]
fn numbers_that_make_no_sense_are_answered_in_words() {
    let folder = folder_with_tiny();
    for (option, value, part) in [
        ("--steps", "1.5", "whole number"),
        ("--steps", "-1", "whole number, 0 or above"),
        ("--threads", "all", "whole number"),
        ("--threads", "-1", "whole number"),
        ("--threads", "0", "from 1 to 4096"),
        ("--duration", "-1", "above 0"),
        ("--frames-per-second", "-5", "0 or above"),
        ("--frames-per-second", "25fps", "without `fps`"),
    ] {
        let output = overfall(&folder, &["run", "tiny.ron", option, value]);
        assert_exit(&output, 2);
        let text = stderr(&output);
        assert!(text.contains(part), "{option} {value}: {text}");
    }
}

#[test]
fn a_wrong_scene_is_refused_with_its_place() {
    let folder = folder_with_tiny();
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
    let folder = folder_with_tiny();
    let output = overfall(&folder, &["run", "nowhere.ron"]);
    assert_exit(&output, 2);
    assert!(stderr(&output).contains("nowhere.ron"));
}

#[test]
fn an_unknown_or_malformed_setting_is_refused() {
    let folder = folder_with_tiny();
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
    let folder = folder_with_tiny();
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
fn names_do_not_command_the_terminal() {
    let folder = folder_with_tiny();
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
    let folder = folder_with_tiny();
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
fn a_file_that_belongs_to_another_command_is_known_as_what_it_is() {
    let study = r#"(name: "s", scene: "tiny.ron", variants: [(name: "a")], block: Steps(1),
        columns: [(name: "n", measure: Iterations)])"#;
    let order = r#"(stages: [Run("gather")])"#;
    let folder = folder_with(&[
        ("tiny.ron", TINY),
        ("study.ron", study),
        ("order.ron", order),
    ]);
    for (arguments, named) in [
        (["run", "study.ron"], "this is a study"),
        (["check", "study.ron"], "this is a study"),
        (["check", "order.ron"], "this is an order"),
        (["study", "tiny.ron"], "this is a scene"),
        (["study", "order.ron"], "this is an order"),
    ] {
        let output = overfall(&folder, &arguments);
        assert_exit(&output, 2);
        let errors = stderr(&output);
        assert!(errors.contains(named), "{errors}");
    }
    // A study whose scene is wrong is still a study.
    std::fs::write(folder.path().join("tiny.ron"), "(name)").expect("a file");
    let errors = overfall(&folder, &["study", "study.ron"]);
    assert!(!stderr(&errors).contains("this is"), "{}", stderr(&errors));
}

/// Fields of a scene and options of other programs are answered with what does the same here.
#[test]
fn arguments_of_others_are_answered_with_what_was_meant() {
    let folder = folder_with_tiny();
    for (arguments, part) in [
        (&["tiny.ron"][..], "`overfall run tiny.ron`"),
        (
            &["run", "tiny.ron", "--spacing", "0.1"],
            "`--set spacing=VALUE`",
        ),
        (
            &["run", "tiny.ron", "--time-step", "0.1"],
            "`--set time_step=Fixed(S)`",
        ),
        (&["run", "tiny.ron", "spacing=0.1"], "`--set spacing=0.1`"),
        (
            &["run", "tiny.ron", "--set", "spacing", "0.1"],
            "`--set spacing=0.1`",
        ),
        (
            &["run", "tiny.ron", "--set", "spacing:0.1"],
            "`spacing=0.1`",
        ),
        (
            &["run", "tiny.ron", "--fps", "10"],
            "`--frames-per-second N`",
        ),
        (
            &["run", "tiny.ron", "--dt", "0.01"],
            "`--set time_step=Fixed(S)`",
        ),
        (
            &["run", "tiny.ron", "--method", "dfsph"],
            "`--set pressure=METHOD`",
        ),
        (&["run", "tiny.ron", "-o", "x"], "`--out DIR`"),
        (&["run", "tiny.ron", "--dry-run"], "the command `check`"),
        (&["run", "--scene", "tiny.ron"], "the scene's file alone"),
        (&["run", "tiny.ron", "--threads", "-2"], "from 1 to 4096"),
        (&["run", "tiny.ron", "--quite"], "'--quiet'"),
    ] {
        let output = overfall(&folder, arguments);
        assert_exit(&output, 2);
        let said = stderr(&output);
        assert!(said.contains(part), "{arguments:?}: {said}");
    }
    let fields = overfall(&folder, &["fields", "pressure.recovery"]);
    assert_exit(&fields, 0);
    assert!(stdout(&fields).contains("recovery"));
}
