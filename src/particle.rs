//! The components of a particle. A particle is an entity; a column is one component of all particles.
//!
//! Scratch that every step writes afresh is no component (8 bytes of change ticks a row and column): it lives in
//! resources, indexed by row.

use bevy_ecs::prelude::*;
use bytemuck::{Pod, TransparentWrapper, Zeroable};
use glam::Vec3;

/// Where a particle is [m]. In 2-D, z is zero.
#[derive(Component, Debug, Clone, Copy, Default, PartialEq, TransparentWrapper, Pod, Zeroable)]
#[repr(transparent)]
pub struct Position(pub Vec3);

/// Velocity of a fluid particle [m/s].
#[derive(Component, Debug, Clone, Copy, Default, PartialEq, TransparentWrapper, Pod, Zeroable)]
#[repr(transparent)]
pub struct Velocity(pub Vec3);

/// Density of a fluid particle [kg/m³] (paper eq. 1).
#[derive(Component, Debug, Clone, Copy, Default, PartialEq, TransparentWrapper, Pod, Zeroable)]
#[repr(transparent)]
pub struct Density(pub f32);

/// Pressure of a fluid particle [Pa]; beside a wall, too (see [`fluid_share`](crate::pressure::fluid_share)).
#[derive(Component, Debug, Clone, Copy, Default, PartialEq, TransparentWrapper, Pod, Zeroable)]
#[repr(transparent)]
pub struct Pressure(pub f32);

/// Mean pressure of a fluid particle over the steps before [Pa], in scenes whose pressure solve starts from it (see
/// [`warm_start`](crate::pressure::warm_start)).
#[derive(Component, Debug, Clone, Copy, Default, PartialEq, TransparentWrapper, Pod, Zeroable)]
#[repr(transparent)]
pub struct MeanPressure(pub f32);

/// Marks a fluid particle. Spawning `(Fluid, Position(x))` is enough: the rest is required and starts at zero.
#[derive(Component, Debug, Clone, Copy, Default)]
#[require(Position, Velocity, Density, Pressure)]
pub struct Fluid;

/// The part of space a boundary particle stands for [m³; m² in 2-D] (Akinci et al. 2012).
#[derive(Component, Debug, Clone, Copy, Default, PartialEq, TransparentWrapper, Pod, Zeroable)]
#[repr(transparent)]
pub struct BoundaryVolume(pub f32);

/// Unit vector at a boundary particle from the solid into the fluid.
#[derive(Component, Debug, Clone, Copy, PartialEq, TransparentWrapper, Pod, Zeroable)]
#[repr(transparent)]
pub struct BoundaryNormal(pub Vec3);

impl Default for BoundaryNormal {
    fn default() -> Self {
        Self(Vec3::Y)
    }
}

/// Marks a boundary particle.
#[derive(Component, Debug, Clone, Copy, Default)]
#[require(Position, BoundaryVolume, BoundaryNormal)]
pub struct Boundary;
