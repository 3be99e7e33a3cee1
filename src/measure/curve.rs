//! Known curves: figures over time from a CSV file.

use std::path::Path;

use super::{Column, Columns, CurveError};
use crate::input::read_text;

/// Figures over time, in SI units, times ascending.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Curve {
    /// Times \[s] and figures.
    pub points: Vec<(f64, f64)>,
    /// What a reader should know: the file's lines of comment.
    pub notes: Vec<String>,
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
        let column = |field, name, place| Column {
            field,
            name,
            place,
            required: true,
        };
        let columns = [column("time", time, 0), column("value", value, 1)];
        let Columns { rows, notes, .. } = Columns::parse(text, file, columns)?;
        let mut points: Vec<(f64, f64)> = rows.into_iter().map(|(_, row)| to_si(row)).collect();
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
