//! Fluid particles as plain values.

use bevy_ecs::prelude::*;
use glam::{DVec3, Vec3};

use crate::state::particle::{Density, Fluid, Position, Pressure, Velocity};

/// A fluid particle after a step. Position and velocity are those at its end, density and pressure those that it
/// computed at its start.
#[derive(Debug, Clone, Copy)]
pub struct Particle {
    /// Its number.
    pub entity: Entity,
    /// Position \[m].
    pub position: Vec3,
    /// Velocity \[m/s].
    pub velocity: Vec3,
    /// Density \[kg/m³].
    pub density: f32,
    /// Pressure \[Pa].
    pub pressure: f32,
}

/// Every fluid particle of a world.
pub fn particles_of(world: &mut World) -> Vec<Particle> {
    let mut query =
        world.query_filtered::<(Entity, &Position, &Velocity, &Density, &Pressure), With<Fluid>>();
    query
        .iter(world)
        .map(|(entity, position, velocity, density, pressure)| Particle {
            entity,
            position: position.0,
            velocity: velocity.0,
            density: density.0,
            pressure: pressure.0,
        })
        .collect()
}

/// Sets the velocity \[m/s] of every fluid particle from a field.
pub(super) fn set_velocities(world: &mut World, mut field: impl FnMut(Vec3) -> Vec3) {
    let mut query = world.query_filtered::<(&Position, &mut Velocity), With<Fluid>>();
    for (position, mut velocity) in query.iter_mut(world) {
        velocity.0 = field(position.0);
    }
}

/// Centre, velocity, and angular momentum about the centre of the particles, for a total mass of 1.
#[derive(Debug, Clone, Copy)]
pub struct RigidMotion {
    /// Position of the centre \[m].
    pub center: DVec3,
    /// Its velocity \[m/s].
    pub velocity: DVec3,
    /// Angular momentum about the centre \[m²/s].
    pub angular_momentum: DVec3,
}

/// The rigid part of the motion; sums in f64.
pub fn rigid_motion(particles: &[Particle]) -> RigidMotion {
    let mean = |value: &dyn Fn(&Particle) -> DVec3| -> DVec3 {
        particles.iter().map(value).sum::<DVec3>() / particles.len() as f64
    };
    let center = mean(&|particle| particle.position.as_dvec3());
    let velocity = mean(&|particle| particle.velocity.as_dvec3());
    let angular_momentum = mean(&|particle| {
        let arm = particle.position.as_dvec3() - center;
        arm.cross(particle.velocity.as_dvec3() - velocity)
    });
    RigidMotion {
        center,
        velocity,
        angular_momentum,
    }
}
