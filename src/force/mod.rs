//! All forces but pressure, each a file and a system that is in the schedule only if the scene asks.
//!
//! They add to [`Accelerations`](crate::state::Accelerations), which [`clear_forces`] starts at zero.

mod clear;
mod gravity;
mod surface_tension;
mod viscosity;
pub(crate) use clear::STAGE as CLEAR_FORCES;
pub(crate) use gravity::STAGE as GRAVITY;
pub(crate) use surface_tension::STAGE as SURFACE_TENSION;
pub(crate) use viscosity::STAGE as VISCOSITY;
