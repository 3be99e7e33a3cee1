//! Steps that were taken back.

use bevy_ecs::prelude::*;
use glam::Vec3;

use super::failure::FailureCause;

/// Steps taken back.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct TakenBack {
    /// How many, the one that went wrong included: 2, or 1 where no older state is left to go back to.
    pub steps: u32,
    /// What went wrong.
    pub cause: FailureCause,
    /// The particle concerned and where it was \[m], if one is.
    pub particle: Option<(Entity, Vec3)>,
}
