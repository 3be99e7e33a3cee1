//! Particles that came and went since the state that a run may go back to, so that they can be undone.
//!
//! A particle that was removed comes back with its number, but as another entity: what a host gave it is lost.

use bevy_ecs::{entity::EntityHashSet, prelude::*};
use serde::{Deserialize, Serialize};

use super::sources::{Emitters, Turnover, has_emitters, removes};
use crate::{
    scene::{Scene, TimeStep},
    state::{
        Remembers,
        particle::{Fluid, give_number_back},
    },
};

/// Particles that came and went since the last state was kept. In scenes whose steps may be rolled back.
#[derive(Resource, Debug, Default)]
pub(crate) struct Changes {
    pub(super) came: Vec<Entity>,
    /// In the order of the rows, with their numbers.
    pub(super) gone: Vec<(Entity, u32)>,
    before: Counts,
}

/// Counts when the state was kept.
#[derive(Debug, Clone, Default, Serialize, Deserialize)]
struct Counts {
    turnover: Turnover,
    emitted: Vec<u64>,
}

/// Changes in a checkpoint: what came by rows, what went by numbers.
#[derive(Debug, Serialize, Deserialize)]
pub(crate) struct SavedChanges {
    came: Vec<u32>,
    gone: Vec<u32>,
    before: Counts,
}

impl Remembers for Changes {
    type State = SavedChanges;

    fn state(&self, rows: &[Entity]) -> SavedChanges {
        let came: EntityHashSet = self.came.iter().copied().collect();
        let numbered = (0..).zip(rows);
        let rows = numbered.filter(|(_, entity)| came.contains(*entity));
        SavedChanges {
            came: rows.map(|(row, _)| row).collect(),
            gone: self.gone.iter().map(|gone| gone.1).collect(),
            before: self.before.clone(),
        }
    }

    fn set_state(&mut self, state: SavedChanges, rows: &[Entity]) -> Result<(), &'static str> {
        let entity = |row: &u32| rows.get(*row as usize).copied();
        let came: Option<_> = state.came.iter().map(entity).collect();
        self.came = came.ok_or("its rows are mixed up")?;
        let gone = state.gone.into_iter();
        self.gone = gone.map(|number| (Entity::PLACEHOLDER, number)).collect();
        self.before = state.before;
        Ok(())
    }
}

/// Whether a scene has particles that come or go, and steps that may be rolled back.
pub(crate) fn are_kept(scene: &Scene) -> bool {
    let goes_back = matches!(scene.time_step, TimeStep::Adaptive(_));
    goes_back && (has_emitters(scene) || removes(scene))
}

/// Begins anew, when a state is kept (phase `Integrate`, if the step succeeded).
pub(crate) fn forget(
    mut changes: ResMut<Changes>,
    turnover: Res<Turnover>,
    emitters: Option<Res<Emitters>>,
) {
    changes.came.clear();
    changes.gone.clear();
    changes.before.turnover = *turnover;
    changes.before.emitted = emitters.map_or_else(Vec::new, |emitters| emitters.state(&[]));
}

/// Undoes what came and went since a state of the particles `kept` was kept, where now `present` are. Gives the
/// entities of that state; none, and nothing is changed, if others came or went besides.
pub(crate) fn undo(world: &mut World, kept: &[Entity], present: &[Entity]) -> Option<Vec<Entity>> {
    let Some(changes) = world.get_resource::<Changes>() else {
        return Some(kept.to_vec());
    };
    let came: EntityHashSet = changes.came.iter().copied().collect();
    let in_turn = changes.came.clone();
    let numbers: Vec<u32> = changes.gone.iter().map(|gone| gone.1).collect();
    let (turnover, emitted) = (changes.before.turnover, changes.before.emitted.clone());
    let there: EntityHashSet = present.iter().copied().collect();
    let stayed = present
        .iter()
        .filter(|entity| !came.contains(*entity))
        .count();
    let remain = kept.iter().filter(|entity| there.contains(*entity)).count();
    let explained = stayed == remain
        && kept.len() - remain == numbers.len()
        && present.len() - stayed == came.len();
    if !explained {
        return None;
    }
    for entity in in_turn {
        world.try_despawn(entity).ok();
    }
    let mut numbers = numbers.into_iter();
    let mut entities = kept.to_vec();
    for entity in &mut entities {
        if there.contains(entity) {
            continue;
        }
        // As many as there are numbers.
        *entity = world.spawn(Fluid).id();
        if let Some(number) = numbers.next() {
            give_number_back(world, *entity, number);
        }
    }
    world.insert_resource(turnover);
    if let Some(mut emitters) = world.get_resource_mut::<Emitters>() {
        // Of the same emitters.
        emitters.set_state(emitted, &[]).ok();
    }
    world.insert_resource(Changes::default());
    Some(entities)
}
