//! Parses the arguments, runs the command, returns the exit status.

use std::process::ExitCode;

use clap::{CommandFactory, Parser, Subcommand};

#[cfg(not(feature = "surface"))]
use super::surface::refuse as surfaces;
#[cfg(feature = "surface")]
use super::surfaces::write as surfaces;
use super::{
    advise, check, console,
    exit::{Exit, Failure},
    fields, interrupt, options, picture, run, study, surface, tips, validate,
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
    /// Check a scene and print what a run with the same options would do; writes nothing, and simulates only with
    /// --cost.
    Check(options::Check),
    /// Find the cheapest method, tolerance and time step that hold an error, by short trials of the scene; writes
    /// nothing.
    Advise(options::Advise),
    /// Measure variants of a scene side by side; write a table and a chart.
    Study(options::Study),
    /// Run cases with known answers; print the error of every method and write a page with charts.
    Validate(options::Validate),
    /// Draw the pictures of a run again, from the frames it wrote.
    Picture(options::Picture),
    /// Find the fluid's surface in the frames of a run; write meshes and draw them (feature `surface`).
    Surface(surface::Surface),
    /// List the fields of a scene file: type, default, unit and meaning.
    Fields(options::Fields),
    /// Print the JSON schema of scene files, from which editors complete and check.
    Schema,
    /// Print completions for a shell, e.g. `overfall completions bash >
    /// ~/.local/share/bash-completion/completions/overfall`.
    Completions(options::Completions),
}

/// Parses the arguments and runs the command.
pub(crate) fn main() -> ExitCode {
    let arguments = match Arguments::try_parse() {
        Ok(arguments) => arguments,
        Err(mut refused) => {
            let arguments = std::env::args_os();
            let arguments: Vec<String> = arguments
                .map(|argument| argument.to_string_lossy().into_owned())
                .collect();
            tips::add(&mut refused, &arguments);
            return tell(&refused);
        }
    };
    interrupt::outlive_size_limits();
    let ended = match arguments.command {
        Command::Run(options) => run::run(&options),
        Command::Check(options) => check::check(&options),
        Command::Advise(options) => advise::advise(&options),
        Command::Study(options) => study::study(&options),
        Command::Validate(options) => validate::validate(&options),
        Command::Picture(options) => picture::picture(&options),
        Command::Surface(options) => surfaces(&options),
        Command::Fields(options) => fields::fields(&options),
        Command::Schema => fields::schema(),
        Command::Completions(options) => completions(&options),
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

/// Prints completions for a shell.
fn completions(options: &options::Completions) -> Result<Exit, Failure> {
    let mut script = Vec::new();
    let mut command = Arguments::command();
    clap_complete::generate(options.shell, &mut command, "overfall", &mut script);
    console::print_raw(&script)?;
    Ok(Exit::Done)
}

/// Prints what is wrong with the arguments, or the requested help.
fn tell(refused: &clap::Error) -> ExitCode {
    let text = refused.render();
    if !refused.use_stderr() {
        // Our own text, with colours. A closed reader is not an error.
        let _ = refused.print();
        return Exit::Done.into();
    }
    // The message repeats arguments: with colours only if no argument contains terminal control characters.
    let plain = text.to_string();
    if console::shown(&plain) == plain {
        let _ = refused.print();
    } else {
        console::note(plain.trim_end());
    }
    Exit::Refused.into()
}
