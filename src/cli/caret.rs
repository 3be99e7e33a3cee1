//! The line of a file that an error speaks of, with a caret under the place.

use std::path::Path;

use annotate_snippets::{AnnotationKind, Group, Level, Renderer, Snippet};
use overfall::input::read_text;
use overfall::scene::{Place, SceneError};
use overfall::study::StudyError;

/// Columns of a terminal that are taken to be there; longer lines are cut around the place.
const WIDTH: usize = 110;

/// An error of a scene with the line that it speaks of.
pub(super) fn of_scene(error: &SceneError) -> String {
    match error {
        SceneError::Syntax { place, .. } | SceneError::Invalid { place, .. } => {
            with_line(error.to_string(), place)
        }
        _ => error.to_string(),
    }
}

/// An error of a study with the line that it speaks of.
pub(super) fn of_study(error: &StudyError) -> String {
    match error {
        StudyError::Scene(error) => of_scene(error),
        StudyError::Refused { place, .. } => with_line(error.to_string(), place),
        _ => error.to_string(),
    }
}

/// A message, and below it the line of its place; the message alone if that is in no file.
fn with_line(message: String, place: &Place) -> String {
    let Place::File { file, line, column } = place else {
        return message;
    };
    let Ok(text) = read_text(Path::new(file)) else {
        return message;
    };
    match text.lines().nth(line.saturating_sub(1)) {
        Some(source) if !source.trim().is_empty() => {
            format!("{message}\n{}", marked(source, *line, *column))
        }
        _ => message,
    }
}

/// A line, its number, and carets under what begins at a column, from 1.
fn marked(source: &str, line: usize, column: usize) -> String {
    let start = source
        .char_indices()
        .nth(column.saturating_sub(1))
        .map_or(source.len(), |(at, _)| at);
    let rest = &source[start..];
    let ends = |c: char| c.is_whitespace() || matches!(c, ',' | ')' | ']' | ':' | '(' | '=');
    let length = rest.find(ends).filter(|length| *length > 0);
    let one = rest.chars().next().map_or(0, char::len_utf8);
    let end = start
        + length.unwrap_or(if rest.starts_with(ends) {
            one
        } else {
            rest.len()
        });
    let snippet = Snippet::source(source)
        .line_start(line)
        .annotation(AnnotationKind::Primary.span(start..end));
    let report = [Group::with_level(Level::ERROR).element(snippet)];
    Renderer::plain().term_width(WIDTH).render(&report)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn carets_are_under_the_place() {
        let shown = marked("    spaceing: 0.1,", 3, 5);
        assert!(shown.contains("3 |     spaceing: 0.1,"), "{shown}");
        assert!(
            shown.lines().any(|line| line.ends_with("|     ^^^^^^^^")),
            "{shown}"
        );
        for (source, column) in [
            ("ä: 1", 4),
            ("x", 9),
            ("\t(", 2),
            ("\u{1b}[31m", 1),
            ("", 1),
        ] {
            let shown = marked(source, 1, column);
            assert!(shown.contains('|'), "{source:?}: {shown}");
        }
    }
}
