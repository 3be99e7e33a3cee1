//! Frontier studies: speed against error, measured against what is known.
//!
//! A study (`kind: Frontier`) runs a case of `overfall validate`, or a scene with a fine run of its own, over a grid of
//! settings. It shows the error of named figures over the wall time per simulated time, and which settings no other
//! ones beat. The results are a CSV file with the command of every run ([`Runs`]) and a chart
//! (`study::chart::draw_frontier`). A run that is finished is never made again.

mod curves;
mod definition;
mod measure;
mod plan;
mod reference;
mod results;
mod run;
mod text;

pub use definition::is_frontier;
pub use definition::{FrontierKind, FrontierStudy, FrontierVariant, GaugeColumn, Truth};
pub use plan::{FrontierPlan, PlannedPoint, Subject};
pub use reference::Reference;
pub use results::{Failed, Point, Run, Runs, pareto_front};
pub use run::{FrontierEvent, run_frontier};
pub use text::text_of;
