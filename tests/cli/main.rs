//! The program as its user sees it.
#![cfg(feature = "cli")]

mod support;

mod arguments;
mod folders;
mod gauges;
#[cfg(unix)]
mod limits;
mod picture;
mod reports;
mod resume;
mod roll_back;
mod run;
#[path = "../survival_support/running.rs"]
mod running;
#[cfg(unix)]
mod signals;
mod study;
mod study_resume;
