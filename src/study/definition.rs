//! The types of a study file, exactly its fields.

use serde::{Deserialize, Serialize};

use super::Measure;

/// A whole study, as its RON file gives it. Every field but `name`, `scene`, `variants`, `block` and `columns` has a
/// default.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Study {
    /// Names the output folder.
    pub name: String,
    /// Heading of the table and the chart; the name if absent.
    #[serde(default)]
    pub title: Option<String>,
    /// What a reader of the table should know, printed below it.
    #[serde(default)]
    pub notes: Vec<String>,
    /// The scene file, relative to the study's folder.
    pub scene: String,
    /// Overrides for all, each as `--set` takes it.
    #[serde(default)]
    pub set: Vec<String>,
    /// Where the variants of a case set out from; from the scene's beginning if absent.
    #[serde(default)]
    pub start: Option<Start>,
    /// Scenes that all variants are run in; one, without a name, if there are none.
    #[serde(default)]
    pub cases: Vec<Case>,
    /// What is compared.
    pub variants: Vec<Variant>,
    /// What a variant goes through before it is measured.
    #[serde(default = "default_warm_up")]
    pub warm_up: Span,
    /// One measurement. The variants of a case take turns, a block each.
    pub block: Span,
    /// Turns; 5 by default.
    #[serde(default = "default_blocks")]
    pub blocks: u32,
    /// What is measured.
    pub columns: Vec<Column>,
    /// A CSV file with figures to compare with, relative to the study's folder: lines of comment, which begin with
    /// `#`, names of columns, then one line a row. Its first column names the row.
    #[serde(default)]
    pub reference: Option<String>,
    /// The variant that ratios are taken to, within each case; the first if absent.
    #[serde(default)]
    pub baseline: Option<String>,
    /// The picture; none if absent.
    #[serde(default)]
    pub chart: Option<Chart>,
}

/// A state that is simulated once for a case and handed to all its variants.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Start {
    /// Simulated time that it is taken at \[s].
    pub time: f32,
    /// Overrides for the simulation that leads there.
    #[serde(default)]
    pub set: Vec<String>,
}

/// A scene that all variants are run in.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Case {
    /// Its name in the table.
    pub name: String,
    /// Overrides, after the study's.
    #[serde(default)]
    pub set: Vec<String>,
    /// In place of the study's start.
    #[serde(default)]
    pub start: Option<Start>,
    /// In place of the study's block.
    #[serde(default)]
    pub block: Option<Span>,
    /// What the rows of the reference file that belong to this case begin with, before a comma.
    #[serde(default)]
    pub reference: Option<String>,
}

/// Something to compare.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Variant {
    /// Its name in the table.
    pub name: String,
    /// Overrides, after the study's and the case's.
    #[serde(default)]
    pub set: Vec<String>,
    /// How its rows lie at the start.
    #[serde(default)]
    pub rows: Rows,
    /// Its row in the reference file.
    #[serde(default)]
    pub reference: Option<String>,
    /// Variants of one series have one colour in the chart and are joined by a line.
    #[serde(default)]
    pub series: Option<String>,
}

/// How the rows of a variant lie at the start. A variant that reorders (`reorder_interval` above 0) reorders them then.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
pub enum Rows {
    /// As they were created: by the lattice of the bodies if the start never reorders, whatever has become of it by
    /// the particles' motion.
    #[default]
    Kept,
    /// In random order: no two rows that follow each other are neighbours. What any order comes to in the end.
    Shuffled,
}

/// How far to go.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub enum Span {
    /// So many steps.
    Steps(u64),
    /// Simulated time \[s], and on to the end of the step that reaches it: what is measured is no shortened step.
    Time(f32),
}

/// A column of the table.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Column {
    /// Its heading.
    pub name: String,
    /// What it shows.
    pub measure: Measure,
    /// The column of the reference file to compare with.
    #[serde(default)]
    pub reference: Option<String>,
}

/// A picture of the table.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub enum Chart {
    /// Ratios to the baseline as bars, ours beside the reference: a panel for each of these columns.
    Ratios {
        /// Names of columns.
        columns: Vec<String>,
    },
    /// A point a row, one column against another, both on logarithmic axes: a panel for each of the columns `y`.
    Points {
        /// Name of the column along the horizontal axis.
        x: String,
        /// Names of the columns along the vertical axes.
        y: Vec<String>,
    },
}

fn default_warm_up() -> Span {
    Span::Steps(3)
}

fn default_blocks() -> u32 {
    5
}

impl Study {
    /// Heading of the table and the chart.
    pub fn title(&self) -> &str {
        self.title.as_deref().unwrap_or(&self.name)
    }
}
