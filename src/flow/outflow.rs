//! Particles that leave: into boxes that remove, or out of a domain that removes.

use bevy_ecs::prelude::*;
use rayon::prelude::*;

use super::{changes::Changes, sources::Turnover};
use crate::{
    scene::{Bounds, Outside, Period, Scene},
    state::{
        CHUNK, Execution, in_order,
        particle::{Fluid, ParticleId, Position},
    },
};

/// Where particles are removed.
#[derive(Resource, Debug)]
pub(super) struct Outflow {
    boxes: Vec<Bounds>,
    /// Boxes have images along its axes, as particles have.
    period: Period,
    /// Outside of it they are removed, too.
    domain: Option<Bounds>,
    /// Those to be removed, in the order of the rows, with their numbers.
    leaving: Vec<(Entity, u32)>,
}

impl Outflow {
    pub(super) fn new(scene: &Scene) -> Self {
        Self {
            boxes: scene.outflow.clone(),
            period: scene.period(),
            domain: scene.domain.filter(|_| scene.outside == Outside::Remove),
            leaving: Vec::new(),
        }
    }
}

/// Finds the particles that leave (phase `Reorder`).
pub(super) fn find_leaving(
    mut outflow: ResMut<Outflow>,
    fluid: Query<(Entity, &Position, &ParticleId), With<Fluid>>,
    execution: Res<Execution>,
) {
    let Outflow {
        boxes,
        period,
        domain,
        leaving,
    } = &mut *outflow;
    leaving.clear();
    let holds =
        |bounds: &Bounds, x: &Position| x.0.cmpge(bounds.min).all() && x.0.cmple(bounds.max).all();
    let leaves = |x: &Position| {
        boxes.iter().any(|bounds| period.contains(bounds, x.0))
            || domain.is_some_and(|domain| !holds(&domain, x))
    };
    let tables = fluid.contiguous_iter().into_iter().flatten();
    for (entities, positions, ids) in in_order(tables, |table| table.0) {
        let chunks = positions.par_chunks(CHUNK).enumerate();
        let found = chunks.flat_map_iter(|(chunk, positions)| {
            let rows = (chunk * CHUNK..).zip(positions);
            let gone = rows.filter(|(_, x)| leaves(x));
            gone.map(|(row, _)| (entities[row], ids[row].get()))
                .collect::<Vec<_>>()
        });
        leaving.extend(execution.install(|| found.collect::<Vec<_>>()));
    }
}

pub(super) fn somebody_leaves(outflow: Res<Outflow>) -> bool {
    !outflow.leaving.is_empty()
}

pub(super) fn remove(world: &mut World) {
    let leaving = std::mem::take(&mut world.resource_mut::<Outflow>().leaving);
    world.resource_mut::<Turnover>().removed += leaving.len() as u64;
    for &(particle, _) in &leaving {
        // Its children go with it, and may be particles that leave, too.
        world.try_despawn(particle).ok();
    }
    if let Some(mut changes) = world.get_resource_mut::<Changes>() {
        changes.gone.extend(leaving);
    }
}
