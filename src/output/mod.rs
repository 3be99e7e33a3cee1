//! What a run writes: frames, series, history, summary, pictures.
//!
//! | file | written by | when |
//! | --- | --- | --- |
//! | `frame_000042.vtu`, `.ply` | [`Frame::write_vtu`], [`Frame::write_ply`] | a frame |
//! | `frames.pvd` | [`Series`] | a frame |
//! | `history.csv` | [`History`] | a step |
//! | `gauges/*.csv` | [`GaugeFile`] | a reading |
//! | `gauges/*.svg` | [`draw_beside_known`](crate::study::chart::draw_beside_known) | the end (feature `cli`) |
//! | `summary.json` | `Summary` | the end, however it comes (feature `cli`) |
//! | `*.png` | [`picture::draw`] | a frame (feature `cli`) |
//!
//! Whatever is written whole is written to a temporary file first and renamed, so a run that is killed leaves
//! complete files only. [`FIELDS`] declares once what a frame holds; both formats, both ways, go by it.

mod atomic;
mod capture;
mod cursor;
mod error;
mod fields;
mod frame;
mod frame_file;
mod gauges;
mod history;
#[cfg(feature = "cli")]
pub mod picture;
mod ply;
mod rows;
mod series;
#[cfg(feature = "cli")]
pub mod summary;
mod vtu;

pub use atomic::{partial_name, write_atomically, write_durably};
pub use error::OutputError;
pub use fields::{FIELDS, Field};
pub use frame::Frame;
pub use gauges::GaugeFile;
pub use history::History;
pub use series::{Series, SeriesEntry};
#[cfg(feature = "cli")]
pub use summary::{RunTotals, Status, Summary, peak_rss_bytes};
