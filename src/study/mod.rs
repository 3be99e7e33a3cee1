//! Studies: variants of a scene, measured side by side.
//!
//! A study is a RON file ([`Study`]): a scene, variants of it ([`Override`](crate::loading::Override)s), quantities to
//! measure and figures to compare with. `Study::load` reads and checks it and returns a [`Plan`]; [`run()`] runs that;
//! a [`Table`] holds the results, as text and as CSV; `chart::draw` draws them (feature `cli`).

#[cfg(feature = "cli")]
pub mod chart;
mod check;
mod definition;
mod error;
mod gauge;
mod measure;
mod memory;
mod pause;
mod plan;
mod readings;
mod reference;
mod run;
mod span;
mod start;
mod table;
mod text;

pub use definition::is_study;
pub use definition::*;
pub use error::StudyError;
pub use gauge::{GaugeMeasure, Statistic};
pub use measure::{Block, Measure};
pub use pause::Pause;
pub use plan::{Plan, PlannedCase, PlannedVariant};
pub use reference::Reference;
pub use run::{Event, resume, run};
pub use table::{Figure, Order, Row, Table};
