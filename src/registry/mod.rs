//! All possible parts of a step, in rows: its stages and the columns of its particles.
//!
//! A row is declared beside its code. To add a force, a stage or a state column, write its file and name its row here.

mod advance;
mod columns;
mod gather;
mod remembered;
mod stages;
mod transport;

pub use columns::columns;
pub(crate) use remembered::{REMEMBERED, REORDERING};
pub use stages::{StageError, Stages};
pub use transport::{gathering, scattering};
