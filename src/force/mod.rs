//! All forces but pressure, each a file and a stage that is in the schedule only if the scene asks.
//!
//! They add to [`Accelerations`](crate::state::Accelerations), which [`clear_forces`] starts at zero.

mod body;
mod clear;
mod gravity;
pub(crate) mod inner;
mod surface_tension;
mod viscosity;

pub(crate) use body::STAGE as BODY_FORCES;
pub use body::apply_body_forces;
pub(crate) use clear::STAGE as CLEAR_FORCES;
pub use clear::clear_forces;
pub(crate) use gravity::STAGE as GRAVITY;
pub use gravity::apply_gravity;
pub(crate) use surface_tension::STAGE as SURFACE_TENSION;
pub use surface_tension::{Cohesion, apply_surface_tension};
pub use viscosity::{
    ArtificialViscosity, LaminarViscosity, NumericalViscosity, apply_artificial_viscosity,
    apply_laminar_viscosity, put_pressure_terms,
};
pub(crate) use viscosity::{STAGE as VISCOSITY, install as install_viscosity};
