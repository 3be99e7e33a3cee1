//! What all kinds of slips share: a place in a text in which other values are tried, and what was found there.

use std::ops::Range;

use ron::error::Error;
use serde::de::DeserializeOwned;

use crate::loading::{ron_text::deserialize, spans::byte_at};

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
    read: fn(&str) -> Result<(), ron::error::SpannedError>,
}

impl<'a> Place<'a> {
    pub(super) fn of<T: DeserializeOwned>(text: &'a str, span: Range<usize>) -> Option<Self> {
        let read = |text: &str| deserialize::<T>(text).map(drop);
        let is_worth_it = text.len() <= LONGEST && !span.is_empty();
        is_worth_it.then_some(Self { text, span, read })
    }

    /// The error with another value in the place, unless it is behind the place.
    pub(super) fn refusal(&self, value: &str) -> Option<Error> {
        let mut text = self.text.to_owned();
        text.replace_range(self.span.clone(), value);
        let error = (self.read)(&text).err()?;
        let at = byte_at(&text, error.span.end.line, error.span.end.col);
        (at <= self.span.start + value.len()).then_some(error.code)
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
