//! A checked study: the scenes that it runs.

use super::{Reference, Rows, Span, Study};
use crate::scene::Scene;

/// A study with everything it names read and checked.
#[derive(Debug, Clone)]
pub struct Plan {
    /// The study as in its file.
    pub study: Study,
    /// The scenes to run, by case.
    pub cases: Vec<PlannedCase>,
    /// Figures to compare with; empty if the study names no file.
    pub reference: Reference,
}

/// A case, ready to run.
#[derive(Debug, Clone)]
pub struct PlannedCase {
    /// Its name; empty if the study has no cases.
    pub name: String,
    /// The scene that leads to the start, and the simulated time at which it stops \[s].
    pub start: Option<(Scene, f32)>,
    /// Length of one measurement.
    pub block: Span,
    /// All variants.
    pub variants: Vec<PlannedVariant>,
}

/// A variant of a case, ready to run.
#[derive(Debug, Clone)]
pub struct PlannedVariant {
    /// Its name.
    pub name: String,
    /// The scene with all overrides applied.
    pub scene: Scene,
    /// Order of its rows at the start.
    pub rows: Rows,
    /// Threads that it runs on; those of the study if absent.
    pub threads: Option<u32>,
    /// Name of its row in the reference file.
    pub reference: Option<String>,
    /// Variants of one series are connected in the chart.
    pub series: Option<String>,
}
