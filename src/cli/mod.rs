//! The command line: `run`, `check`, `study`, `picture`.
//!
//! Results go to standard output, progress and errors to standard error. The exit status says how it ended
//! ([`Exit`]).

mod check;
mod claims;
mod console;
mod folder;
mod gauges;
mod interrupt;
mod manifest;
mod options;
mod picture;
mod progress;
mod recorder;
mod report;
mod run;
mod scene_copy;
mod schedule;
mod study;
mod waiting;

use std::process::ExitCode;

use clap::{Parser, Subcommand};
use overfall::output::OutputError;

/// How a command ended, as the exit status a script sees.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Exit {
    /// 0: done.
    Done,
    /// 1: the run failed; its summary is written all the same.
    Failed,
    /// 2: the scene or the options were refused (clap exits with 2 as well).
    Refused,
    /// 130: ended early by a signal, as shells say for SIGINT.
    Interrupted,
}

impl From<Exit> for ExitCode {
    fn from(exit: Exit) -> Self {
        Self::from(match exit {
            Exit::Done => 0,
            Exit::Failed => 1,
            Exit::Refused => 2,
            Exit::Interrupted => interrupt::EXIT_STATUS,
        })
    }
}

/// Why a command could not do what it was asked, in words for its user.
#[derive(Debug, Clone, PartialEq)]
enum Failure {
    /// The input is wrong: it has to change before another try.
    Refused(String),
    /// The input is fine; something else was in the way (a full disk, a missing permission, an unstable run).
    Failed(String),
}

impl Failure {
    fn into_text(self) -> String {
        match self {
            Self::Refused(text) | Self::Failed(text) => text,
        }
    }
}

fn cannot_write(error: OutputError) -> Failure {
    Failure::Failed(format!("cannot write {error}"))
}

/// Smoothed particle hydrodynamics as entities and systems, driven by RON scene files.
#[derive(Parser, Debug)]
#[command(name = "overfall", version, max_term_width = 110)]
struct Arguments {
    #[command(subcommand)]
    command: Command,
}

#[derive(Subcommand, Debug)]
enum Command {
    /// Simulate a scene; write frames, pictures, a history and a summary.
    Run(options::Run),
    /// Check a scene and print what a run of it would do; simulates nothing.
    Check(options::Check),
    /// Measure variants of a scene side by side; write a table and a chart.
    Study(options::Study),
    /// Draw the pictures of a run again, from the frames it wrote.
    Picture(options::Picture),
}

/// Reads the arguments and does what they say.
pub(crate) fn main() -> ExitCode {
    let arguments = match Arguments::try_parse() {
        Ok(arguments) => arguments,
        Err(refused) => return tell(&refused),
    };
    let ended = match arguments.command {
        Command::Run(options) => run::run(&options),
        Command::Check(options) => check::check(&options),
        Command::Study(options) => study::study(&options),
        Command::Picture(options) => picture::picture(&options),
    };
    match ended {
        Ok(exit) => exit.into(),
        Err(Failure::Refused(text)) => {
            console::error(&text);
            Exit::Refused.into()
        }
        Err(Failure::Failed(text)) => {
            console::error(&text);
            Exit::Failed.into()
        }
    }
}

/// Tells what is wrong with the arguments, or the help that was asked for.
fn tell(refused: &clap::Error) -> ExitCode {
    let text = refused.render();
    if !refused.use_stderr() {
        // Our own text, in colours; a reader that has gone away is no failure.
        let _ = refused.print();
        return Exit::Done.into();
    }
    // It repeats arguments: in colours if nothing in them commands the terminal.
    let plain = text.to_string();
    if console::shown(&plain) == plain {
        let _ = refused.print();
    } else {
        console::note(plain.trim_end());
    }
    Exit::Refused.into()
}
