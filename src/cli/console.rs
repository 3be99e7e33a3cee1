//! Writing to the terminal without falling over when nobody reads.

use std::io::{self, ErrorKind, Write};

use super::Failure;

/// Writes a result to standard output. A reader that has gone away (`overfall check … | head`) is no failure.
pub(super) fn print(text: &str) -> Result<(), Failure> {
    let mut stdout = io::stdout().lock();
    match stdout
        .write_all(text.as_bytes())
        .and_then(|()| stdout.flush())
    {
        Err(error) if error.kind() != ErrorKind::BrokenPipe => Err(Failure::Failed(format!(
            "cannot write to standard output: {error}"
        ))),
        _ => Ok(()),
    }
}

/// Writes a line to standard error. If that fails there is nowhere left to say so.
pub(super) fn note(line: &str) {
    // One write a line: two threads' lines must not mix.
    let _ = io::stderr().write_all(format!("{line}\n").as_bytes());
}

/// Writes an error to standard error.
pub(super) fn error(text: &str) {
    note(&format!("error: {text}"));
}
