//! All forces but pressure, each a file and a system that is in the schedule only if the scene asks.
//!
//! They add to [`Accelerations`](crate::state::Accelerations), which gravity starts.

mod gravity;
mod surface_tension;
mod viscosity;

pub use gravity::apply_gravity;
pub use surface_tension::{Cohesion, apply_surface_tension};
pub use viscosity::{
    ArtificialViscosity, LaminarViscosity, NumericalViscosity, apply_artificial_viscosity,
    apply_laminar_viscosity, put_pressure_terms,
};
