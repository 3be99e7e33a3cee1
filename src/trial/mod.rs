//! Short trials of a scene: what its parts cost, and what it could do without.
//!
//! A [`Trial`] takes a few steps and notes times, iterations, motion and energies. [`cost()`] compares trials of a
//! scene with those of simpler ones; [`advise()`] finds the cheapest settings that hold an error.

mod advise;
mod changes;
mod cost;
mod run;

pub use advise::{Advice, AdviceError, Asked, Setting, Tried, advise};
pub use changes::{Change, simpler};
pub use cost::{Cost, Saved, Saving, cost};
pub use run::{End, Limits, Trial, TrialError, run};
