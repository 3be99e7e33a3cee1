//! Known curves: figures over time from a CSV file.

use std::path::{Path, PathBuf};

use crate::input::{read_text, without_mark};

/// Figures over time, in SI units, times ascending.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Curve {
    /// Times \[s] and figures.
    pub points: Vec<(f64, f64)>,
    /// What a reader should know: the file's lines of comment.
    pub notes: Vec<String>,
}

/// Why a file gives no curve.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum CurveError {
    /// It cannot be read.
    #[error("{}: {source}", .file.display())]
    Unreadable {
        /// The file.
        file: PathBuf,
        /// What the system says.
        source: std::io::Error,
    },
    /// It has no such column.
    #[error("{}: there is no column `{name}`; the columns are {known}", .file.display())]
    NoColumn {
        /// The file.
        file: PathBuf,
        /// The field that names it, `time` or `value`.
        field: &'static str,
        /// The name.
        name: String,
        /// What there is.
        known: String,
    },
    /// A line is no row of figures, or there is none.
    #[error("{}:{line}: {message}", .file.display())]
    Malformed {
        /// The file.
        file: PathBuf,
        /// From 1.
        line: usize,
        /// What is wrong and what would be right.
        message: String,
    },
}

impl CurveError {
    /// The field of the reference that it is about.
    pub(crate) fn field(&self) -> &'static str {
        match self {
            Self::NoColumn { field, .. } => field,
            Self::Unreadable { .. } | Self::Malformed { .. } => "file",
        }
    }
}

impl Curve {
    /// Reads the columns of these names, of times and of figures, by default the first and the second; `to_si` makes
    /// time \[s] and figure of what a row says. The file may begin with lines of comment (`#`).
    pub fn load(
        file: &Path,
        columns: [Option<&str>; 2],
        to_si: impl Fn([f64; 2]) -> (f64, f64),
    ) -> Result<Self, CurveError> {
        let text = read_text(file).map_err(|source| CurveError::Unreadable {
            file: file.to_owned(),
            source,
        })?;
        Self::parse(&text, file, columns, to_si)
    }

    /// As [`load`](Self::load), from a text; `file` stands in errors.
    pub fn parse(
        text: &str,
        file: &Path,
        [time, value]: [Option<&str>; 2],
        to_si: impl Fn([f64; 2]) -> (f64, f64),
    ) -> Result<Self, CurveError> {
        let malformed = |line: usize, message: String| CurveError::Malformed {
            file: file.to_owned(),
            line,
            message,
        };
        let text = without_mark(text);
        let comments = text.lines().filter_map(|line| line.strip_prefix('#'));
        let notes = comments.map(|note| note.trim().to_owned()).collect();
        let mut lines = (1..)
            .zip(text.lines())
            .filter(|(_, line)| !line.trim().is_empty() && !line.starts_with('#'));
        let Some((_, header)) = lines.next() else {
            let message = "there is no line with the names of the columns".to_owned();
            return Err(malformed(1, message));
        };
        let names: Vec<&str> = header.split(',').map(str::trim).collect();
        let column = |field, name: Option<&str>, default: usize| {
            let found = match name {
                Some(name) => names.iter().position(|known| *known == name),
                None => (default < names.len()).then_some(default),
            };
            found.ok_or_else(|| CurveError::NoColumn {
                file: file.to_owned(),
                field,
                name: name.map_or_else(|| (default + 1).to_string(), str::to_owned),
                known: names.join(", "),
            })
        };
        let columns = [column("time", time, 0)?, column("value", value, 1)?];
        let mut points = Vec::new();
        for (number, line) in lines {
            let fields: Vec<&str> = line.split(',').map(str::trim).collect();
            let mut point = [0.0; 2];
            for (figure, &column) in point.iter_mut().zip(&columns) {
                let text = fields.get(column).copied().unwrap_or_default();
                let parsed = text.parse().ok().filter(|value: &f64| value.is_finite());
                *figure = parsed.ok_or_else(|| {
                    let name = names[column];
                    malformed(
                        number,
                        format!("`{text}` in column `{name}` is not a number"),
                    )
                })?;
            }
            points.push(to_si(point));
        }
        if points.is_empty() {
            return Err(malformed(1, "there is no row of figures".to_owned()));
        }
        points.sort_by(|a, b| a.0.total_cmp(&b.0));
        Ok(Self { points, notes })
    }

    /// The figure at a time \[s], linear between points; none before the first and after the last.
    pub fn at(&self, time: f64) -> Option<f64> {
        let after = self.points.partition_point(|point| point.0 < time);
        let &(t1, y1) = self.points.get(after)?;
        let Some(&(t0, y0)) = after.checked_sub(1).and_then(|k| self.points.get(k)) else {
            return (t1 == time).then_some(y1);
        };
        Some(y0 + (y1 - y0) * (time - t0) / (t1 - t0))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn parse(text: &str, columns: [Option<&str>; 2]) -> Result<Curve, CurveError> {
        Curve::parse(text, Path::new("f.csv"), columns, |[t, y]| {
            (0.5 * t, 2.0 * y - 1.0)
        })
    }

    #[test]
    fn a_curve_is_in_si_units_and_linear_between_its_points() {
        let text = "# a note\nT,Z,Y\n0,1,x\n4,3,x\n2,2,x\n";
        let curve = parse(text, [None; 2]).expect("a curve");
        assert_eq!(curve.points, [(0.0, 1.0), (1.0, 3.0), (2.0, 5.0)]);
        assert_eq!(curve.notes, ["a note"]);
        for (t, y) in [
            (0.0, Some(1.0)),
            (0.5, Some(2.0)),
            (2.0, Some(5.0)),
            (2.1, None),
            (-0.1, None),
        ] {
            assert_eq!(curve.at(t), y);
        }
    }

    #[test]
    fn what_is_wrong_with_a_file_is_said_with_its_line() {
        for (text, time, value, expected) in [
            ("", None, None, "f.csv:1: there is no line"),
            ("T,Z\n", None, None, "no row"),
            ("T,Z\n0,1\n1,x\n", None, None, "f.csv:3: `x` in column `Z`"),
            ("T,Z\n0\n", None, None, "f.csv:2: `` in column `Z`"),
            (
                "T,Z\n0,1\n",
                Some("t"),
                None,
                "no column `t`; the columns are T, Z",
            ),
            ("T\n0\n", None, None, "no column `2`"),
        ] {
            let error = parse(text, [time, value]);
            let error = error.expect_err(text).to_string();
            assert!(error.contains(expected), "{text}: {error}");
        }
    }
}
