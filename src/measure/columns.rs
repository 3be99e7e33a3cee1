//! Columns of figures from a CSV file.

use std::path::Path;

use super::{CurveError, malformed};
use crate::input::{read_text, without_mark};

/// A column that is wanted.
#[derive(Debug, Clone, Copy)]
pub struct Column<'a> {
    /// The field that names it, for errors.
    pub field: &'static str,
    /// Its name; the one at `place` if absent.
    pub name: Option<&'a str>,
    /// Where it is if it has no name, from 0.
    pub place: usize,
    /// Whether a file without it is refused.
    pub required: bool,
}

impl<'a> Column<'a> {
    /// A column that must be there.
    pub fn named(name: &'a str) -> Self {
        Self {
            field: "file",
            name: Some(name),
            place: 0,
            required: true,
        }
    }

    /// A column that may be left out.
    pub fn optional(name: &'a str) -> Self {
        Self {
            required: false,
            ..Self::named(name)
        }
    }

    /// The first column, whatever its name is.
    pub fn first() -> Self {
        Self {
            name: None,
            ..Self::named("")
        }
    }
}

/// Columns of a file.
#[derive(Debug, Clone, PartialEq)]
pub struct Columns<const N: usize> {
    /// Which of those that were wanted there are.
    pub present: [bool; N],
    /// Number of the line and the figures; 0 for a column that is absent.
    pub rows: Vec<(usize, [f64; N])>,
    /// The file's lines of comment.
    pub notes: Vec<String>,
}

impl<const N: usize> Columns<N> {
    /// Reads these columns of a file, which may begin with lines of comment (`#`).
    ///
    /// # Errors
    /// When the file cannot be read, a required column is absent, or a line holds what is no finite number.
    pub fn load(file: &Path, wanted: [Column; N]) -> Result<Self, CurveError> {
        let text = read_text(file).map_err(|source| CurveError::Unreadable {
            file: file.to_owned(),
            source,
        })?;
        Self::parse(&text, file, wanted)
    }

    /// As [`load`](Self::load), from a text; `file` stands in errors.
    pub fn parse(text: &str, file: &Path, wanted: [Column; N]) -> Result<Self, CurveError> {
        let text = without_mark(text);
        let comments = text.lines().filter_map(|line| line.strip_prefix('#'));
        let notes = comments.map(|note| note.trim().to_owned()).collect();
        let mut lines = (1..)
            .zip(text.lines())
            .filter(|(_, line)| !line.trim().is_empty() && !line.starts_with('#'));
        let Some((_, header)) = lines.next() else {
            let message = "there is no line with the names of the columns";
            return Err(malformed(file, 1, message.to_owned()));
        };
        let names: Vec<&str> = header.split(',').map(str::trim).collect();
        let mut places = [None; N];
        for (place, column) in places.iter_mut().zip(wanted) {
            *place = match column.name {
                Some(name) => names.iter().position(|known| *known == name),
                None => (column.place < names.len()).then_some(column.place),
            };
            if place.is_none() && column.required {
                let name = column.name.map(str::to_owned);
                return Err(CurveError::NoColumn {
                    file: file.to_owned(),
                    field: column.field,
                    name: name.unwrap_or_else(|| (column.place + 1).to_string()),
                    known: names.join(", "),
                });
            }
        }
        let mut rows = Vec::new();
        for (line, text) in lines {
            let fields: Vec<&str> = text.split(',').map(str::trim).collect();
            let mut row = [0.0; N];
            for (figure, place) in row.iter_mut().zip(places) {
                let Some(place) = place else { continue };
                let text = fields.get(place).copied().unwrap_or_default();
                let parsed = text.parse().ok().filter(|value: &f64| value.is_finite());
                *figure = parsed.ok_or_else(|| {
                    let name = names[place];
                    malformed(
                        file,
                        line,
                        format!("`{text}` in column `{name}` is not a number"),
                    )
                })?;
            }
            rows.push((line, row));
        }
        if rows.is_empty() {
            let message = "there is no row of figures";
            return Err(malformed(file, 1, message.to_owned()));
        }
        Ok(Self {
            present: places.map(|place| place.is_some()),
            rows,
            notes,
        })
    }

    /// Refuses a file whose first column, times, does not ascend from row to row.
    pub fn ascending(self, file: &Path) -> Result<Self, CurveError> {
        let falls = |pair: &&[(usize, [f64; N])]| pair[1].1[0] <= pair[0].1[0];
        match self.rows.windows(2).find(falls) {
            None => Ok(self),
            Some(pair) => {
                let (before, now) = (pair[0].1[0], pair[1].1[0]);
                let message = format!(
                    "the time {now} s comes after {before} s; times must ascend from row to row, so that there is one \
                     value at a time"
                );
                Err(malformed(file, pair[1].0, message))
            }
        }
    }
}
