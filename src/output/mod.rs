//! Output of a run: frames, series, history, gauges, summary, pictures.
//!
//! Per run: `boundary.vtu`, the boundary particles ([`WallFrame`]); where walls move, one per frame.
//! Per frame: `frame_000042.vtu` or `.ply` ([`Frame`]), its entry in `frames.pvd` ([`Series`]), a `.png` (`picture`).
//! Per step: a row of `history.csv` ([`History`]). Per reading: a row of `gauges/*.csv` ([`GaugeFile`]). At the end,
//! also of an interrupted run: `summary.json` (`Summary`) and the charts of gauges. Summary, pictures and charts need
//! feature `cli`.
//!
//! A file that is written as a whole is written under a temporary name first and then renamed, so a run that is killed
//! leaves only complete files. [`FIELDS`] declares once what a frame holds; both formats use it, for writing and
//! reading.

mod atomic;
mod capture;
mod cursor;
mod error;
mod fields;
mod frame;
mod frame_file;
mod gauges;
mod grid;
mod history;
#[cfg(feature = "cli")]
pub mod memory;
#[cfg(feature = "cli")]
pub mod picture;
mod ply;
#[cfg(feature = "cli")]
mod provenance;
mod rows;
mod series;
#[cfg(feature = "cli")]
pub mod summary;
pub mod surface;
mod vtu;
mod walls;

pub use atomic::{partial_name, write_atomically, write_durably};
pub use error::OutputError;
pub use fields::{FIELDS, Field};
pub use frame::Frame;
pub use gauges::GaugeFile;
pub use history::History;
#[cfg(feature = "cli")]
pub use provenance::Provenance;
pub use series::{Series, SeriesEntry};
#[cfg(feature = "cli")]
pub use summary::{RunTotals, Status, Summary, peak_rss_bytes};
pub use walls::WallFrame;
