//! Known answers: cases whose exact solution or experiment is published, run with every pressure method and compared.
//!
//! A [`Case`] is a folder of `assets/cases` (a scene, a page of explanation; compiled in) and a function that watches its
//! run. [`run_all`] runs [`Job`]s, a case with a method at a resolution each, side by side with one thread each, so that
//! figures do not depend on the number of threads.
//!
//! | file | what is in it |
//! | --- | --- |
//! | `case` | what a case is, and a run of it |
//! | `library` | the list of all cases, and of those that wait for something |
//! | `cases/…` | a file a case, or two that are measured alike |
//! | `figure` | what was measured beside what is known |
//! | `method` | the pressure methods that are asked |
//! | `particles` | fluid particles as plain values, and their motion as a rigid body |
//! | `run` | the simulation that a case watches |
//! | `queue` | many jobs |
//! | `convergence` | error against resolution: the order with its range |
//! | `report` | all as text, CSV and as a page of Markdown |
//!
//! ```no_run
//! use std::ops::ControlFlow;
//!
//! use overfall::validate::{CASES, Job, METHODS, run_all};
//!
//! let job = Job { case: CASES[0], method: &METHODS[2], resolution: CASES[0].resolution };
//! for outcome in run_all(&[job], 1, &mut |_| ControlFlow::Continue(())).into_iter().flatten() {
//!     for figure in outcome.result.expect("a run to its end").figures {
//!         let _ = (figure.quantity.as_str(), figure.measured, figure.known, figure.error());
//!     }
//! }
//! ```

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
pub use library::{CASES, WAITING, Waiting};
pub use method::{METHODS, Method};
pub use particles::{Particle, RigidMotion, particles_of, rigid_motion};
pub use queue::{Event, Job, Outcome, run_all};
pub use report::{csv, page, table};
pub use run::{Runner, Stopped};
