//! Validation: cases whose exact solution or experiment is published, run with every pressure method and compared.
//!
//! A [`Case`] is a folder of `assets/cases` (a scene and a page of explanation, compiled in) and a function that
//! observes its run. [`CASES`] lists them. [`run_all`] runs [`Job`]s: one case with one method at one resolution each,
//! in parallel with one thread each, so that figures do not depend on the number of threads. [`convergence()`] fits the
//! order of errors over resolution; [`table`], [`csv()`] and [`page`] report the results.

mod case;
mod cases;
mod convergence;
mod figure;
mod library;
mod method;
mod particles;
mod queue;
mod report;
mod run;

pub use case::Case;
pub use convergence::{Convergence, Order, convergence};
pub use figure::{Comparison, Figure, Findings, Source};
pub use library::CASES;
pub use method::{METHODS, Method};
pub use particles::{Particle, RigidMotion, particles_of, rigid_motion};
pub use queue::{Event, Job, Outcome, run_all};
pub use report::{csv, page, table};
pub use run::{Runner, Spent, Stopped};
