//! The components of a particle. A particle is an entity; a column is one component of all particles.
//!
//! Scratch that every step writes afresh is no component (8 bytes of change ticks a row and column): it lives in
//! resources, indexed by row.

use std::collections::HashMap;

use bevy_ecs::{
    entity_disabling::Disabled, lifecycle::HookContext, prelude::*, world::DeferredWorld,
};
use bytemuck::{Pod, TransparentWrapper, Zeroable};
use glam::Vec3;

#[cfg(feature = "bevy_reflect")]
use bevy_ecs::reflect::ReflectComponent;

use super::remembered::Remembers;

/// Where a particle is \[m]. In 2-D, z is zero.
#[derive(Component, Debug, Clone, Copy, Default, PartialEq, TransparentWrapper, Pod, Zeroable)]
#[cfg_attr(
    feature = "bevy_reflect",
    derive(bevy_reflect::Reflect),
    reflect(Component)
)]
#[repr(transparent)]
pub struct Position(pub Vec3);

/// Velocity of a fluid particle \[m/s].
#[derive(Component, Debug, Clone, Copy, Default, PartialEq, TransparentWrapper, Pod, Zeroable)]
#[cfg_attr(
    feature = "bevy_reflect",
    derive(bevy_reflect::Reflect),
    reflect(Component)
)]
#[repr(transparent)]
pub struct Velocity(pub Vec3);

/// Density of a fluid particle \[kg/m³] (paper eq. 1).
#[derive(Component, Debug, Clone, Copy, Default, PartialEq, TransparentWrapper, Pod, Zeroable)]
#[cfg_attr(
    feature = "bevy_reflect",
    derive(bevy_reflect::Reflect),
    reflect(Component)
)]
#[repr(transparent)]
pub struct Density(pub f32);

/// Pressure of a fluid particle \[Pa].
#[derive(Component, Debug, Clone, Copy, Default, PartialEq, TransparentWrapper, Pod, Zeroable)]
#[cfg_attr(
    feature = "bevy_reflect",
    derive(bevy_reflect::Reflect),
    reflect(Component)
)]
#[repr(transparent)]
pub struct Pressure(pub f32);

/// Mean pressure of a fluid particle over the steps before \[Pa], in scenes whose pressure solve starts from it (see
/// [`warm_start`](crate::pressure::warm_start)).
#[derive(Component, Debug, Clone, Copy, Default, PartialEq, TransparentWrapper, Pod, Zeroable)]
#[cfg_attr(
    feature = "bevy_reflect",
    derive(bevy_reflect::Reflect),
    reflect(Component)
)]
#[repr(transparent)]
pub struct MeanPressure(pub f32);

/// Lasting number of a fluid particle, by which frames name it: given in the order of spawning, from 0, and never again
/// in the same world. An [`Entity`]'s index would be given to another particle as soon as this one is gone.
///
/// Inserting it gives a new number, whatever the value. Particles that were spawned before the scene was installed get
/// theirs then.
#[derive(Component, Debug, Clone, Copy, Default, PartialEq, Eq, PartialOrd, Ord)]
#[cfg_attr(
    feature = "bevy_reflect",
    derive(bevy_reflect::Reflect),
    reflect(Component)
)]
#[component(on_insert = give_a_number)]
pub struct ParticleId(u32);

impl ParticleId {
    /// The number.
    pub fn get(self) -> u32 {
        self.0
    }
}

/// Gives a particle the number that it had.
pub(crate) fn give_number_back(world: &mut World, particle: Entity, number: u32) {
    if let Some(mut id) = world.get_mut::<ParticleId>(particle) {
        id.0 = number;
    }
}

/// Lets the next particle have this number, and returns the one that it would have had.
pub(crate) fn replace_next_number(world: &mut World, number: u32) -> u32 {
    let mut next = world.get_resource_or_init::<NextParticleId>();
    std::mem::replace(&mut next.0, number)
}

/// The number that the next particle gets. After 2³² − 1 particles all others have the last one.
#[derive(Resource, Debug, Clone, Copy, Default)]
pub(crate) struct NextParticleId(u32);

impl Remembers for NextParticleId {
    type State = u32;

    fn state(&self, _: &[Entity]) -> u32 {
        self.0
    }

    fn set_state(&mut self, next: u32, _: &[Entity]) -> Result<(), &'static str> {
        self.0 = next;
        Ok(())
    }
}

