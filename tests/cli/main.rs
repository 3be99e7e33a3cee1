//! The program as its user sees it.
#![cfg(feature = "cli")]

mod support;

mod arguments;
mod folders;
mod frontier;
mod gauges;
#[cfg(unix)]
mod limits;
mod memory;
mod picture;
#[cfg(unix)]
mod replaced;
mod reports;
mod resume;
mod roll_back;
mod run;
#[path = "../survival_support/running.rs"]
mod running;
#[cfg(unix)]
mod signals;
mod stability;
mod stability_errors;
mod study;
mod study_resume;
mod surface;
mod trials;
