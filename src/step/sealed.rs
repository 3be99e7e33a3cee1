//! Which resources of a scene are sealed ([`seal`](crate::state::seal)): those that no host may write.

use bevy_ecs::{component::ComponentId, prelude::*};

use super::{advance::Owed, order::Decisions, report::StepOutcome, timer::PhaseTimer};
use crate::{
    gauge::Gauges,
    registry::Stages,
    state::{
        Accelerations, Clock, Execution, Failure, Material, of_step::OfStep,
        particle::NextParticleId, seal::Seal,
    },
};

/// Resources that hosts may write, that say how a step goes, and that spawning a particle changes.
fn unsealed(world: &World) -> [Option<ComponentId>; 14] {
    [
        world.component_id::<Accelerations>(),
        world.component_id::<Clock>(),
        world.component_id::<Decisions>(),
        world.component_id::<Execution>(),
        world.component_id::<Failure>(),
        world.component_id::<Gauges>(),
        world.component_id::<Material>(),
        world.component_id::<NextParticleId>(),
        world.component_id::<OfStep>(),
        world.component_id::<Owed>(),
        world.component_id::<PhaseTimer>(),
        world.component_id::<Seal>(),
        world.component_id::<Stages>(),
        world.component_id::<StepOutcome>(),
    ]
}

/// Seals the resources that a scene has put into the world.
pub(super) fn seal_installed(world: &mut World, new: &[ComponentId]) {
    let unsealed = unsealed(world);
    // Stages of a host insert their own.
    let is_ours = |id: &ComponentId| {
        let name = world.components().get_name(*id);
        name.is_some_and(|name| name.to_string().starts_with("overfall::"))
    };
    let sealed = new.iter().copied();
    let sealed = sealed.filter(|id| is_ours(id) && !unsealed.contains(&Some(*id)));
    let sealed = sealed.collect();
    Seal::put(world, sealed);
}
