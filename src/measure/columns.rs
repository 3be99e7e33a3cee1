//! Columns of figures from a CSV file.

use std::path::Path;

use super::{CurveError, malformed};
use crate::input::{read_text, without_mark};

/// A column that is wanted.
#[derive(Debug, Clone, Copy)]
pub struct Column<'a> {
    /// The field that names it, for errors.
    pub field: &'static str,
    /// Its name.
    pub name: &'a str,
    /// Another name that it may have.
    pub(super) alias: Option<&'static str>,
    /// Whether a file without it is refused.
    pub required: bool,
}

impl<'a> Column<'a> {
    /// A column that must be there.
    pub fn named(name: &'a str) -> Self {
        Self {
            field: "file",
            name,
            alias: None,
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

    /// The column of times, `t` or `time`.
    pub fn time() -> Self {
        Self {
            alias: Some("time"),
            ..Self::named("t")
        }
    }

    fn is(&self, name: &str) -> bool {
        self.name == name || self.alias == Some(name)
    }
}

/// Treatment of columns that are not wanted.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Others {
    /// They are left out: files of experiments have many columns.
    Ignored,
    /// The file is refused: a name that is misspelt would be left out silently.
    Refused,
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
    /// Reads a table that has these columns alone, in any order, and may begin with lines of comment (`#`).
    ///
    /// # Errors
    /// When the file cannot be read, a required column is absent, a column is unknown or there twice, or a line holds
    /// what is no finite number.
    pub fn load(file: &Path, wanted: [Column; N]) -> Result<Self, CurveError> {
        let text = read_text(file).map_err(|source| CurveError::Unreadable {
            file: file.to_owned(),
            source,
        })?;
        Self::parse(&text, file, wanted, Others::Refused)
    }

    /// As [`load`](Self::load), from a text; `file` stands in errors.
    pub fn parse(
        text: &str,
        file: &Path,
        wanted: [Column; N],
        others: Others,
    ) -> Result<Self, CurveError> {
        let text = without_mark(text);
        let comments = text.lines().filter_map(|line| line.strip_prefix('#'));
        let notes = comments.map(|note| note.trim().to_owned()).collect();
        let (names, mut lines) = header(text, file)?;
        let places = places(&names, file, &wanted, others)?;
        let mut rows = Vec::new();
        for (line, text) in &mut lines {
            let fields: Vec<&str> = text.split(',').map(str::trim).collect();
            if fields.len() > names.len() {
                let (found, known) = (fields.len(), names.len());
                let message = format!(
                    "{found} figures for {known} columns; figures have decimal points and are separated by commas"
                );
                return Err(malformed(file, line, message));
            }
            let mut row = [0.0; N];
            for (figure, place) in row.iter_mut().zip(places) {
                let Some(place) = place else { continue };
                let text = fields.get(place).copied().unwrap_or_default();
                let parsed = text.parse().ok().filter(|value: &f64| value.is_finite());
                *figure = parsed.ok_or_else(|| {
                    let name = names[place];
                    let message = match text {
                        "" => format!("there is no figure in column `{name}`"),
                        _ => format!("`{text}` in column `{name}` is not a number"),
                    };
                    malformed(file, line, message)
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

type Lines<'t> = Box<dyn Iterator<Item = (usize, &'t str)> + 't>;

/// Names of a text's columns, and the numbered lines after them.
fn header<'t>(text: &'t str, file: &Path) -> Result<(Vec<&'t str>, Lines<'t>), CurveError> {
    let mut lines = (1..)
        .zip(text.lines())
        .filter(|(_, line)| !line.trim().is_empty() && !line.starts_with('#'));
    let Some((number, header)) = lines.next() else {
        let message = "there is no line with the names of the columns";
        return Err(malformed(file, 1, message.to_owned()));
    };
    let names = names(header);
    if let [name] = names[..]
        && let Some(sign) = name.chars().find(|c| matches!(c, ';' | '\t'))
    {
        let message = format!("the columns are separated by {sign:?}; write commas");
        return Err(malformed(file, number, message));
    }
    if let [name] = names[..]
        && lines_are_of_blanks(text, name)
    {
        let message = "the columns are separated by blanks; write commas";
        return Err(malformed(file, number, message.to_owned()));
    }
    if let [first, ..] = names[..]
        && first.parse::<f64>().is_ok()
    {
        let message = "there is no line with the names of the columns before the figures";
        return Err(malformed(file, number, message.to_owned()));
    }
    Ok((names, Box::new(lines)))
}

/// Whether the figures of a text are separated by blanks, as many as the words of its header.
fn lines_are_of_blanks(text: &str, header: &str) -> bool {
    let words = header.split_whitespace().count();
    let is_row = |line: &str| {
        let mut figures = line.split_whitespace();
        words > 1
            && figures.clone().count() == words
            && figures.all(|figure| figure.parse::<f64>().is_ok())
    };
    text.lines().any(is_row)
}

/// Names in a line of names.
fn names(header: &str) -> Vec<&str> {
    header.split(',').map(plain).collect()
}

/// A name without the quotes that spreadsheets write.
fn plain(name: &str) -> &str {
    let name = name.trim();
    let inner = name
        .strip_prefix('"')
        .and_then(|rest| rest.strip_suffix('"'));
    inner.unwrap_or(name).trim()
}

/// The names of the columns of a text. Fails if there is none.
pub(super) fn names_of<'t>(text: &'t str, file: &Path) -> Result<Vec<&'t str>, CurveError> {
    header(without_mark(text), file).map(|(names, _)| names)
}

/// Where the wanted columns are.
fn places<const N: usize>(
    names: &[&str],
    file: &Path,
    wanted: &[Column; N],
    others: Others,
) -> Result<[Option<usize>; N], CurveError> {
    let known = || {
        let of = |column: &Column| match column.required {
            true => column.name.to_owned(),
            false => format!("{} (optional)", column.name),
        };
        wanted.iter().map(of).collect::<Vec<_>>().join(", ")
    };
    let refuse = |message: String| Err(malformed(file, 1, message));
    let mut places = [None; N];
    for (place, column) in places.iter_mut().zip(wanted) {
        let mut found = (0..).zip(names).filter(|(_, name)| column.is(name));
        *place = found.next().map(|(place, _)| place);
        if let Some((second, name)) = found.next() {
            let first = place.unwrap_or_default() + 1;
            let name = match names.get(first - 1) {
                Some(other) if other != name => format!("`{other}` and `{name}`"),
                _ => format!("`{name}`"),
            };
            return refuse(format!(
                "the column {name} is there twice, as column {first} and {}; keep one",
                second + 1
            ));
        }
    }
    // A name in another case is the likeliest reason for a column that is missing.
    if others == Others::Refused {
        let is_known = |name: &&&str| wanted.iter().any(|column| column.is(name));
        if let Some(name) = names.iter().find(|name| !is_known(name)) {
            // `T`, or `t [s]` and `t_s`: a name with its unit.
            let lower = name.to_lowercase();
            let bare = lower.split([' ', '[', '(', '/', '_']).next();
            let of = |name: &str| wanted.iter().find(|column| column.is(name));
            let meant = of(&lower).or_else(|| of(bare?));
            let meant = meant.map_or_else(String::new, |column| {
                format!("; did you mean `{}`?", column.name)
            });
            return refuse(format!(
                "unknown column `{name}`{meant} (columns: {})",
                known()
            ));
        }
    }
    for (place, column) in places.iter().zip(wanted) {
        if place.is_none() && column.required {
            return Err(CurveError::NoColumn {
                file: file.to_owned(),
                field: column.field,
                name: column.name.to_owned(),
                known: names.join(", "),
            });
        }
    }
    Ok(places)
}
