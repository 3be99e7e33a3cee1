//! The types of a study file; their fields are exactly those of the file.

use serde::{Deserialize, Serialize};

use super::Measure;

/// A whole study, as in its RON file. Every field except `name`, `scene`, `variants`, `block` and `columns` has a
/// default.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Study {
    /// Name of the output folder.
    pub name: String,
    /// Heading of the table and the chart; the name if absent.
    #[serde(default)]
    pub title: Option<String>,
    /// Remarks for the reader of the table, printed below it.
    #[serde(default)]
    pub notes: Vec<String>,
    /// The scene file, relative to the study's folder.
    pub scene: String,
    /// Overrides for all scenes, each in the form of `--set`.
    #[serde(default)]
    pub set: Vec<String>,
    /// The state in which the variants of a case start; by default the beginning of the scene.
    #[serde(default)]
    pub start: Option<Start>,
    /// Scenes that all variants run in; if there are none, the study's scene, without a name.
    #[serde(default)]
    pub cases: Vec<Case>,
    /// The variants to compare.
    pub variants: Vec<Variant>,
    /// What a variant simulates before it is measured.
    #[serde(default = "default_warm_up")]
    pub warm_up: Span,
    /// Length of one measurement. The variants of a case take turns, one block each.
    pub block: Span,
    /// Number of turns; 5 by default.
    #[serde(default = "default_blocks")]
    pub blocks: u32,
    /// The quantities to measure.
    pub columns: Vec<Column>,
    /// A CSV file with figures to compare with, relative to the study's folder: comment lines, which begin with `#`,
    /// then a line of column names, then one line per row. Its first column names the row.
    #[serde(default)]
    pub reference: Option<String>,
    /// The variant whose figures ratios are relative to, within each case; the first if absent.
    #[serde(default)]
    pub baseline: Option<String>,
    /// The picture; none if absent.
    #[serde(default)]
    pub chart: Option<Chart>,
}

/// A state that is simulated once per case and given to all its variants.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Start {
    /// Simulated time of the state \[s].
    pub time: f32,
    /// Overrides for the simulation that leads to it.
    #[serde(default)]
    pub set: Vec<String>,
}

/// A scene that all variants run in.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Case {
    /// Its name in the table.
    pub name: String,
    /// Overrides, applied after the study's.
    #[serde(default)]
    pub set: Vec<String>,
    /// Replaces the study's start.
    #[serde(default)]
    pub start: Option<Start>,
    /// Replaces the study's block.
    #[serde(default)]
    pub block: Option<Span>,
    /// The part before a comma in the names of this case's rows in the reference file.
    #[serde(default)]
    pub reference: Option<String>,
}

/// A variant to compare.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Variant {
    /// Its name in the table.
    pub name: String,
    /// Overrides, applied after the study's and the case's.
    #[serde(default)]
    pub set: Vec<String>,
    /// Order of its rows at the start.
    #[serde(default)]
    pub rows: Rows,
    /// Its row in the reference file.
    #[serde(default)]
    pub reference: Option<String>,
    /// Variants of one series have one colour in the chart and are connected by a line.
    #[serde(default)]
    pub series: Option<String>,
}

/// Order of a variant's rows at the start. A variant that reorders (`reorder_interval` above 0) does so at once.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
pub enum Rows {
    /// The order of creation, which is the order of the bodies' lattice; the particles may have moved since, if the
    /// start does not reorder.
    #[default]
    Kept,
    /// Random order: consecutive rows are not neighbours. Without reordering, every order ends up like this.
    Shuffled,
}

/// Length of a simulation.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub enum Span {
    /// A number of steps.
    Steps(u64),
    /// Simulated time \[s]. The simulation runs to the end of the step that reaches it, so that no step is shortened.
    Time(f32),
}

/// A column of the table.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Column {
    /// Its heading.
    pub name: String,
    /// The quantity that it shows.
    pub measure: Measure,
    /// The column of the reference file to compare with.
    #[serde(default)]
    pub reference: Option<String>,
}

/// A picture of the table.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub enum Chart {
    /// Ratios to the baseline as bars, ours beside the reference's: one panel for each of these columns.
    Ratios {
        /// Names of columns.
        columns: Vec<String>,
    },
    /// One point per row, one column over another, both axes logarithmic: one panel for each of the columns `y`.
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
    /// What is wrong with a measure in this study.
    pub(super) fn refusal_of(&self, measure: &Measure) -> Option<&'static str> {
        let starts = self.start.is_some() || self.cases.iter().any(|case| case.start.is_some());
        match measure {
            Measure::Milliseconds(phases) | Measure::Share(phases) if phases.is_empty() => {
                Some("no phase; name one, such as `find_neighbours`")
            }
            Measure::Distance if !starts => Some(
                "variants number their particles alike only from a common `start`; give the study one",
            ),
            _ => None,
        }
    }

    /// Heading of the table and the chart.
    pub fn title(&self) -> &str {
        self.title.as_deref().unwrap_or(&self.name)
    }
}

/// Whether a text is that of a study, right or wrong.
#[doc(hidden)]
pub fn is_study(text: &str) -> bool {
    #[cfg(feature = "cli")]
    if crate::loading::read::<super::stability::StabilityStudy>(text, "").is_ok() {
        return true;
    }
    crate::loading::read::<Study>(text, "").is_ok()
}
