//! Results of a study: figures, ratios to a baseline and ranks, and the same for the reference figures.

use std::cmp::Ordering;
use std::fmt::Write as _;
use std::path::Path;

use super::{Block, Column, Plan, PlannedCase, PlannedVariant, Reference};
use crate::output::{OutputError, write_atomically};

/// All rows and columns.
#[derive(Debug, Clone)]
pub struct Table {
    /// Heading.
    pub title: String,
    /// Remarks for the reader.
    pub notes: Vec<String>,
    /// The columns, as in the study file.
    pub columns: Vec<Column>,
    /// The rows: the variants of the first case, then those of the next.
    pub rows: Vec<Row>,
    baseline: String,
    reference: Reference,
}

/// A variant of a case.
#[derive(Debug, Clone, Default)]
pub struct Row {
    /// Name of the case; empty if the study has none.
    pub case: String,
    /// Name of the variant.
    pub variant: String,
    /// Its row in the reference file.
    pub reference: Option<String>,
    /// Rows of one series are connected in the chart.
    pub series: Option<String>,
    /// Threads that it runs on, if the study says.
    pub threads: Option<u32>,
    /// The measured blocks.
    pub blocks: Vec<Block>,
    /// Reason why it ended early.
    pub failure: Option<String>,
}

/// A measured figure, in the unit of its measure.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Figure {
    /// Median over the blocks for times; otherwise computed from all blocks together.
    pub value: f64,
    /// Least of all blocks.
    pub low: f64,
    /// Greatest of all blocks.
    pub high: f64,
}

/// Whether a row has the same order relative to the other rows of its case as in the reference.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Order {
    /// Every other row is on the same side as in the reference.
    Same,
    /// A row is on the other side, but the spreads of the blocks overlap: it may be noise.
    Unresolved,
    /// A row is on the other side, beyond the spread.
    Differs,
}

impl Order {
    /// Its name in the CSV file.
    pub fn name(self) -> &'static str {
        match self {
            Self::Same => "same",
            Self::Unresolved => "unresolved",
            Self::Differs => "differs",
        }
    }
}

impl Table {
    /// A table without measurements yet.
    pub(super) fn new(plan: &Plan) -> Self {
        let study = &plan.study;
        let rows = plan
            .cases
            .iter()
            .flat_map(|case| (case.variants.iter()).map(|variant| Row::new(case, variant)));
        Self {
            title: study.title().to_owned(),
            notes: study.notes.clone(),
            columns: study.columns.clone(),
            rows: rows.collect(),
            baseline: study
                .baseline
                .clone()
                .unwrap_or_else(|| study.variants[0].name.clone()),
            reference: plan.reference.clone(),
        }
    }

    /// The variant whose figures ratios are relative to.
    pub fn baseline(&self) -> &str {
        &self.baseline
    }

    /// Index of the column called `name`.
    pub fn column(&self, name: &str) -> Option<usize> {
        self.columns.iter().position(|column| column.name == name)
    }

    /// The measured figure; `None` before the first block.
    pub fn figure(&self, row: usize, column: usize) -> Option<Figure> {
        let measure = &self.columns[column].measure;
        let blocks = &self.rows[row].blocks;
        let mut values: Vec<f64> = blocks
            .iter()
            .filter_map(|block| measure.of(block))
            .collect();
        values.sort_by(f64::total_cmp);
        let (&low, &high) = (values.first()?, values.last()?);
        let middle = values.len() / 2;
        let value = if !measure.is_median() {
            measure.of(&Block::together(blocks))?
        } else if values.len() % 2 == 1 {
            values[middle]
        } else {
            0.5 * (values[middle - 1] + values[middle])
        };
        Some(Figure { value, low, high })
    }

    /// The reference figure.
    pub fn reference(&self, row: usize, column: usize) -> Option<f64> {
        let (row, column) = (&self.rows[row].reference, &self.columns[column].reference);
        self.reference.figure(row.as_ref()?, column.as_ref()?)
    }

    /// Whether a column has reference figures.
    pub fn has_reference(&self, column: usize) -> bool {
        (0..self.rows.len()).any(|row| self.reference(row, column).is_some())
    }

    /// The figure divided by that of the baseline in the same case.
    pub fn ratio(&self, row: usize, column: usize) -> Option<f64> {
        let base = self.figure(self.baseline_of(row)?, column)?;
        finite(self.figure(row, column)?.value / base.value)
    }

