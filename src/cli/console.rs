//! Writes to the terminal. A closed reader is tolerated, and control characters in names are escaped.

use std::fmt::Write as _;
use std::io::{self, ErrorKind, Write};

use super::exit::Failure;

/// Writes a result to standard output. A closed reader (`overfall check … | head`) is not an error.
pub(super) fn print(text: &str) -> Result<(), Failure> {
    print_raw(shown(text).as_bytes())
}

/// As [`print`], for a text of our own that holds nothing of a user's: a script with tabs.
pub(super) fn print_raw(text: &[u8]) -> Result<(), Failure> {
    let mut stdout = io::stdout().lock();
    match stdout.write_all(text).and_then(|()| stdout.flush()) {
        Err(error) if error.kind() != ErrorKind::BrokenPipe => Err(Failure::Failed(format!(
            "cannot write to standard output: {error}"
        ))),
        _ => Ok(()),
    }
}

/// Writes a line to standard error. Failures are ignored, since there is nowhere left to report them.
pub(super) fn note(line: &str) {
    // A single write per line keeps the lines of two threads apart.
    let _ = io::stderr().write_all(format!("{}\n", shown(line)).as_bytes());
}

/// Writes an error to standard error.
pub(super) fn error(text: &str) {
    note(&format!("error: {text}"));
}

/// A text with its control characters escaped, except line breaks. Names of scenes and files come from anywhere, and a
/// terminal would execute control sequences in them.
pub(super) fn shown(text: &str) -> String {
    let mut shown = String::with_capacity(text.len());
    for c in text.chars() {
        if c != '\n' && commands(c) {
            // Writing to a String cannot fail.
            let _ = write!(shown, "{}", c.escape_unicode());
        } else {
            shown.push(c);
        }
    }
    shown
}

/// A name inside a line: its line breaks are escaped, too.
pub(super) fn name(name: &str) -> String {
    shown(name).replace('\n', "\\n")
}

/// A JSON text with such characters in its strings escaped, as in JSON.
pub(super) fn json(text: &str) -> String {
    let mut shown = String::with_capacity(text.len());
    for c in text.chars() {
        if c != '\n' && commands(c) {
            // Writing to a String cannot fail. All these characters have at most four hexadecimal digits.
            let _ = write!(shown, "\\u{:04x}", u32::from(c));
        } else {
            shown.push(c);
        }
    }
    shown
}

/// Whether a character controls the terminal: control characters, and those that change the direction of writing or end
/// a line.
fn commands(c: char) -> bool {
    c.is_control()
        || matches!(c, '\u{2028}' | '\u{2029}' | '\u{200e}' | '\u{200f}')
        || matches!(c, '\u{202a}'..='\u{202e}' | '\u{2066}'..='\u{2069}')
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_commands_a_terminal_is_written_out() {
        assert_eq!(
            shown("a\u{1b}[31m\r\u{9b}b\tß\n"),
            "a\\u{1b}[31m\\u{d}\\u{9b}b\\u{9}ß\n"
        );
        assert_eq!(shown("\u{202e}dlrow"), "\\u{202e}dlrow");
        assert_eq!(json("\"\u{7f}\u{202e}\"\n"), "\"\\u007f\\u202e\"\n");
        assert_eq!(name("a\nerror: b"), "a\\nerror: b");
    }
}
