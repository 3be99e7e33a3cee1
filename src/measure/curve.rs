//! Known curves: figures over time from a CSV file.

use std::path::Path;

use super::columns::names_of;
use super::{Column, Columns, CurveError, Others, malformed};
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
    /// Reads the columns of these names, of times and of figures; `to_si` makes time \[s] and figure of what a row
    /// says. Without a name for times, the one column that is called `t`, `T`, `time` or `tau`, perhaps with a unit
    /// (`t_s`); without one for figures, the only other column. The file may begin with lines of comment (`#`).
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
        let [time, value] = chosen(&names_of(text, file)?, file, [time, value])?;
        let column = |field, name| Column {
            field,
            ..Column::named(name)
        };
        let columns = [column("time", time), column("value", value)];
        let Columns { rows, notes, .. } = Columns::parse(text, file, columns, Others::Ignored)?;
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

/// Whether a heading is a name of time, perhaps with a unit after it.
fn is_time(heading: &str) -> bool {
    let end = heading.find(|c: char| !c.is_ascii_alphabetic());
    let word = &heading[..end.unwrap_or(heading.len())];
    // `t_over_T` and `tA0` are times without a unit.
    let is_ratio = heading.contains("_over_") || heading.contains('/');
    let names = ["t", "time", "times", "tau"];
    names.contains(&word.to_lowercase().as_str()) && !is_ratio
}

/// The names of the columns of times and of figures.
fn chosen<'a>(
    names: &[&'a str],
    file: &Path,
    [time, value]: [Option<&'a str>; 2],
) -> Result<[&'a str; 2], CurveError> {
    let list = names.join(", ");
    let refuse = |message: String| Err(malformed(file, 1, message));
    // A name that is not there is told with all that are.
    if let Some(time) = time.filter(|time| !names.contains(time)) {
        return Ok([time, value.unwrap_or(time)]);
    }
    let time = match time {
        Some(time) => time,
        None => {
            let mut times = names
                .iter()
                .filter(|name| is_time(name) && Some(**name) != value);
            match (times.next(), times.next()) {
                (Some(time), None) => time,
                (first, _) => {
                    let what = if first.is_some() {
                        "more than one"
                    } else {
                        "no"
                    };
                    return refuse(format!(
                        "{what} column is called `t` or `time`; name that of the times, `time: \"…\"` (columns: {list})"
                    ));
                }
            }
        }
    };
    let value = match value {
        Some(value) => value,
        None => {
            let mut others = names.iter().filter(|name| **name != time);
            match (others.next(), others.next()) {
                (Some(value), None) => value,
                (first, _) => {
                    let what = match first {
                        Some(_) => "there is more than one column beside the times",
                        None => "there is no column beside the times",
                    };
                    return refuse(format!(
                        "{what}; name that of the figures, `value: \"…\"` (columns: {list})"
                    ));
                }
            }
        }
    };
    Ok([time, value])
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
        let text = "# a note\nZ,T,Y\n1,0,x\n3,4,x\n2,2,x\n";
        let curve = parse(text, [None, Some("Z")]).expect("a curve");
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

    /// The order of the columns does not matter, and spreadsheets put names in quotes.
    #[test]
    fn columns_are_found_by_name() {
        for text in [
            "t,x\n2,3\n",
            "x,t\n3,2\n",
            "\"x\",\"time [s]\"\n3,2\n",
            "x,t_s\n3,2\n",
        ] {
            let curve = parse(text, [None; 2]).unwrap_or_else(|error| panic!("{text}: {error}"));
            assert_eq!(curve.points, [(1.0, 5.0)], "{text}");
        }
    }

    #[test]
    fn what_is_wrong_with_a_file_is_said_with_its_line() {
        for (text, time, value, expected) in [
            ("", None, None, "f.csv:1: there is no line"),
            ("T,Z\n", None, None, "no row"),
            ("T,Z\n0,1\n1,x\n", None, None, "f.csv:3: `x` in column `Z`"),
            (
                "T,Z\n0\n",
                None,
                None,
                "f.csv:2: there is no figure in column `Z`",
            ),
            (
                "T,Z\n0,1\n",
                Some("t"),
                None,
                "no column `t`; the columns are T, Z",
            ),
            ("T\n0\n", None, None, "there is no column beside the times"),
            ("x,y\n0,1\n", None, None, "f.csv:1: no column is called `t`"),
            (
                "t,T,y\n0,1,2\n",
                None,
                None,
                "more than one column is called",
            ),
            (
                "t,x,y\n0,1,2\n",
                None,
                None,
                "`value: \"…\"` (columns: t, x, y)",
            ),
            (
                "t,x,x\n0,1,2\n",
                None,
                Some("x"),
                "`x` is there twice, as column 2 and 3",
            ),
            ("t;x\n0;1\n", None, None, "separated by ';'; write commas"),
            ("0,1\n2,3\n", None, None, "no line with the names"),
            ("t,x\n0,1,2\n", None, None, "3 figures for 2 columns"),
        ] {
            let error = parse(text, [time, value]);
            let error = error.expect_err(text).to_string();
            assert!(error.contains(expected), "{text}: {error}");
        }
    }
}
