//! Arguments in, exit status out.

use std::process::ExitCode;

use clap::{Parser, Subcommand};

use super::{
    check, console,
    exit::{Exit, Failure},
    options, picture, run, study, validate,
};

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
    /// Run cases whose answer is known; say how far off every method is, write a page with charts.
    Validate(options::Validate),
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
        Command::Validate(options) => validate::validate(&options),
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
