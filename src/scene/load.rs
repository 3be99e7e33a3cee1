//! From text to a checked scene: the file first, then the overrides, then the checks.

use std::path::Path;

use ron::error::{Error, Position, Span, SpannedError};
use ron::extensions::Extensions;
use ron::ser::PrettyConfig;
use serde::de::DeserializeOwned;

use super::check::Problem;
use super::error::unknown_name;
use super::overrides::Override;
use super::slips::{slip, slip_around};
use super::spans::{Kind, byte_at, is_name, line_column, scan};
use super::{BoundaryShape, Place, Scene, SceneError, Size};
use crate::input::{read_text, without_mark};

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
    complete(text, &options(), "()").or_else(|error| {
        let two_brackets =
            ron::Options::default().with_default_extension(Extensions::IMPLICIT_SOME);
        complete(text, &two_brackets, "(())").map_err(|_| error)
    })
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

impl Scene {
    /// Reads the scene file at `path`, applies `overrides` in their order and checks the result.
    ///
    /// Errors name the file, the line and the column, or the override, that cannot be.
    pub fn load(path: &Path, overrides: &[Override]) -> Result<Self, SceneError> {
        let text = read_text(path).map_err(|source| SceneError::Unreadable {
            file: path.to_owned(),
            source,
        })?;
        let file_name = path.display().to_string();
        let scene = Self::parse(&text, &file_name, overrides)?;
        match &scene.order {
            Some(order) if !Path::new(order).is_file() => {
                let problem = Problem::new("order", format!("there is no file `{order}`"));
                Err(locate(problem, &text, &file_name, overrides))
            }
            _ => Ok(scene),
        }
    }

    /// As [`load`](Self::load), from a text. `file_name` stands in errors; `order` and the meshes' files
    /// are taken relative to its folder.
    pub fn parse(text: &str, file_name: &str, overrides: &[Override]) -> Result<Self, SceneError> {
        let text = without_mark(text);
        let mut scene: Self = read(text, file_name)?;
        for change in overrides {
            scene = change.apply(&scene)?;
        }
        if let Some(folder) = Path::new(file_name).parent() {
            for file in scene.files_mut() {
                *file = folder.join(&*file).display().to_string();
            }
        }
        super::check::check(&scene)
            .map_err(|problem| locate(problem, text, file_name, overrides))?;
        Ok(scene)
    }

    /// The scene as the text of a scene file, defaults included, in the spelling that files use: no `Some(…)`, one
    /// bracket around a variant's fields. Fails if ron does.
    pub fn to_ron(&self) -> Result<String, SceneError> {
        let pretty = PrettyConfig::new().new_line("\n");
        let written = options().to_string_pretty(self, pretty);
        let text = written.map_err(|error| SceneError::Syntax {
            place: Place::Field("scene".to_owned()),
            message: error.to_string(),
        })?;
        Ok(plain_names(&text) + "\n")
    }

    /// Paths of the files that belong to the scene: the order's, if it names one, then those of the meshes, then those
    /// that gauges are compared with.
    pub fn files_mut(&mut self) -> impl Iterator<Item = &mut String> {
        let meshes = self.boundaries.iter_mut().filter_map(|shape| match shape {
            BoundaryShape::Mesh(mesh) => Some(&mut mesh.file),
            _ => None,
        });
        let references = self.gauges.iter_mut().filter_map(|gauge| {
            let reference = gauge.reference.as_mut()?;
            Some(&mut reference.file)
        });
        self.order.iter_mut().chain(meshes).chain(references)
    }

    /// Checks a scene that was built in code, as [`load`](Self::load) checks a file.
    pub fn check(&self) -> Result<(), SceneError> {
        self.checked_size().map(|_| ())
    }

    /// As [`check`](Self::check), and says what room the scene needs.
    pub(crate) fn checked_size(&self) -> Result<Size, SceneError> {
        super::check::check(self).map_err(|problem| SceneError::Invalid {
            place: Place::Field(problem.path.clone()),
            field: problem.path,
            message: problem.message,
        })
    }
}

/// Gives a problem its place: the last override that touches the field, else the field in the file, else (where the
/// field has its default) the innermost value around it that the file does write.
fn locate(problem: Problem, text: &str, file_name: &str, overrides: &[Override]) -> SceneError {
    let touches = |change: &&Override| {
        let (a, b) = (change.path.as_str(), problem.path.as_str());
        let within = |a: &str, b: &str| {
            b.strip_prefix(a)
                .is_some_and(|rest| rest.is_empty() || rest.starts_with('.'))
        };
        within(a, b) || within(b, a)
    };
    let place = match overrides.iter().rev().find(touches) {
        Some(change) => change.place(),
        None => place_of(&problem.path, text, file_name),
    };
    SceneError::Invalid {
        place,
        field: problem.path,
        message: problem.message,
    }
}

/// An error of ron's as one of ours, at the place the user must look at.
fn explain_in_file<T: DeserializeOwned>(
    error: &SpannedError,
    text: &str,
    file_name: &str,
) -> SceneError {
    let end = byte_at(text, error.span.end.line, error.span.end.col);
    let start = byte_at(text, error.span.start.line, error.span.start.col);
    let tree = scan(text);
    let mut message = explain(&error.code);
    let byte = match (&error.code, &tree) {
        (Error::NoSuchStructField { .. } | Error::NoSuchEnumVariant { .. }, _) => start,
        (Error::DuplicateStructField { field, .. }, Some(tree)) => {
            tree.last_key(field, end).map_or(end, |key| key.start)
        }
        (Error::MissingStructField { .. } | Error::ExpectedDifferentLength { .. }, Some(tree)) => {
            // A name that stands alone lacks the fields that have no default.
            let alone = tree.name_that_ends(end, text).or_else(|| tree.bracket(end));
            alone.map_or(end, |node| node.span.start)
        }
        (_, Some(tree)) => match tree.innermost(end) {
            Some(node) => {
                if let Some(slip) = slip::<T>(text, node.span.clone()) {
                    message = slip.in_file(&text[node.span.clone()]);
                } else if node.kind == Kind::Leaf
                    && node.span.end == end
                    && is_name(&text[node.span.clone()])
                {
                    message = format!(
                        "`{}` needs its values in a bracket: {message}",
                        &text[node.span.clone()]
                    );
                }
                node.span.start
            }
            None => end,
        },
        (_, None) => match slip_around::<T>(text, end) {
            Some((slip, start)) => {
                message = slip;
                start
            }
            None => end,
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

/// What ron says, in a sentence that says what would be right.
pub(super) fn explain(error: &Error) -> String {
    match error {
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
            let expected = expected.replace("a sequence of ", "");
            format!(
                "expected {}, found {found}",
                expected.replace("f32 values", "numbers")
            )
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
        Error::SuggestRawIdentifier(found) => format!("expected a name, found `{found}`"),
        Error::ExpectedStructLikeEnd => "expected a comma or `)`".to_owned(),
        Error::ExpectedArrayEnd => "expected a comma or `]`".to_owned(),
        Error::ExpectedDifferentStructName { expected, found } => {
            format!("expected `(…)` with the fields of `{expected}`, found `{found}`")
        }
        Error::ExpectedComma => "expected a comma".to_owned(),
        Error::ExpectedMapColon => "expected a colon after the field's name".to_owned(),
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
