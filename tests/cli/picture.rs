//! Pictures of a run, and `overfall picture`.

use std::fs;
use std::path::Path;

use tempfile::TempDir;

use crate::support::{assert_exit, folder_with, overfall, stderr, stdout};

const TINY: &str = r#"(
    name: "tiny",
    dimension: 2,
    spacing: 0.01,
    bodies: [(shape: Box(min: (0.0, 0.0, 0.0), max: (0.1, 0.1, 0.0)))],
    boundaries: [Tank(min: (0.0, 0.0, 0.0), max: (0.2, 0.2, 0.0))],
    time_step: Fixed(0.0005),
    pressure: Pcisph(not_converged: Accept),
    duration: 0.01,
    output: (frames_per_second: 200, formats: [Ply]),
)
"#;

/// A folder in which the scene was run with additional options.
#[track_caller]
fn run(options: &[&str]) -> TempDir {
    let folder = folder_with(&[("tiny.ron", TINY)]);
    let output = overfall(
        &folder,
        &[&["run", "tiny.ron", "--quiet"], options].concat(),
    );
    assert_exit(&output, 0);
    folder
}

fn read(path: &Path) -> Vec<u8> {
    fs::read(path).unwrap_or_else(|error| panic!("{}: {error}", path.display()))
}

#[test]
fn pictures_can_be_drawn_again_from_the_frames() {
    let folder = run(&[]);
    let out = folder.path().join("out/tiny");
    let mut pictures: Vec<_> = (0..3)
        .map(|number| out.join(format!("pictures/frame_{number:05}.png")))
        .collect();
    pictures.push(out.join("contact_sheet.png"));
    let first: Vec<_> = pictures.iter().map(|path| read(path)).collect();
    for (path, bytes) in pictures.iter().zip(&first) {
        assert!(bytes.starts_with(b"\x89PNG"), "{}", path.display());
        fs::remove_file(path).expect("removed");
    }
    assert_ne!(first[0], first[2], "the water moves");

    let output = overfall(&folder, &["picture", "out/tiny"]);
    assert_exit(&output, 0);
    let text = stdout(&output);
    assert!(
        text.contains("3 pictures") && text.contains("contact_sheet.png"),
        "{text}"
    );
    let again: Vec<_> = pictures.iter().map(|path| read(path)).collect();
    assert!(first == again, "the pictures differ");
}

#[test]
fn a_run_without_pictures_draws_none_until_it_is_asked_to() {
    for off in [
        &["--no-pictures"][..],
        &["--pictures=false"],
        &["--set", "output.pictures=false"],
    ] {
        let folder = run(off);
        let out = folder.path().join("out/tiny");
        assert!(!out.join("pictures").exists());
        assert!(!out.join("contact_sheet.png").exists());
        assert!(overfall(&folder, &["picture", "out/tiny"]).status.success());
        assert!(out.join("contact_sheet.png").exists());
    }
    // The last one applies.
    let folder = run(&["--no-pictures", "--pictures"]);
    assert!(folder.path().join("out/tiny/contact_sheet.png").exists());
}

#[test]
fn what_is_no_run_is_refused() {
    let folder = run(&["--no-pictures"]);
    let refused = |path: &str, named: &str| {
        let output = overfall(&folder, &["picture", path]);
        assert_exit(&output, 2);
        assert!(stderr(&output).contains(named), "{}", stderr(&output));
    };
    refused("nowhere", "nowhere");
    fs::create_dir(folder.path().join("mine")).expect("a folder");
    refused("mine", "no run wrote this folder");
    let picture = folder.path().join("out/tiny/pictures/frame_00000.png");
    fs::create_dir_all(picture.parent().expect("a folder")).expect("a folder");
    fs::write(&picture, "mine").expect("a file");
    let output = overfall(&folder, &["picture", "out/tiny", "--threads=1"]);
    assert_exit(&output, 1);
    assert_eq!(read(&picture), b"mine");
    fs::remove_dir_all(folder.path().join("out/tiny/frames")).expect("removed");
    refused("out/tiny", "no frames");
}

