//! What all kinds of slips share: a place in a text in which other values are tried, and what was found there.

use std::ops::Range;

use ron::error::Error;
use serde::de::DeserializeOwned;

use crate::loading::{
    ron_text::deserialize,
    spans::{byte_at, scan},
};

/// Longer texts are not read a few dozen times for a hint \[bytes].
const LONGEST: usize = 1 << 20;

/// No variant and no field is called so.
pub(super) const NOBODY: &str = "nobody_is_called_so";

/// What is wrong with a value, and what was meant.
#[derive(Debug, PartialEq)]
pub(in crate::loading) struct Slip {
    pub(super) what: String,
    pub(super) meant: Option<Meant>,
}

#[derive(Debug, PartialEq)]
pub(super) enum Meant {
    /// This in its place.
    Value(String),
    /// It is the value of this field of the struct that belongs in its place.
    Field(String),
}

impl Slip {
    /// The message for a value in a file.
    pub(in crate::loading) fn in_file(&self, value: &str) -> String {
        self.message(match &self.meant {
            Some(Meant::Value(meant)) => Some(meant.clone()),
            Some(Meant::Field(field)) => Some(format!("({field}: {value})")),
            None => None,
        })
    }

    /// The message for the value of an override.
    pub(in crate::loading) fn in_override(&self, path: &str, value: &str) -> String {
        self.message(match &self.meant {
            Some(Meant::Value(meant)) => Some(format!("{path}={meant}")),
            Some(Meant::Field(field)) => Some(format!("{path}.{field}={value}")),
            None => None,
        })
    }

    /// Whether what was meant is no more than the value.
    pub(in crate::loading) fn is_of_one_value(&self) -> bool {
        match &self.meant {
            Some(Meant::Value(meant)) => scan(meant).is_some(),
            Some(Meant::Field(_)) | None => true,
        }
    }

    fn message(&self, meant: Option<String>) -> String {
        match meant {
            Some(meant) => format!("{}; did you mean `{meant}`?", self.what),
            None => self.what.clone(),
        }
    }

    pub(super) fn value(what: impl Into<String>, meant: String) -> Self {
        Self {
            what: what.into(),
            meant: Some(Meant::Value(meant)),
        }
    }
}

/// A place in a text that other values are tried in.
pub(super) struct Place<'a> {
    text: &'a str,
    pub(super) span: Range<usize>,
    /// What stands before a value that is tried.
    before: String,
    read: fn(&str) -> Result<(), ron::error::SpannedError>,
}

impl<'a> Place<'a> {
    pub(super) fn of<T: DeserializeOwned>(text: &'a str, span: Range<usize>) -> Option<Self> {
        let read = |text: &str| deserialize::<T>(text).map(drop);
        let is_worth_it = text.len() <= LONGEST && !span.is_empty();
        is_worth_it.then_some(Self {
            text,
            span,
            before: String::new(),
            read,
        })
    }

    /// The place of the value of a field that stands in this one.
    pub(super) fn within(self, field: &str) -> Self {
        let before = format!("{field}: ");
        Self { before, ..self }
    }

    /// The error with another value in the place, unless it is behind the place.
    pub(super) fn refusal(&self, value: &str) -> Option<Error> {
        let mut text = self.text.to_owned();
        let value = format!("{}{value}", self.before);
        text.replace_range(self.span.clone(), &value);
        let error = (self.read)(&text).err()?;
        let at = byte_at(&text, error.span.end.line, error.span.end.col);
        (at <= self.span.start + value.len()).then_some(error.code)
    }

    /// Whether the place is behind the name of a field, `name:`.
    pub(super) fn is_value_of(&self, name: &str) -> bool {
        let before = self.text[..self.span.start].trim_end();
        let before = before.strip_suffix(':').map(str::trim_end);
        before.is_some_and(|before| before.ends_with(name))
    }

    pub(super) fn takes(&self, value: &str) -> bool {
        self.refusal(value).is_none()
    }
}

/// The variants that belong in the place.
pub(super) fn variants_of(place: &Place) -> Option<Vec<&'static str>> {
    match place.refusal(NOBODY)? {
        Error::NoSuchEnumVariant { expected, .. } => Some(expected.to_vec()),
        _ => None,
    }
}

/// The fields that ron says there are where it meets an unknown one.
pub(super) fn fields_of(place: &Place, unknown: &str) -> Option<Vec<&'static str>> {
    match place.refusal(unknown)? {
        Error::NoSuchStructField {
            expected, found, ..
        } if found == NOBODY => Some(expected.to_vec()),
        _ => None,
    }
}
