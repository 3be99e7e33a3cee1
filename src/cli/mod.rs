//! The command line: `run`, `check`, `advise`, `study`, `validate`, `picture`, `surface`, `fields`, `schema`,
//! `completions`.
//!
//! Results go to standard output, progress and errors to standard error. The exit status tells success from failure
//! ([`Exit`](exit::Exit)).

mod advise;
mod beside;
mod caret;
mod check;
mod check_memory;
mod checkpoints;
mod claims;
mod command;
mod console;
mod cost;
mod exit;
mod fields;
mod folder;
mod frontier;
mod gauges;
mod interrupt;
mod kinds;
mod lock;
mod looks;
mod manifest;
mod movie;
mod numbers;
mod options;
mod picture;
mod plan_json;
mod progress;
mod recorder;
mod report;
mod run;
mod scene_copy;
mod schedule;
mod spent;
mod stability;
mod stages;
mod study;
mod surface;
#[cfg(feature = "surface")]
mod surfaces;
mod tips;
mod validate;
mod waiting;
mod walls;
mod writer;

pub(crate) use command::main;

/// The commit that the program was built from, if its builder knows: the variable `OVERFALL_COMMIT` at build time, or
/// git in a clone.
const COMMIT: Option<&str> = match option_env!("OVERFALL_COMMIT") {
    Some(commit) => Some(commit),
    None => Some(git_version::git_version!(
        args = [
            "--always",
            "--abbrev=40",
            "--dirty=-modified",
            "--exclude=*"
        ],
        fallback = ""
    )),
};
