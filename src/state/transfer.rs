//! Rows of a step: which particle is in which, and that no other came in between.

use std::sync::atomic::{AtomicBool, Ordering::Relaxed};

use bevy_ecs::{prelude::*, system::SystemChangeTick};
use rayon::prelude::*;

use super::{
    column::{in_order, refuse_lack},
    columns::{PredictedPositions, SENTINEL},
    execution::{CHUNK, Execution},
    failure::{Failure, FailureCause},
    particle::{Fluid, ParticleId, Position},
    rows::Rows,
};
use crate::communicator::Team;

/// Refuses a step of particles without a number (phase `RebuildIndex`).
pub fn check_ids(
    fluid: Query<(Entity, Has<ParticleId>), With<Fluid>>,
    places: Query<&Position>,
    failure: ResMut<Failure>,
) {
    refuse_lack(fluid, places, failure, "ParticleId");
}

/// Notes which particle is in which row (phase `RebuildIndex`, before the columns are gathered).
pub fn gather_rows(
    fluid: Query<Entity, With<Fluid>>,
    mut rows: ResMut<Rows>,
    mut predicted: ResMut<PredictedPositions>,
    execution: Res<Execution>,
    now: SystemChangeTick,
) {
    let tables = || fluid.contiguous_iter().into_iter().flatten();
    let count: usize = tables().map(<[Entity]>::len).sum();
    let rows = &mut *rows;
    let changed = AtomicBool::new(rows.entities.len() != count);
    rows.entities.resize(count, Entity::PLACEHOLDER);
    rows.first = execution.owned(count).start;
    rows.all = execution.team().map_or(count, Team::rows);
    predicted.0.resize(rows.all + 1, SENTINEL);
    predicted.0[rows.all] = SENTINEL;
    let mut first = 0;
    for entities in in_order(tables(), |table| table) {
        let of_table = &mut rows.entities[first..first + entities.len()];
        execution.for_each_chunk(of_table, |first, rows| {
            let entities = &entities[first..first + rows.len()];
            if rows != entities {
                changed.store(true, Relaxed);
                rows.copy_from_slice(entities);
            }
        });
        first += entities.len();
    }
    rows.changed = changed.into_inner();
    rows.generation += 1;
    rows.gathered = now.this_run();
}

/// Refuses a step in which particles came, went or changed tables since they were gathered (phase `Integrate`): their
/// new state would be written to others.
pub fn check_rows(
    fluid: Query<Entity, With<Fluid>>,
    rows: Res<Rows>,
    mut failure: ResMut<Failure>,
    execution: Res<Execution>,
) {
    let mut first = 0;
    let mut same = true;
    let tables = fluid.contiguous_iter().into_iter().flatten();
    for entities in in_order(tables, |table| table) {
        let known = rows.entities.get(first..first + entities.len());
        same &= known.is_some_and(|known| {
            let chunks = known.par_chunks(CHUNK).zip(entities.par_chunks(CHUNK));
            execution.install(|| chunks.all(|(known, present)| known == present))
        });
        first += entities.len();
    }
    if !same || first != rows.entities.len() {
        let (before, now) = (rows.entities.len(), first);
        failure.record(FailureCause::ParticlesChanged { before, now }, None);
    }
}
