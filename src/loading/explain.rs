//! What is wrong with a RON text, in a sentence that says what would be right, at its line and column.

use ron::error::{Error, SpannedError};
use serde::de::DeserializeOwned;

use super::ron_text::deserialize;
use super::slips::{slip, slip_around, slip_of_key, slip_of_name, slip_of_vector, slip_within};
use super::spans::{Kind, Node, byte_at, is_name, line_column, scan};
use crate::input::without_mark;
use crate::scene::{Place, SceneError, unknown_name};

/// Reads what a RON file says; what is wrong with it is told with its line and column.
pub(crate) fn read<T: DeserializeOwned>(text: &str, file_name: &str) -> Result<T, SceneError> {
    let text = without_mark(text);
    deserialize(text).map_err(|error| explain_in_file::<T>(&error, text, file_name))
}

/// Where the value at `path` stands in a RON text, or the innermost value around it that the text does write.
pub(crate) fn place_of(path: &str, text: &str, file_name: &str) -> Place {
    let steps: Vec<&str> = path.split('.').collect();
    let byte = scan(text).map_or(0, |tree| tree.follow(&steps).0.span.start);
    let (line, column) = line_column(text, byte);
    Place::File {
        file: file_name.to_owned(),
        line,
        column,
    }
}

/// What a RON text has at `path`; `None` if it writes nothing there.
#[cfg(feature = "cli")]
pub(crate) fn written_at<'a>(path: &str, text: &'a str) -> Option<&'a str> {
    let text = without_mark(text);
    let steps: Vec<&str> = path.split('.').collect();
    let tree = scan(text)?;
    let (node, _, lost) = tree.follow(&steps);
    lost.is_none().then(|| &text[node.span.clone()])
}

/// An error of ron's as one of ours, at the place the user must look at.
pub(super) fn explain_in_file<T: DeserializeOwned>(
    error: &SpannedError,
    text: &str,
    file_name: &str,
) -> SceneError {
    let end = byte_at(text, error.span.end.line, error.span.end.col);
    let start = byte_at(text, error.span.start.line, error.span.start.col);
    if let Some((byte, sign)) = foreign_blank(text) {
        let (line, column) = line_column(text, byte);
        let message = format!(
            "there is a blank of another kind (U+{:04X}), as web pages have them; replace it by one of the keyboard",
            u32::from(sign)
        );
        let file = file_name.to_owned();
        let place = Place::File { file, line, column };
        return SceneError::Syntax { place, message };
    }
    let tree = scan(text);
    let mut message = explain(&error.code);
    let byte = match (&error.code, &tree) {
        (Error::NoSuchEnumVariant { .. }, Some(tree)) => {
            // What is no variant may be the value of one: `density` for `Run("density")`.
            let node = tree.name_that_ends(end, text);
            let slip = node.and_then(|node| slip_of_name::<T>(text, node.span.clone()));
            if let (Some(slip), Some(node)) = (slip, node) {
                message = slip.in_file(&text[node.span.clone()]);
            }
            start
        }
        (
            Error::NoSuchStructField {
                expected, found, ..
            },
            Some(tree),
        ) if found != "include" => {
            if !message.contains("did you mean")
                && let Some(slip) = slip_of_key::<T>(text, tree, start, expected)
            {
                message = slip;
            }
            start
        }
        (Error::NoSuchStructField { .. } | Error::NoSuchEnumVariant { .. }, _) => start,
        (Error::DuplicateStructField { field, .. }, Some(tree)) => {
            tree.last_key(field, end).map_or(end, |key| key.start)
        }
        (Error::MissingStructField { .. } | Error::ExpectedDifferentLength { .. }, Some(tree)) => {
            // A name that stands alone lacks the fields that have no default.
            let alone = tree.name_that_ends(end, text).or_else(|| tree.bracket(end));
            if matches!(error.code, Error::ExpectedDifferentLength { .. })
                && let Some(node) = alone
                && let Some(slip) = slip_within::<T>(text, node.span.clone())
            {
                message = slip.in_file(&text[node.span.clone()]);
            }
            alone.map_or(end, |node| node.span.start)
        }
        (code, Some(tree)) => {
            let (found, byte) = within::<T>(tree, text, end, code, &message);
            message = found.unwrap_or(message);
            byte
        }
        (_, None) => match slip_around::<T>(text, end) {
            Some((slip, start)) => {
                message = slip;
                start
            }
            None => {
                if let Some(sign) = foreign_sign(&error.code, &text[..end], &text[end..]) {
                    message = sign.to_owned();
                }
                end
            }
        },
    };
    let (line, column) = line_column(text, byte);
    SceneError::Syntax {
        place: Place::File {
            file: file_name.to_owned(),
            line,
            column,
        },
        message,
    }
}

