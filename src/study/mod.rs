//! Studies: variants of a scene, measured side by side.
//!
//! A study is a RON file: a scene, variants of it ([`Override`](crate::loading::Override)s), what to measure and
//! figures to compare with. `Study::load` reads and checks it, [`run()`] runs it, a [`Table`] says what came of it, as
//! text and as CSV; `chart::draw` makes a picture of it (feature `cli`).
//!
//! | file | what is in it |
//! | --- | --- |
//! | `definition` | the types of the file, exactly its fields |
//! | `check` | the file and all it names, made into [`Plan`] before anything runs |
//! | `reference` | figures to compare with, from a CSV file |
//! | `start` | the state that the variants of a case set out from |
//! | `run` | the variants, block by block in turn |
//! | `measure` | what a block of steps is measured by |
//! | `gauge` | what gauges of the scene show, as a measure |
//! | `table` | figures, ratios and ranks of all rows; CSV |
//! | `text` | the table for a terminal |
//! | `chart` | the same as SVG |

#[cfg(feature = "cli")]
pub mod chart;
mod check;
mod definition;
mod error;
mod gauge;
mod measure;
mod memory;
mod plan;
mod readings;
mod reference;
mod run;
mod start;
mod table;
mod text;

pub use definition::*;
pub use error::StudyError;
pub use gauge::{GaugeMeasure, Statistic};
pub use measure::{Block, Measure};
pub use plan::{Plan, PlannedCase, PlannedVariant};
pub use reference::Reference;
pub use run::{Event, run};
pub use table::{Figure, Order, Row, Table};