    /// The reference figure divided by that of the baseline.
    pub fn reference_ratio(&self, row: usize, column: usize) -> Option<f64> {
        let base = self.reference(self.baseline_of(row)?, column)?;
        finite(self.reference(row, column)? / base)
    }

    fn baseline_of(&self, row: usize) -> Option<usize> {
        let case = &self.rows[row].case;
        (self.rows.iter()).position(|row| row.case == *case && row.variant == self.baseline)
    }

    /// Measured and reference figures of the rows of the same case that have both.
    fn comparable(&self, row: usize, column: usize) -> Vec<(Figure, f64)> {
        (0..self.rows.len())
            .filter(|&other| self.rows[other].case == self.rows[row].case)
            .filter_map(|other| {
                self.figure(other, column)
                    .zip(self.reference(other, column))
            })
            .collect()
    }

    /// Ranks of a row among the comparable rows of its case, counted from 1 for the smallest figure: measured, and in
    /// the reference.
    pub fn ranks(&self, row: usize, column: usize) -> Option<(usize, usize)> {
        let own = self.figure(row, column)?.value;
        let own_reference = self.reference(row, column)?;
        let others = self.comparable(row, column);
        let rank = |smaller: &dyn Fn(&(Figure, f64)) -> bool| {
            1 + others.iter().filter(|other| smaller(other)).count()
        };
        // Figures that agree to three digits are equal.
        Some((
            rank(&|other| other.0.value < 0.9995 * own),
            rank(&|other| other.1 < own_reference),
        ))
    }

    /// Whether the row has the same order relative to the other rows as in the reference.
    pub fn order(&self, row: usize, column: usize) -> Option<Order> {
        let own = self.figure(row, column)?;
        let own_reference = self.reference(row, column)?;
        let mut order = Order::Same;
        for (figure, reference) in self.comparable(row, column) {
            let expected = own_reference.total_cmp(&reference);
            if expected == Ordering::Equal || own.value.total_cmp(&figure.value) == expected {
                continue;
            }
            if own.low > figure.high || own.high < figure.low {
                return Some(Order::Differs);
            }
            order = Order::Unresolved;
        }
        Some(order)
    }

    /// One line per figure: case, variant, column, its unit, the figure, its spread over the blocks, and its rank.
    ///
    /// Unknown values are left empty.
    pub fn csv(&self) -> String {
        let mut text = String::from(
            "case,variant,column,unit,value,low,high,ratio,reference,reference_ratio,rank,reference_rank,order,blocks,\
             steps,failure\n",
        );
        let number = |value: Option<f64>| value.map_or_else(String::new, |value| value.to_string());
        for (k, row) in self.rows.iter().enumerate() {
            if row.blocks.is_empty() && row.failure.is_none() {
                continue;
            }
            for (c, column) in self.columns.iter().enumerate() {
                let figure = self.figure(k, c);
                let ranks = self.ranks(k, c);
                let rank =
                    |rank: Option<usize>| rank.map_or_else(String::new, |rank| rank.to_string());
                // Writing to a String cannot fail.
                let _ = writeln!(
                    text,
                    "{},{},{},{},{},{},{},{},{},{},{},{},{},{},{},{}",
                    field(&row.case),
                    field(&row.variant),
                    field(&column.name),
                    column.measure.unit(),
                    number(figure.map(|figure| figure.value)),
                    number(figure.map(|figure| figure.low)),
                    number(figure.map(|figure| figure.high)),
                    number(self.ratio(k, c)),
                    number(self.reference(k, c)),
                    number(self.reference_ratio(k, c)),
                    rank(ranks.map(|ranks| ranks.0)),
                    rank(ranks.map(|ranks| ranks.1)),
                    self.order(k, c).map_or("", Order::name),
                    row.blocks.len(),
                    row.steps(),
                    field(row.failure.as_deref().unwrap_or("")),
                );
            }
        }
        text
    }

    /// Writes the CSV file, completely or not at all.
    pub fn write_csv(&self, path: &Path) -> Result<(), OutputError> {
        use std::io::Write as _;
        write_atomically(path, |out| out.write_all(self.csv().as_bytes()))
    }
}

