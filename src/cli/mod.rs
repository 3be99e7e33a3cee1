//! The command line: `run`, `check`, `study`, `validate`, `picture`.
//!
//! Results go to standard output, progress and errors to standard error. The exit status tells success from failure
//! ([`Exit`](exit::Exit)).

mod check;
mod checkpoints;
mod claims;
mod command;
mod console;
mod exit;
mod folder;
mod gauges;
mod interrupt;
mod kinds;
mod manifest;
mod options;
mod picture;
mod progress;
mod recorder;
mod report;
mod run;
mod scene_copy;
mod schedule;
mod stages;
mod study;
mod validate;
mod waiting;

pub(crate) use command::main;
