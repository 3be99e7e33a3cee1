//! The types of a frontier study's file; their fields are exactly those of the file.

use serde::{Deserialize, Serialize};

use crate::study::stability::Axis;

/// A study of speed against error, over settings of a scene whose answer is known. Every field except `kind`, `name`,
/// `truth` and `variants` has a default.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct FrontierStudy {
    /// Says that this is such a study.
    pub kind: FrontierKind,
    /// Name of the output folder.
    pub name: String,
    /// Heading of the chart; the name if absent.
    #[serde(default)]
    pub title: Option<String>,
    /// Remarks for the reader, printed below the results.
    #[serde(default)]
    pub notes: Vec<String>,
    /// What runs are compared with.
    pub truth: Truth,
    /// Overrides for all points, each in the form of `--set`.
    #[serde(default)]
    pub set: Vec<String>,
    /// What is compared: one colour each.
    pub variants: Vec<FrontierVariant>,
    /// Values that are swept in all variants, each with all of the others.
    #[serde(default)]
    pub grid: Vec<Axis>,
    /// Runs of each point: their errors are the same, their times are not.
    #[serde(default = "default_repeats")]
    pub repeats: u32,
    /// Wall time after which a run is given up \[s].
    #[serde(default = "default_seconds")]
    pub seconds: f64,
}

/// Marks the file of a frontier study.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum FrontierKind {
    /// Wall time over error.
    Frontier,
}

/// What runs are compared with.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub enum Truth {
    /// Known values of a case of `overfall validate`.
    Case {
        /// Name of the case.
        name: String,
        /// Its figures whose errors are shown, one panel each.
        figures: Vec<String>,
    },
    /// A fine run of the scene itself, which is made first.
    Fine {
        /// The scene file, relative to the study's folder.
        scene: String,
        /// Overrides that make it fine.
        set: Vec<String>,
        /// Gauges of the scene whose curves are compared, one panel each.
        gauges: Vec<GaugeColumn>,
    },
}

/// A column of a gauge.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct GaugeColumn {
    /// Name of the gauge.
    pub gauge: String,
    /// The column; its first if absent.
    #[serde(default)]
    pub column: Option<String>,
}

/// Settings that are compared with others.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct FrontierVariant {
    /// Its name.
    pub name: String,
    /// Overrides, applied after the study's.
    #[serde(default)]
    pub set: Vec<String>,
    /// Values that are swept in this variant, beside the study's.
    #[serde(default)]
    pub grid: Vec<Axis>,
}

fn default_repeats() -> u32 {
    3
}

fn default_seconds() -> f64 {
    120.0
}

impl FrontierStudy {
    /// Heading of the chart.
    pub fn title(&self) -> &str {
        self.title.as_deref().unwrap_or(&self.name)
    }

    /// What each panel shows the error of.
    pub fn measures(&self) -> Vec<String> {
        match &self.truth {
            Truth::Case { figures, .. } => figures.clone(),
            Truth::Fine { gauges, .. } => gauges.iter().map(GaugeColumn::label).collect(),
        }
    }
}

impl GaugeColumn {
    /// What it is called in results.
    pub fn label(&self) -> String {
        match &self.column {
            Some(column) => format!("{}, {column}", self.gauge),
            None => self.gauge.clone(),
        }
    }
}

/// Whether a text is that of a frontier study, right or wrong.
#[doc(hidden)]
pub fn is_frontier(text: &str) -> bool {
    crate::loading::read::<FrontierStudy>(text, "").is_ok()
}
