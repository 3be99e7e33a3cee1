//! The program as a user meets it: a folder with files, and what a command says there.
#![allow(
    dead_code,
    reason = "every test file is a crate of its own and uses a part of this one"
)]

use std::{
    fs,
    process::{Command, Output},
};

use tempfile::TempDir;

/// A folder with files of these names and texts.
pub(crate) fn folder_with(files: &[(&str, &str)]) -> TempDir {
    let folder = tempfile::tempdir().expect("a temporary folder");
    for (name, text) in files {
        fs::write(folder.path().join(name), text).expect("a file");
    }
    folder
}

/// The program in a folder, to be given arguments.
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
