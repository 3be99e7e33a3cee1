//! The table for a terminal: a separate part for each column with reference figures, one part for all others.

use std::fmt::Write as _;

use super::{Order, Table};

impl Table {
    /// The table as text: the measured figures, the reference beside them, and where the order of the rows differs.
    pub fn text(&self) -> String {
        let mut text = format!("{}\n", self.title);
        let compared: Vec<usize> = self.columns_where(|column| self.has_reference(column));
        let others: Vec<usize> = self.columns_where(|column| !self.has_reference(column));
        let mut first = 0;
        while first < self.rows.len() {
            let case = &self.rows[first].case;
            let rows = self.rows[first..]
                .iter()
                .take_while(|row| row.case == *case);
            let rows = first..first + rows.count();
            if !case.is_empty() {
                let _ = write!(text, "\n{case}\n");
            }
            for &column in &compared {
                if rows
                    .clone()
                    .any(|row| self.reference(row, column).is_some())
                {
                    self.compare(&mut text, rows.clone(), column);
                }
            }
            // Columns without a reference figure for this case are listed with those that have none at all.
            let plain: Vec<usize> = (others.iter().chain(&compared).copied())
                .filter(|&column| {
                    rows.clone()
                        .all(|row| self.reference(row, column).is_none())
                })
                .collect();
            if !plain.is_empty() {
                self.list(&mut text, rows.clone(), &plain);
            }
            first = rows.end;
        }
        for row in self.rows.iter() {
            if let Some(failure) = &row.failure {
                let _ = write!(text, "\n{} failed: {failure}\n", row.label());
            }
        }
        if !compared.is_empty() {
            let _ = write!(
                text,
                "\n×: ratio to `{}`. Ranks go from the smallest figure. ≠: the order is not the reference's;\n\
                 ~: nor is it there, but the spreads of the blocks overlap.\n",
                self.baseline()
            );
        }
        self.scaling(&mut text);
        for note in &self.notes {
            let _ = writeln!(text, "{note}");
        }
        text
    }

    /// What Amdahl's law says of the variants that differ in their threads.
    fn scaling(&self, text: &mut String) {
        for column in 0..self.columns.len() {
            for scaling in self.scalings(column) {
                let Some(share) = scaling.serial_share else {
                    continue;
                };
                let _ = writeln!(
                    text,
                    "{}, {}: {:.1} % serial by Amdahl's law, so at most {:.1} times as fast",
                    self.columns[column].name,
                    scaling.series,
                    100.0 * share,
                    1.0 / share.max(1e-3)
                );
            }
        }
    }

    fn columns_where(&self, holds: impl Fn(usize) -> bool) -> Vec<usize> {
        (0..self.columns.len())
            .filter(|&column| holds(column))
            .collect()
    }

    fn width(&self) -> usize {
        let widths = self.rows.iter().map(|row| row.variant.chars().count());
        widths.max().unwrap_or(0).max(12)
    }

    fn heading(&self, column: usize) -> String {
        let column = &self.columns[column];
        match column.measure.unit() {
            "" => column.name.clone(),
            unit => format!("{} [{unit}]", column.name),
        }
    }

    /// One column beside its reference.
    fn compare(&self, text: &mut String, rows: std::ops::Range<usize>, column: usize) {
        let width = self.width();
        let _ = write!(
            text,
            "\n{:<width$}  {:>8} {:>17} {:>6}  {:>9} {:>6}  rank, reference's\n",
            self.heading(column),
            "here",
            "spread",
            "×",
            "reference",
            "×"
        );
        for row in rows {
            let known = |value: Option<f64>| value.map_or_else(|| "-".into(), short);
            let ratio =
                |value: Option<f64>| value.map_or_else(|| "-".into(), |v| format!("{v:.2}"));
            let figure = self.figure(row, column);
            let spread = figure.map_or_else(String::new, |figure| {
                format!("{} – {}", short(figure.low), short(figure.high))
            });
            let ranks = self
                .ranks(row, column)
                .map_or_else(String::new, |(rank, reference)| {
                    let mark = match self.order(row, column) {
                        Some(Order::Differs) => " ≠",
                        Some(Order::Unresolved) => " ~",
                        _ => "",
                    };
                    format!("{rank:>4}, {reference}{mark}")
                });
            let line = format!(
                "{:<width$}  {:>8} {spread:>17} {:>6}  {:>9} {:>6}  {ranks}",
                self.rows[row].variant,
                known(figure.map(|figure| figure.value)),
                ratio(self.ratio(row, column)),
                known(self.reference(row, column)),
                ratio(self.reference_ratio(row, column)),
            );
            let _ = writeln!(text, "{}", line.trim_end());
        }
    }

    /// Columns without a reference, side by side.
    fn list(&self, text: &mut String, rows: std::ops::Range<usize>, columns: &[usize]) {
        let width = self.width();
        let headings: Vec<String> = columns.iter().map(|&column| self.heading(column)).collect();
        let widths: Vec<usize> = headings
            .iter()
            .map(|name| name.chars().count().max(9))
            .collect();
        let _ = write!(text, "\n{:<width$}", "");
        for (heading, width) in headings.iter().zip(&widths) {
            let _ = write!(text, "  {heading:>width$}");
        }
        text.push('\n');
        for row in rows {
            let _ = write!(text, "{:<width$}", self.rows[row].variant);
            for (&column, width) in columns.iter().zip(&widths) {
                let figure = self.figure(row, column);
                let value = figure.map_or_else(|| "-".into(), |figure| short(figure.value));
                let _ = write!(text, "  {value:>width$}");
            }
            text.push('\n');
        }
    }
}

impl super::Row {
    /// Case and variant.
    pub fn label(&self) -> String {
        match self.case.as_str() {
            "" => self.variant.clone(),
            case => format!("{case}, {}", self.variant),
        }
    }
}

/// A figure with three or four digits.
pub(crate) fn short(value: f64) -> String {
    match value.abs() {
        0.0 => "0".into(),
        size if size >= 1e6 => format!("{:.2} M", value / 1e6),
        size if size >= 1e3 => format!("{value:.0}"),
        size if size >= 100.0 => format!("{value:.1}"),
        size if size >= 1.0 => format!("{value:.2}"),
        size if size >= 1e-3 => format!("{value:.4}"),
        _ => format!("{value:.2e}"),
    }
}

#[cfg(test)]
mod tests {
    use super::short;

    #[test]
    fn figures_keep_three_digits() {
        for (value, expected) in [
            (0.0, "0"),
            (3_612_345.0, "3.61 M"),
            (12_345.6, "12346"),
            (123.45, "123.5"),
            (12.345, "12.35"),
            (0.012_345, "0.0123"),
            (1.234e-5, "1.23e-5"),
        ] {
            assert_eq!(short(value), expected);
        }
    }
}
