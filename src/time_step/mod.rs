//! The time step: fixed, `Cfl` with the limits below, or the scheme of [`adaptive`] that rolls back after a shock.
//!
//! | limit | dt at most | source |
//! | --- | --- | --- |
//! | speed | λ h/v_max, λ of the scene | Courant–Friedrichs–Lewy; paper 4.3.2: nothing moves more than h/2 |
//! | force | 0.25 sqrt(h/a_max) | Monaghan 1992 |
//! | viscosity | h²/(32 ν); 0.8 of that of a [`lattice`](crate::lattice) | Morris et al. 1997, eq. 23 |
//! | sound | 0.4 h/c | Becker & Teschner 2007, eq. 18 |
//! | period | 1/20 of that of walls and body forces | a sine in 20 pieces is 1.2 % off |
//! | pressure | half the limit of a lattice's waves under the largest pressure | [`lattice`](crate::lattice) |
//!
//! Speeds and forces are those of the previous step. Methods that iterate shorten steps further: see `cfl::ITERATIONS`.

pub mod adaptive;
mod cfl;
mod first;
mod install;
mod limits;
mod recovery;
pub mod roll_back;

pub use adaptive::AdaptiveTimeStep;
pub use cfl::{TimeStepControl, choose_time_step};
pub(crate) use first::{remember_first_pressure, shorten_first_step};
pub use install::install;
pub(crate) use limits::pressure_limit;
pub use limits::{StepLimits, motion_limits};
pub(crate) use recovery::MOST_MISSING;
pub use recovery::{RecoveryTime, choose_recovery_time};
