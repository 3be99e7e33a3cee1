//! Solid boundaries as particles (Akinci et al. 2012): sampled once, with the volume that each stands for.
//!
//! A wall adds `ρ0 V_b W` to the density of the fluid near it, which makes pressure push the fluid away. The particles
//! are entities; loops read a packed copy, and an index of their own that is built once, or follows the walls that
//! [move](moving). What they add to the sums of the fluid is found once a step ([`sums`]).

mod apart;
pub mod contact;
pub mod direct_forcing;
pub(crate) mod extrapolation;
pub mod friction;
pub mod moving;
pub mod owners;
pub mod room;
mod samples;
pub mod sums;
mod volume;

pub use samples::{BoundaryError, pack, refresh_boundary};
pub use volume::VolumeRule;