fn give_a_number(mut world: DeferredWorld, context: HookContext) {
    let Some(mut next) = world.get_resource_mut::<NextParticleId>() else {
        return;
    };
    let number = next.0;
    next.0 = number.saturating_add(1);
    if let Some(mut id) = world.get_mut::<ParticleId>(context.entity) {
        id.0 = number;
    }
}

/// Begins to number particles; those that there are come first, in the order of their entities.
pub(crate) fn number_particles(world: &mut World) {
    let mut fluid = world.query_filtered::<Entity, (With<Fluid>, Allow<Disabled>)>();
    let mut present: Vec<Entity> = fluid.iter(world).collect();
    present.sort_unstable_by_key(|entity| entity.index_u32());
    world.init_resource::<NextParticleId>();
    for entity in present {
        world.entity_mut(entity).insert(ParticleId::default());
    }
}

/// The particles of these numbers: those that there are, and new ones. Others go.
pub(crate) fn gather_particles(world: &mut World, numbers: &[u32]) -> Vec<Entity> {
    let mut query = world.query_filtered::<(Entity, &ParticleId), With<Fluid>>();
    let mut present: HashMap<u32, Entity> = HashMap::new();
    let mut superfluous = Vec::new();
    for (entity, id) in query.iter(world) {
        if let Some(other) = present.insert(id.get(), entity) {
            superfluous.push(other);
        }
    }
    let mut particles = Vec::with_capacity(numbers.len());
    for number in numbers {
        let particle = present
            .remove(number)
            .unwrap_or_else(|| world.spawn(Fluid).id());
        particles.push(particle);
    }
    superfluous.extend(present.into_values());
    // In one order, as entities that are free are used again.
    superfluous.sort_unstable();
    for particle in superfluous {
        world.despawn(particle);
    }
    for (&particle, &number) in particles.iter().zip(numbers) {
        give_number_back(world, particle, number);
    }
    particles
}

/// Marks a fluid particle. Spawning `(Fluid, Position(x))` is enough: the rest is required and starts at zero.
#[derive(Component, Debug, Clone, Copy, Default)]
#[cfg_attr(
    feature = "bevy_reflect",
    derive(bevy_reflect::Reflect),
    reflect(Component)
)]
#[require(Position, Velocity, Density, Pressure, ParticleId)]
pub struct Fluid;

/// The part of space a boundary particle stands for \[m³; m² in 2-D] (Akinci et al. 2012).
#[derive(Component, Debug, Clone, Copy, Default, PartialEq, TransparentWrapper, Pod, Zeroable)]
#[cfg_attr(
    feature = "bevy_reflect",
    derive(bevy_reflect::Reflect),
    reflect(Component)
)]
#[repr(transparent)]
pub struct BoundaryVolume(pub f32);

/// Unit vector at a boundary particle from the solid into the fluid.
#[derive(Component, Debug, Clone, Copy, PartialEq, TransparentWrapper, Pod, Zeroable)]
#[cfg_attr(
    feature = "bevy_reflect",
    derive(bevy_reflect::Reflect),
    reflect(Component)
)]
#[repr(transparent)]
pub struct BoundaryNormal(pub Vec3);

impl Default for BoundaryNormal {
    fn default() -> Self {
        Self(Vec3::Y)
    }
}

/// Depth of a boundary particle behind the face of its wall \[m]; those of walls of one layer have none.
#[derive(Component, Debug, Clone, Copy, Default, PartialEq, TransparentWrapper, Pod, Zeroable)]
#[cfg_attr(
    feature = "bevy_reflect",
    derive(bevy_reflect::Reflect),
    reflect(Component)
)]
#[repr(transparent)]
pub struct BoundaryDepth(pub f32);

/// Marks a boundary particle.
#[derive(Component, Debug, Clone, Copy, Default)]
#[cfg_attr(
    feature = "bevy_reflect",
    derive(bevy_reflect::Reflect),
    reflect(Component)
)]
#[require(Position, BoundaryVolume, BoundaryNormal)]
pub struct Boundary;

/// Registers the components of particles, so that editors and scene files of bevy may name them. `FluidPlugin` does so.
#[cfg(feature = "bevy_reflect")]
pub fn register_types(registry: &mut bevy_reflect::TypeRegistry) {
    registry.register::<Position>();
    registry.register::<Velocity>();
    registry.register::<Density>();
    registry.register::<Pressure>();
    registry.register::<MeanPressure>();
    registry.register::<ParticleId>();
    registry.register::<Fluid>();
    registry.register::<BoundaryVolume>();
    registry.register::<BoundaryNormal>();
    registry.register::<BoundaryDepth>();
    registry.register::<Boundary>();
}
