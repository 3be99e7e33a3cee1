//! From text to a checked scene: the file first, then the overrides, then the checks.

use std::path::Path;

use ron::error::{Error, SpannedError};
use ron::extensions::Extensions;
use serde::de::DeserializeOwned;

use super::check::Problem;
use super::error::unknown_name;
use super::overrides::Override;
use super::spans::{byte_at, line_column, scan};
use super::{BoundaryShape, Place, Scene, SceneError, Size};

/// What every scene file may leave out: `Some(…)` around a value, and the second bracket in `Pcisph((…))`.
pub(super) fn options() -> ron::Options {
    ron::Options::default()
        .with_default_extension(Extensions::IMPLICIT_SOME)
        .with_default_extension(Extensions::UNWRAP_VARIANT_NEWTYPES)
}

/// Reads one value; with or without the second bracket, as long as the file is consistent.
pub(super) fn deserialize<T: DeserializeOwned>(text: &str) -> Result<T, SpannedError> {
    options().from_str(text).or_else(|error| {
        ron::Options::default()
            .with_default_extension(Extensions::IMPLICIT_SOME)
            .from_str(text)
            .map_err(|_| error)
    })
}

/// Reads what a RON file says; what is wrong with it is told with its line and column.
pub(crate) fn read<T: DeserializeOwned>(text: &str, file_name: &str) -> Result<T, SceneError> {
    deserialize(text).map_err(|error| explain_in_file(&error, text, file_name))
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
        let text = std::fs::read_to_string(path).map_err(|source| SceneError::Unreadable {
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

    /// Paths of the files that belong to the scene: the order's, if it names one, then those of the meshes.
    pub fn files_mut(&mut self) -> impl Iterator<Item = &mut String> {
        let meshes = self.boundaries.iter_mut().filter_map(|shape| match shape {
            BoundaryShape::Mesh(mesh) => Some(&mut mesh.file),
            _ => None,
        });
        self.order.iter_mut().chain(meshes)
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
fn explain_in_file(error: &SpannedError, text: &str, file_name: &str) -> SceneError {
    let end = byte_at(text, error.span.end.line, error.span.end.col);
    let start = byte_at(text, error.span.start.line, error.span.start.col);
    let tree = scan(text);
    let byte = match (&error.code, &tree) {
        (Error::NoSuchStructField { .. } | Error::NoSuchEnumVariant { .. }, _) => start,
        (Error::DuplicateStructField { field, .. }, Some(tree)) => {
            tree.last_key(field, end).map_or(end, |key| key.start)
        }
        (Error::MissingStructField { .. } | Error::ExpectedDifferentLength { .. }, Some(tree)) => {
            tree.bracket(end).map_or(end, |node| node.span.start)
        }
        (_, Some(tree)) => tree.innermost(end).map_or(end, |node| node.span.start),
        (_, None) => end,
    };
    let (line, column) = line_column(text, byte);
    SceneError::Syntax {
        place: Place::File {
            file: file_name.to_owned(),
            line,
            column,
        },
        message: explain(&error.code),
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
