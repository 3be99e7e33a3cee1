//! Stability studies: where a scene runs well, over two of its values.
//!
//! A study (`kind: Stability`) sweeps two overridable values of a scene, or sweeps one and searches the edge of the
//! other by bisection. Every run is watched ([`Observed`]) and classed by stated rules ([`Rules`], [`Class`]); several
//! seeds give a probability. The results are a CSV file with the command of every run ([`Reading`]) and a map
//! (`chart::draw_map`). A run that is finished is never run again ([`Known`]).

mod axis;
mod class;
mod definition;
mod observe;
mod plan;
mod results;
mod run;
pub(crate) mod template;
mod text;
mod theory;

pub use class::{Class, End, Observed, Rules};
pub use definition::{Axis, MapVariant, Scale, Seeds, StabilityKind, StabilityStudy, Values};
pub use plan::{PlannedMap, PointOf, StabilityPlan};
pub use results::{Known, Reading, csv_of};
pub use run::{StabilityEvent, run_stability, sort};
pub(crate) use run::{key as key_of, scene_text};
pub use text::text_of;
pub use theory::{StepLimit, shares_of_limits, step_limits};
