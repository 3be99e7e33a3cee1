//! Pressure: one file per method. A method implements [`PressureSolver`](solver::PressureSolver), stores the pressure
//! term `p/ρ²` beside the positions and leaves the rest to [`pressure_force`]. Iterative methods run in [`iterate`],
//! starting from [`warm_start`], or from [`initial`] in the first step. [`implicit`] is shared by the methods that
//! predict densities from velocities; [`diagonal`] is its diagonal, [`stabilisation`] keeps pressure from alternating.
//!
//! | method | solves for | iterates over |
//! | --- | --- | --- |
//! | [`sesph`] | nothing: pressure is a function of density | – |
//! | [`delta_sph`] | nothing: pressure follows from the motion | – |
//! | [`pcisph`] | densities at predicted positions | one stiffness, that of a full lattice |
//! | [`iisph`] | densities predicted from velocities | the stiffness of each particle |
//! | [`dfsph`] | no compression in the velocities, then as IISPH | as IISPH |

pub mod convergence;
pub mod delta_sph;
pub mod density_rate;
pub mod dfsph;
pub mod diagonal;
pub mod first_force;
pub mod force;
pub mod iisph;
mod impact;
pub mod implicit;
pub mod initial;
pub mod iterate;
pub mod neighbour_count;
pub mod pcisph;
pub mod sesph;
pub(crate) mod shifting;
pub mod solver;
pub mod stabilisation;
pub mod stages;
pub mod wall_renormalisation;
pub mod warm_start;

pub use crate::state::{DensityError, SolverState};
pub use force::pressure_force;
