//! Runs the program in a folder with files, and reads its messages.

use std::{
    fs,
    path::Path,
    process::{Command, Output},
};

use serde_json::Value;
use tempfile::TempDir;

/// A folder with the given files.
pub(crate) fn folder_with(files: &[(&str, &str)]) -> TempDir {
    let folder = tempfile::tempdir().expect("a temporary folder");
    for (name, text) in files {
        fs::write(folder.path().join(name), text).expect("a file");
    }
    folder
}

/// The program in a folder, without arguments yet.
pub(crate) fn command(folder: &TempDir) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_overfall"));
    command.current_dir(folder.path());
    command
}

/// Runs the program to its end.
pub(crate) fn overfall(folder: &TempDir, arguments: &[&str]) -> Output {
    command(folder)
        .args(arguments)
        .output()
        .expect("overfall starts")
}

/// 125 particles in a tank.
pub(crate) const TINY: &str = r#"(
    name: "tiny",
    spacing: 0.02,
    bodies: [(shape: Box(min: (0.0, 0.0, 0.0), max: (0.1, 0.1, 0.1)))],
    boundaries: [Tank(min: (0.0, 0.0, 0.0), max: (0.2, 0.2, 0.1))],
    time_step: Fixed(0.0005),
    pressure: Pcisph(not_converged: Accept),
    duration: 0.05,
    output: (frames_per_second: 400, pictures: false),
)
"#;

pub(crate) fn stdout(output: &Output) -> &str {
    str::from_utf8(&output.stdout).expect("text on standard output")
}

pub(crate) fn stderr(output: &Output) -> &str {
    str::from_utf8(&output.stderr).expect("text on standard error")
}

#[track_caller]
pub(crate) fn assert_exit(output: &Output, status: i32) {
    assert_eq!(
        output.status.code(),
        Some(status),
        "{}\n{}",
        stdout(output),
        stderr(output)
    );
}

pub(crate) fn read_json(path: &Path) -> Value {
    serde_json::from_slice(&fs::read(path).expect("a JSON file")).expect("valid JSON")
}

/// The names of the files in a folder, sorted.
pub(crate) fn names(folder: &Path) -> Vec<String> {
    let mut names: Vec<_> = fs::read_dir(folder)
        .expect("a folder")
        .map(|entry| {
            let name = entry.expect("an entry").file_name();
            name.into_string().expect("a name in UTF-8")
        })
        .collect();
    names.sort();
    names
}

/// A folder with `tiny.ron` in it, to run in.
pub(crate) fn folder_with_tiny() -> TempDir {
    folder_with(&[("tiny.ron", TINY)])
}
