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

/// Refuses a step in which two particles have the same number (phase `RebuildIndex`).
pub(crate) fn check_numbers(
    fluid: Query<(Entity, &Position, &ParticleId), With<Fluid>>,
    mut failure: ResMut<Failure>,
    mut seen: Local<Vec<u64>>,
) {
    let tables = || {
        let tables = fluid.contiguous_iter().into_iter().flatten();
        in_order(tables, |table| table.0)
    };
    let ids = tables().flat_map(|(_, _, ids)| ids).map(|id| id.get());
    let [least, most, count] = ids.fold([u32::MAX, 0, 0], |[least, most, count], id| {
        [least.min(id), most.max(id), count + 1]
    });
    if count == 0 {
        return;
    }
    // Where few of many are left, numbers lie too far apart for a bit each: they share bits, and those that do are
    // compared.
    let bits = (u64::from(most - least) + 1).min(64 * u64::from(count));
    let words = bits.div_ceil(64) as usize;
    seen.clear();
    seen.resize(2 * words, 0);
    let (once, twice) = seen.split_at_mut(words);
    let place = |id: &ParticleId| {
        let bit = u64::from(id.get() - least) % bits;
        ((bit / 64) as usize, 1 << (bit % 64))
    };
    let mut shared = false;
    for (_, _, ids) in tables() {
        for (word, mask) in ids.iter().map(place) {
            let again = once[word] & mask;
            once[word] |= mask;
            twice[word] |= again;
            shared |= again != 0;
        }
    }
    if !shared {
        return;
    }
    let mut alike = Vec::new();
    for (entities, positions, ids) in tables() {
        for (row, id) in ids.iter().enumerate() {
            let (word, mask) = place(id);
            // All particles after the last number have that one.
            if twice[word] & mask != 0 && id.get() != u32::MAX {
                alike.push((id.get(), entities[row], positions[row].0));
            }
        }
    }
    alike.sort_by_key(|alike| alike.0);
    if let Some(pair) = alike.windows(2).find(|pair| pair[0].0 == pair[1].0) {
        let (number, entity, at) = pair[1];
        failure.record_of(FailureCause::SameNumber { number }, (entity, at));
    }
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