/// What is wrong with the value around a byte where ron stopped with a message, if more is known, and where it stands.
fn within<T: DeserializeOwned>(
    tree: &Node,
    text: &str,
    end: usize,
    code: &Error,
    message: &str,
) -> (Option<String>, usize) {
    let Some(node) = tree.innermost(end) else {
        return (None, end);
    };
    let value = &text[node.span.clone()];
    let around = tree.bracket(end).unwrap_or(node);
    if let Some((found, start)) = slip_of_vector::<T>(text, around) {
        return (Some(found), start);
    }
    let found = if let Some(slip) = slip::<T>(text, node.span.clone()) {
        Some(slip.in_file(value))
    } else if let Some(slip) = slip_within::<T>(text, around.span.clone()) {
        Some(slip.in_file(&text[around.span.clone()]))
    } else if let Some(sign) = foreign_sign(code, &text[..end], &text[end..]) {
        Some(sign.to_owned())
    } else if node.kind == Kind::Leaf && node.span.end == end && is_name(value) {
        Some(format!(
            "`{value}` needs its values in a bracket: {message}"
        ))
    } else {
        None
    };
    (found, node.span.start)
}

/// The first blank outside of texts and comments that is none of RON's, and where it stands.
fn foreign_blank(text: &str) -> Option<(usize, char)> {
    // Those that RON knows beside ASCII's.
    let is_known = |c: char| {
        matches!(
            c,
            '\u{85}' | '\u{200e}' | '\u{200f}' | '\u{2028}' | '\u{2029}'
        )
    };
    let is_blank = |c: char| c.is_whitespace() || matches!(c, '\u{200b}' | '\u{2060}' | '\u{feff}');
    let mut rest = text.char_indices();
    while let Some((at, c)) = rest.next() {
        match c {
            '"' => {
                while let Some((_, inner)) = rest.next() {
                    match inner {
                        '\\' => _ = rest.next(),
                        '"' => break,
                        _ => {}
                    }
                }
            }
            '/' if text[at..].starts_with("//") => _ = rest.find(|(_, c)| *c == '\n'),
            // What is in these is not looked at.
            '/' if text[at..].starts_with("/*") => return None,
            'r' if text[at..].starts_with("r#\"") => return None,
            c if !c.is_ascii() && is_blank(c) && !is_known(c) => return Some((at, c)),
            _ => {}
        }
    }
    None
}

/// A sign of another language right at the place of an error, and what would be right.
fn foreign_sign(code: &Error, before: &str, rest: &str) -> Option<&'static str> {
    let next = rest.trim_start().chars().next()?;
    let last = before.trim_end().chars().next_back();
    let is_part = |c: char| c.is_alphanumeric() || c == '_';
    let behind_name = rest.trim_start().trim_start_matches(is_part).trim_start();
    match (last, next) {
        _ if is_part(next) && behind_name.starts_with('=') => {
            Some("the value of a field stands behind a colon, `name: value`")
        }
        (_, '#') => Some("a comment begins with `//`"),
        (_, '*' | '+') => Some("numbers are written out: there is no arithmetic"),
        (_, ';') => Some("fields and values are separated by commas"),
        (_, '{' | '[') if *code == Error::ExpectedStructLike => {
            Some("the bracket around fields and values is round here, `(…)`")
        }
        (Some('(' | ','), quote @ ('"' | '\'')) if *code == Error::ExpectedIdentifier => {
            let mut parts = rest.trim_start().splitn(3, quote).skip(2);
            match parts.next().map(str::trim_start) {
                Some(behind) if !behind.starts_with(':') => {
                    Some("expected the name of a field, and a colon, before this text")
                }
                _ => Some("the name of a field has no quotes"),
            }
        }
        (Some('(' | '[' | ','), ',') => Some("there is a comma too many, with nothing before it"),
        _ => None,
    }
}

