//! All forces but pressure, each a file and a system that is in the schedule only if the scene asks.
//!
//! They add to [`Accelerations`](crate::state::Accelerations), which [`clear_forces`] starts at zero.

mod clear;
mod gravity;
mod surface_tension;
mod viscosity;

use crate::state::Stage;
pub use clear::clear_forces;
pub use gravity::apply_gravity;
pub use surface_tension::{Cohesion, apply_surface_tension};
pub use viscosity::{
    ArtificialViscosity, LaminarViscosity, NumericalViscosity, apply_artificial_viscosity,
    apply_laminar_viscosity, put_pressure_terms,
};

/// Rows of the forces, in the order in which they act by default.
pub(crate) const STAGES: [Stage; 4] = [
    clear::STAGE,
    gravity::STAGE,
    viscosity::STAGE,
    surface_tension::STAGE,
];
