//! The time step: fixed, as large as speeds, forces, viscosity and sound allow, or the scheme of [`adaptive`] that goes
//! back from a shock.
//!
//! | limit | dt at most | source |
//! | --- | --- | --- |
//! | speed | λ h/v_max, λ of the scene | Courant–Friedrichs–Lewy; paper 4.3.2: nothing moves more than h/2 |
//! | force | 0.25 sqrt(h/a_max) | Monaghan 1992 |
//! | viscosity | h²/(32 ν); 0.8 of a [`lattice`](crate::lattice)'s own | Morris et al. 1997, eq. 23 |
//! | sound | 0.4 h/c | Becker & Teschner 2007, eq. 18 |
//! | pressure | half of what waves of a lattice under the largest pressure allow | [`lattice`](crate::lattice) |
//!
//! These are the limits of `Cfl`. Speeds and forces are those of the step before. Methods that iterate add a limit:
//! what an iteration costs is fixed, how many a step needs grows faster than its length, so a step that took more than
//! `ITERATIONS` is followed by a shorter one, and one whose error does not fall is halved before anything moves.

pub mod adaptive;
mod cfl;
mod install;
mod limits;
mod recovery;
pub mod roll_back;

pub use adaptive::AdaptiveTimeStep;
pub use cfl::{TimeStepControl, choose_time_step};
pub use install::install;
pub(crate) use limits::pressure_limit;
pub use limits::{StepLimits, motion_limits};
pub use recovery::{RecoveryTime, choose_recovery_time};