impl Row {
    /// A row without measurements yet.
    fn new(case: &PlannedCase, variant: &PlannedVariant) -> Self {
        Self {
            case: case.name.clone(),
            variant: variant.name.clone(),
            reference: variant.reference.clone(),
            series: variant.series.clone(),
            threads: variant.threads,
            ..Self::default()
        }
    }

    /// Number of measured steps.
    pub fn steps(&self) -> u64 {
        self.blocks.iter().map(|block| block.steps).sum()
    }
}

fn finite(value: f64) -> Option<f64> {
    value.is_finite().then_some(value)
}

/// A text as a field of a CSV file (RFC 4180).
fn field(text: &str) -> String {
    if text.contains([',', '"', '\n', '\r']) {
        format!("\"{}\"", text.replace('"', "\"\""))
    } else {
        text.to_owned()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::state::Phase;
    use crate::study::Measure;

    /// Three variants with the given milliseconds of the blocks, and the figures to compare with.
    fn table(rows: [&[f64]; 3], reference: [f64; 3]) -> Table {
        let names = ["a", "b", "c"];
        let text = format!(
            "row,ms\na,{}\nb,{}\nc,{}\n",
            reference[0], reference[1], reference[2]
        );
        let block = |&ms: &f64| {
            let mut block = Block {
                steps: 10,
                ..Block::default()
            };
            block.phase_seconds[Phase::FindNeighbours as usize] = 10.0 * ms / 1e3;
            block
        };
        Table {
            title: "T".into(),
            notes: Vec::new(),
            columns: vec![Column {
                name: "query".into(),
                measure: Measure::Milliseconds(vec![Phase::FindNeighbours]),
                reference: Some("ms".into()),
            }],
            rows: (names.iter().zip(rows))
                .map(|(name, blocks)| Row {
                    variant: (*name).into(),
                    reference: Some((*name).into()),
                    blocks: blocks.iter().map(block).collect(),
                    ..Row::default()
                })
                .collect(),
            baseline: "b".into(),
            reference: Reference::parse(&text).expect("figures"),
        }
    }

    #[test]
    fn the_median_stands_for_a_row_and_ratios_are_to_the_baseline() {
        let table = table(
            [&[1.0, 9.0, 2.0], &[4.0, 4.0, 4.0], &[8.0, 6.0]],
            [1.0, 2.0, 3.0],
        );
        let figure = table.figure(0, 0).expect("measured");
        for (found, expected) in [(figure.value, 2.0), (figure.low, 1.0), (figure.high, 9.0)] {
            assert!((found - expected).abs() < 1e-12);
        }
        assert!((table.figure(2, 0).expect("measured").value - 7.0).abs() < 1e-12);
        assert!((table.ratio(0, 0).expect("measured") - 0.5).abs() < 1e-12);
        assert_eq!(table.reference_ratio(2, 0), Some(1.5));
    }

    #[test]
    fn an_order_differs_only_beyond_the_spread() {
        // Here a < b < c; the reference says b < a < c.
        let clear = table([&[1.0, 1.2], &[2.0, 2.2], &[3.0, 3.3]], [2.0, 1.0, 3.0]);
        let orders = |table: &Table| [0, 1, 2].map(|row| table.order(row, 0).expect("measured"));
        assert_eq!(
            orders(&clear),
            [Order::Differs, Order::Differs, Order::Same]
        );
        assert_eq!(clear.ranks(0, 0), Some((1, 2)));
        assert_eq!(clear.ranks(1, 0), Some((2, 1)));
        let noisy = table([&[1.0, 2.1], &[2.0, 2.2], &[3.0, 3.3]], [2.0, 1.0, 3.0]);
        assert_eq!(
            orders(&noisy),
            [Order::Unresolved, Order::Unresolved, Order::Same]
        );
    }

    #[test]
    fn a_row_without_blocks_has_no_figures_and_no_place() {
        let table = table([&[], &[2.0], &[3.0]], [2.0, 1.0, 3.0]);
        assert_eq!(table.figure(0, 0), None);
        assert_eq!(table.order(0, 0), None);
        assert_eq!(table.ranks(2, 0), Some((2, 2)));
        assert_eq!(table.csv().lines().count(), 3);
    }

    #[test]
    fn fields_with_commas_are_quoted() {
        assert_eq!(field("a"), "a");
        assert_eq!(field("a, \"b\""), "\"a, \"\"b\"\"\"");
    }
}
