//! Studies: variants of a scene, measured side by side.
//!
//! A study is a RON file ([`Study`]): a scene, variants of it ([`Override`](crate::loading::Override)s), quantities to
//! measure and figures to compare with. `Study::load` reads and checks it and returns a [`Plan`]; [`run()`] runs that;
//! a [`Table`] holds the results, as text and as CSV; `chart::draw` draws them (feature `cli`). A file with
//! `kind: Stability` is a map of where a scene runs well (`stability`, feature `cli`).

#[cfg(feature = "cli")]
pub mod chart;
mod check;
#[cfg(feature = "cli")]
pub(crate) mod command;
mod definition;
mod error;
mod gauge;
#[cfg(feature = "cli")]
mod kind;
mod measure;
mod memory;
pub(crate) mod names;
mod pause;
mod plan;
#[cfg(feature = "cli")]
pub(crate) mod pool;
mod readings;
mod reference;
mod run;
#[cfg(feature = "cli")]
pub mod stability;
mod start;
mod table;
mod text;

pub use definition::is_study;
pub use definition::*;
pub use error::StudyError;
pub use gauge::{GaugeMeasure, Statistic};
#[cfg(feature = "cli")]
pub use kind::StudyKind;
pub use measure::{Block, Measure};
pub use pause::Pause;
pub use plan::{Plan, PlannedCase, PlannedVariant};
pub use reference::Reference;
pub use run::{Event, resume, run};
pub use table::{Figure, Order, Row, Table};
#[cfg(feature = "cli")]
pub(crate) use text::short;
