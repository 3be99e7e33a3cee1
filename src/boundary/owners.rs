//! Which boundary of the scene a sample belongs to: in scenes that measure forces on boundaries.

use bevy_ecs::prelude::*;

/// Number of the boundary in the scene that a boundary particle samples, from 0.
#[derive(Component, Debug, Clone, Copy, PartialEq, Eq)]
pub struct SampleOf(pub u32);

/// The same of all boundary particles, in the order of [`BoundarySamples`](crate::index::BoundarySamples); [`NOBODY`]
/// for what a host spawned without it.
#[derive(Resource, Debug, Clone, Default)]
pub struct Owners(pub(crate) Vec<u32>);

/// No boundary of the scene.
pub const NOBODY: u32 = u32::MAX;
