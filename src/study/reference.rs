//! Figures to compare with: a CSV file with comments, a line of column names, and a name at the start of every row.

use std::collections::BTreeMap;

use crate::input::without_mark;

/// Figures by row and column.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Reference {
    /// Names of the columns, without the first, which holds the rows' names.
    pub columns: Vec<String>,
    rows: BTreeMap<String, Vec<Option<f64>>>,
}

impl Reference {
    /// Parses the text of a file. An error is the line, counted from 1, and the mistake in it.
    ///
    /// The name of a row may be in double quotes, and must be if it contains a comma. A figure may be omitted.
    pub fn parse(text: &str) -> Result<Self, (usize, String)> {
        let mut lines = (1..)
            .zip(without_mark(text).lines())
            .filter(|(_, line)| !line.trim().is_empty() && !line.starts_with('#'));
        let Some((number, header)) = lines.next() else {
            return Err((1, "there is no line with the names of the columns".into()));
        };
        let columns: Vec<String> = header
            .split(',')
            .skip(1)
            .map(|name| name.trim().to_owned())
            .collect();
        let twice = (1..columns.len()).find(|&k| columns[..k].contains(&columns[k]));
        if let Some(twice) = twice {
            let message = format!("the column `{}` is there twice; keep one", columns[twice]);
            return Err((number, message));
        }
        let mut rows = BTreeMap::new();
        for (number, line) in lines {
            let (name, figures) = split_name(line)
                .ok_or_else(|| (number, "expected a name, a comma and figures".to_owned()))?;
            let figures = figures
                .split(',')
                .map(|figure| match figure.trim() {
                    "" => Ok(None),
                    text => text
                        .parse()
                        .map(Some)
                        .map_err(|_| (number, format!("`{text}` is not a number"))),
                })
                .collect::<Result<Vec<_>, _>>()?;
            if figures.len() != columns.len() {
                let message = format!(
                    "{} figures for {} columns; leave a figure out as `,,`",
                    figures.len(),
                    columns.len()
                );
                return Err((number, message));
            }
            if rows.insert(name.to_owned(), figures).is_some() {
                return Err((number, format!("the row `{name}` is given twice")));
            }
        }
        Ok(Self { columns, rows })
    }

    /// Names of the rows.
    pub fn rows(&self) -> Vec<&str> {
        self.rows.keys().map(String::as_str).collect()
    }

    /// The figure in a row and a column.
    pub fn figure(&self, row: &str, column: &str) -> Option<f64> {
        let column = self.columns.iter().position(|name| name == column)?;
        self.rows.get(row)?[column]
    }
}

fn split_name(line: &str) -> Option<(&str, &str)> {
    match line.strip_prefix('"') {
        Some(rest) => {
            let (name, rest) = rest.split_once('"')?;
            Some((name, rest.strip_prefix(',')?))
        }
        None => line.split_once(','),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn figures_are_found_by_row_and_column() {
        let text = "# a comment, with a comma\nrow,a,b\none,1.5,\n\"two, three\",2,3e1\n";
        let reference = Reference::parse(text).expect("figures");
        assert_eq!(reference.columns, ["a", "b"]);
        assert_eq!(reference.rows(), ["one", "two, three"]);
        assert_eq!(reference.figure("one", "a"), Some(1.5));
        assert_eq!(reference.figure("one", "b"), None);
        assert_eq!(reference.figure("two, three", "b"), Some(30.0));
        assert_eq!(reference.figure("three", "b"), None);
        assert_eq!(reference.figure("one", "c"), None);
    }

    #[test]
    fn a_wrong_line_is_named() {
        for (text, line) in [
            ("# nothing\n", 1),
            ("row,a\n\none\n", 3),
            ("# two\nrow,a,a\none,1,2\n", 2),
            ("row,a\none,x\n", 2),
            ("row,a\none,1,2\n", 2),
            ("row,a\none,1\none,2\n", 3),
        ] {
            assert_eq!(
                Reference::parse(text).map_err(|error| error.0),
                Err(line),
                "{text}"
            );
        }
    }
}