/// What is wrong with an `include`.
fn misplaced_include(error: &Error) -> Option<&'static str> {
    match error {
        Error::NoSuchStructField { found, .. } if found == "include" => Some(
            "`include` needs paths in double quotes: `include: \"base.ron\"`, or a list of them",
        ),
        Error::ExpectedDifferentStructName { found, .. } if found == "include" => {
            Some("`include` needs a path in double quotes: `include(\"water.ron\")`")
        }
        _ => None,
    }
}

/// What ron says, in a sentence that says what would be right.
pub(super) fn explain(error: &Error) -> String {
    if let Some(message) = misplaced_include(error) {
        return message.to_owned();
    }
    match error {
        Error::ExpectedNamedStructLike("Vec3") => {
            "expected a vector of three numbers, `(x, y, z)`".to_owned()
        }
        Error::NoSuchStructField {
            expected,
            found,
            outer,
        } => unknown_name("field", found, outer.as_deref(), expected),
        Error::NoSuchEnumVariant {
            expected,
            found,
            outer,
        } => unknown_name("variant", found, outer.as_deref(), expected),
        Error::MissingStructField { field, outer } => match outer {
            Some(outer) => format!("`{outer}` lacks the field `{field}`, which has no default"),
            None => format!("the field `{field}` is missing; it has no default"),
        },
        Error::DuplicateStructField { field, .. } => {
            format!("the field `{field}` is given twice; keep one")
        }
        Error::InvalidValueForType { expected, found } => {
            format!("expected {expected}, found {found}")
        }
        Error::ExpectedDifferentLength { expected, found } => {
            let expected = expected.replace("a sequence of ", "").replace("f32 values", "numbers");
            format!("expected {expected}, found {found}")
        }
        Error::ExpectedFloat => "expected a number".to_owned(),
        Error::ExpectedInteger => "expected a whole number".to_owned(),
        Error::IntegerOutOfBounds => "this whole number is too large or negative".to_owned(),
        Error::ExpectedBoolean => "expected `true` or `false`".to_owned(),
        Error::ExpectedString => "expected a text in double quotes".to_owned(),
        Error::ExpectedArray => "expected a list, `[…]`".to_owned(),
        Error::ExpectedStructLike => "expected `(…)`".to_owned(),
        Error::ExpectedNamedStructLike(name) => {
            format!("expected `(…)` with the fields of `{name}`")
        }
        Error::ExpectedIdentifier => "expected a name".to_owned(),
        Error::InvalidEscape(_) => {
            "a `\\` begins a sign such as `\\n` in a text; write folders with `/`, or `\\\\` for each `\\`".to_owned()
        }
        Error::SuggestRawIdentifier(found) if found.contains('.') && !found.starts_with('.') => {
            let (outer, inner) = found.split_once('.').unwrap_or((found, ""));
            format!(
                "a field within another stands in its bracket, `{outer}: ({inner}: …)`; names with dots are for \
                 `--set`"
            )
        }
        Error::SuggestRawIdentifier(found) => format!("expected a name, found `{found}`"),
        Error::ExpectedStructLikeEnd => "expected a comma or `)`".to_owned(),
        Error::ExpectedArrayEnd => "expected a comma or `]`".to_owned(),
        Error::ExpectedDifferentStructName { expected, found } => {
            format!("expected `(…)` with the fields of `{expected}`, found `{found}`")
        }
        Error::ExpectedComma => "expected a comma, or the end of a bracket".to_owned(),
        // What ron does with one `/`, which could begin a comment.
        Error::UnexpectedChar(found) => format!(
            "unexpected `{found}` after `/`: numbers are written out, there is no division, and a comment begins with \
             `//`"
        ),
        Error::ExpectedStringEnd => "the text that begins here has no closing quote".to_owned(),
        Error::ExpectedMapColon => "expected a colon after the field's name".to_owned(),
        Error::ExceededRecursionLimit => {
            "brackets lie in brackets more than 128 deep, deeper than any scene, study or order needs".to_owned()
        }
        Error::Eof => "the text ends too early; a bracket is not closed".to_owned(),
        Error::TrailingCharacters => "text after the end; a bracket closes too early".to_owned(),
        other => {
            let message = other.to_string();
            let mut rest = message.chars();
            rest.next().map_or_else(String::new, |first| {
                first.to_lowercase().chain(rest).collect()
            })
        }
    }
}