#[test]
fn a_damaged_frame_is_named() {
    let folder = run(&["--no-pictures"]);
    let frame = folder.path().join("out/tiny/frames/frame_00001.ply");
    let bytes = read(&frame);
    fs::write(&frame, &bytes[..bytes.len() / 2]).expect("cut short");
    let output = overfall(&folder, &["picture", "out/tiny"]);
    assert_exit(&output, 1);
    let errors = stderr(&output);
    assert!(errors.contains("frame_00001.ply"), "{errors}");
}

#[test]
fn pictures_show_what_they_are_asked_to() {
    let folder = run(&[]);
    let picture = folder.path().join("out/tiny/pictures/frame_00002.png");
    let plain = read(&picture);
    let mut seen = vec![plain];
    for options in [
        &["--colour", "row", "--colours", "spectrum"][..],
        &[
            "--colour",
            "id",
            "--colours",
            "spectrum",
            "--range",
            "0..300",
        ],
        &["--colour", "pressure", "--colours", "fire"],
        &["--colour", "acceleration", "--range", "0..20"],
        &["--colour", "density", "--colours", "grey"],
        &["--size", "320x200"],
    ] {
        let output = overfall(&folder, &[&["picture", "out/tiny"], options].concat());
        assert_exit(&output, 0);
        let bytes = read(&picture);
        assert!(seen.iter().all(|other| *other != bytes), "{options:?}");
        seen.push(bytes);
    }
    // Width and height of the last, from its header.
    let last = &seen[seen.len() - 1];
    assert_eq!(
        (&last[16..20], &last[20..24]),
        (&320_u32.to_be_bytes()[..], &200_u32.to_be_bytes()[..])
    );
    for (options, said) in [
        (&["--size", "320"][..], "1280x720"),
        (&["--range", "3..1"], "below the second"),
        (&["--colour", "temperature"], "acceleration"),
    ] {
        let output = overfall(&folder, &[&["picture", "out/tiny"], options].concat());
        assert_exit(&output, 2);
        assert!(stderr(&output).contains(said), "{}", stderr(&output));
    }
}

/// Without ffmpeg the command is told; with one on the path it gets the pictures and the rate of the frames.
#[cfg(unix)]
#[test]
fn a_movie_is_made_by_ffmpeg_or_its_command_is_told() {
    use std::os::unix::fs::PermissionsExt;
    use std::process::Command;
    let folder = run(&[]);
    let tools = folder.path().join("tools");
    fs::create_dir(&tools).expect("a folder");
    let movie = |path: &Path| {
        Command::new(env!("CARGO_BIN_EXE_overfall"))
            .args(["picture", "out/tiny", "--movie"])
            .current_dir(folder.path())
            .env("PATH", path)
            .output()
            .expect("a run")
    };
    let output = movie(&tools);
    assert_exit(&output, 0);
    let said = stderr(&output);
    assert!(
        said.contains("no ffmpeg on the path") && said.contains("-framerate 200"),
        "{said}"
    );
    let script = "#!/bin/sh\nfor last; do :; done\necho \"$@\" > \"$last\"\n";
    let tool = tools.join("ffmpeg");
    fs::write(&tool, script).expect("a file");
    fs::set_permissions(&tool, fs::Permissions::from_mode(0o755)).expect("permissions");
    let output = movie(&tools);
    assert_exit(&output, 0);
    let asked = read(&folder.path().join("out/tiny/movie.mp4"));
    let asked = String::from_utf8_lossy(&asked);
    assert!(
        asked.contains("frame_%05d.png") && asked.contains("-framerate 200"),
        "{asked}"
    );
    fs::write(&tool, "#!/bin/sh\necho no such codec >&2\nexit 1\n").expect("a file");
    let output = movie(&tools);
    assert_exit(&output, 1);
    assert!(
        stderr(&output).contains("no such codec"),
        "{}",
        stderr(&output)
    );
}
