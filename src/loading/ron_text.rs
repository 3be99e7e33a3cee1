//! RON texts in the spelling of scene files: what they may leave out, and values that read such texts.

use ron::error::{Error, Position, Span, SpannedError};
use ron::extensions::Extensions;
use serde::de::DeserializeOwned;

use super::spans::{byte_at, line_column, scan};

/// What every scene file may leave out: `Some(…)` around a value, and the second bracket in `Pcisph((…))`.
pub(super) fn options() -> ron::Options {
    ron::Options::default()
        .with_default_extension(Extensions::IMPLICIT_SOME)
        .with_default_extension(Extensions::UNWRAP_VARIANT_NEWTYPES)
}

/// A written scene without the marks `r#` that ron puts before variants that are called as its own words are: `None`.
pub(super) fn plain_names(text: &str) -> String {
    let mut marks = Vec::new();
    if let Some(tree) = scan(text) {
        tree.leaves("", &mut |_, leaf| {
            if text[leaf.span.clone()].starts_with("r#") && !text[leaf.span.clone()].ends_with('#')
            {
                marks.push(leaf.span.start);
            }
        });
    }
    let mut plain = text.to_owned();
    for mark in marks.into_iter().rev() {
        plain.replace_range(mark..mark + 2, "");
    }
    plain
}

/// Reads one value; with or without the second bracket, as long as the file is consistent. A variant whose fields all
/// have defaults may stand alone: `Dfsph` is `Dfsph()`.
pub(super) fn deserialize<T: DeserializeOwned>(text: &str) -> Result<T, SpannedError> {
    let error = match complete(text, &options(), "()") {
        Err(error) => error,
        read => return read,
    };
    // An empty bracket in a bracket is an empty bracket in either spelling; places stay where they are.
    let error = if text.contains("(())") {
        match complete(&text.replace("(())", "()  "), &options(), "()") {
            Err(error) => error,
            read => return read,
        }
    } else {
        error
    };
    let two_brackets = ron::Options::default().with_default_extension(Extensions::IMPLICIT_SOME);
    if let Ok(value) = complete(&doubled(text), &two_brackets, "(())") {
        return Ok(value);
    }
    complete(text, &two_brackets, "(())").map_err(|other| {
        // Of a text with second brackets, the spelling that can be read farther was meant.
        let place = |error: &SpannedError| (error.span.end.line, error.span.end.col);
        let of_name = |part: &str| part.ends_with(|c: char| c.is_alphanumeric());
        let has_second = text
            .rsplit_once("((")
            .is_some_and(|(before, _)| before.split("((").any(of_name));
        match has_second && place(&other) > place(&error) {
            true => other,
            false => error,
        }
    })
}

/// A text with a second bracket in the empty ones of variants: `Dfsph(())` for `Dfsph()`.
fn doubled(text: &str) -> String {
    let mut parts = text.split("()");
    let mut doubled = parts.next().unwrap_or_default().to_owned();
    for part in parts {
        let is_of_name = doubled.ends_with(|c: char| c.is_alphanumeric() || c == '_');
        doubled.push_str(if is_of_name { "(())" } else { "()" });
        doubled.push_str(part);
    }
    doubled
}

/// Reads one value; names that stand alone where ron wants a bracket get one. Errors are of the text without it.
fn complete<T: DeserializeOwned>(
    text: &str,
    options: &ron::Options,
    bracket: &str,
) -> Result<T, SpannedError> {
    let mut error = match options.from_str(text) {
        Err(error) if error.code == Error::ExpectedStructLike => error,
        read => return read,
    };
    let Some(tree) = scan(text) else {
        return Err(error);
    };
    let mut completed: Vec<&str> = Vec::new();
    loop {
        let at = byte_at(text, error.span.end.line, error.span.end.col);
        let Some(name) = tree
            .name_before(at, text)
            .filter(|name| !completed.contains(name))
        else {
            return Err(error);
        };
        completed.push(name);
        // All of that name at once: a text has many bodies, and few kinds of names.
        let mut ends = Vec::new();
        tree.leaves("", &mut |_, leaf| {
            if completed.contains(&&text[leaf.span.clone()]) {
                ends.push(leaf.span.end);
            }
        });
        let mut whole = String::with_capacity(text.len() + bracket.len() * ends.len());
        let mut done = 0;
        for &end in &ends {
            whole.push_str(&text[done..end]);
            whole.push_str(bracket);
            done = end;
        }
        whole.push_str(&text[done..]);
        let original = |position: Position| {
            let byte = byte_at(&whole, position.line, position.col);
            let before = (0..ends.len())
                .take_while(|&k| ends[k] + k * bracket.len() < byte)
                .count();
            let byte = match before.checked_sub(1) {
                // Inside of a bracket that is not in the text.
                Some(k) if byte < ends[k] + before * bracket.len() => ends[k],
                _ => byte - before * bracket.len(),
            };
            let (line, col) = line_column(text, byte);
            Position { line, col }
        };
        let refused = match options.from_str(&whole) {
            Ok(value) => return Ok(value),
            Err(refused) => refused,
        };
        let span = Span {
            start: original(refused.span.start),
            end: original(refused.span.end),
        };
        error = SpannedError { span, ..refused };
        if error.code != Error::ExpectedStructLike {
            return Err(error);
        }
    }
}
