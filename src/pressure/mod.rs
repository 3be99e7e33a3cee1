//! Pressure: one file per method, over the same force.
//!
//! A method is a row, [`PressureSolver`](solver::PressureSolver): its systems, its schedules, its columns and what it
//! requires of its parameters. Every method writes the pressure term `p/ρ²` beside the positions and leaves the rest to
//! [`pressure_force`]. Those that iterate do so in [`iterate`], from what [`warm_start`] gives them; [`implicit`] is
//! what the methods share whose densities are predicted from velocities, and [`diagonal`] the diagonal of their system.
//! [`initial`] is what the first step starts from. The first force may be summed along with viscosity
//! ([`first_force`]).
//!
//! | method | file | solves for | iterates over |
//! | --- | --- | --- | --- |
//! | SESPH | [`sesph`] | nothing: pressure is a function of density | – |
//! | PCISPH | [`pcisph`] | densities at predicted positions | one stiffness, a full lattice's |
//! | IISPH | [`iisph`] | densities predicted from velocities | every particle's own stiffness |
//! | DFSPH | [`dfsph`] | no compression in the velocities, then as IISPH | as IISPH |

pub mod convergence;
pub mod dfsph;
pub mod diagonal;
pub mod first_force;
pub mod force;
pub mod iisph;
pub mod implicit;
pub mod initial;
pub mod iterate;
pub mod pcisph;
pub mod sesph;
pub mod solver;
pub mod stages;
pub mod wall_renormalisation;
pub mod warm_start;

pub use crate::state::{DensityError, PressureSolve};
pub use force::pressure_force;
