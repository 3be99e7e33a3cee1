//! Gauges: instruments of a scene ([`crate::scene::Gauge`]) that are read during a run, after every successful step.
//!
//! All gauges read the state as in frames: positions and velocities at the end of the step, densities and pressures as
//! computed in it (`moment`). They find particles through the index of the step's start, so a particle contributes if
//! its position at that time was within range; its weight is that of its current position. Sums are taken in the order
//! of the rows, so figures depend neither on the number of threads nor on the structure of the index.
//!
//! The gauges are in `point`, `level`, `flux`, `force` and `energy`; [`Gauges`] holds them in a world, whether or not
//! files are written. [`Snapshot`] answers queries of a host between steps.

mod account;
mod energy;
mod flux;
mod force;
mod free;
mod gauges;
mod level;
mod moment;
mod near;
mod point;
mod reactions;
mod snapshot;
mod state;
mod window;

pub use account::EnergyAccount;
pub(crate) use account::{book, note_start};
pub(crate) use free::keep_velocities;
pub use gauges::{Gauge, Gauges, Reading, settled_step};
pub(crate) use gauges::{go_back, install, measures_energy, measures_forces, read_gauges};
pub use snapshot::{
    Field, Interpolated, Neighbour, Snapshot, SnapshotError, Target, neighbours_of,
};
