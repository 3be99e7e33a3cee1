//! Rolling back: the state before the last step is kept, and restored if the next step fails.
//!
//! A failed step is rejected before the tables change, so the run is one step back already; the kept state makes it
//! two. States are restored by entity, and rows return to their old order: sums depend on the order of rows, so a
//! repeated step with the same dt is bitwise equal. Changes by a host since then are lost. If particles were added or
//! removed, the kept state does not fit, and only the failed step is undone.
//!
//! Data that a method keeps between steps is a component and is restored likewise, for example pressures for the warm
//! start.

use bevy_ecs::{entity::EntityHashMap, prelude::*};
use serde::{Deserialize, Serialize};

use super::{adaptive::AdaptiveTimeStep, recovery::RecoveryTime};
use crate::{
    flow::changes,
    index::FluidIndex,
    integrate::Motion,
    reorder::{self, ReorderState},
    state::{
        Clock, Execution, Failure, Lasting, Material, Remembers, TakenBack, in_order,
        particle::{Fluid, ParticleId, gather_particles, replace_next_number},
    },
};

/// The state before the last successful step, with its clock.
#[derive(Resource, Debug, Default)]
pub struct KeptState {
    /// Whether a state is kept: not before the first step, and not after it was restored.
    kept: bool,
    clock: Clock,
    recovery: Option<RecoveryTime>,
    largest_error: f32,
    downwards: bool,
    /// Entities in the order of rows; kept columns have the same order.
    entities: Vec<Entity>,
    /// Their numbers, on several ranks: particles may go to another, and come back as other entities.
    numbers: Vec<u32>,
    /// The kept columns.
    columns: Vec<Lasting>,
}

/// A kept state in a checkpoint; particles by the rows that they have now.
#[derive(Debug, Default, Serialize, Deserialize)]
pub(crate) struct SavedState {
    kept: bool,
    clock: Clock,
    recovery: Option<RecoveryTime>,
    largest_error: f32,
    downwards: bool,
    rows: Vec<u32>,
}

impl Remembers for KeptState {
    type State = SavedState;

    fn state(&self, rows: &[Entity]) -> SavedState {
        let row_of: EntityHashMap<u32> = rows.iter().copied().zip(0..).collect();
        // A particle that is gone has no row: then the state is one of other particles, and stays so.
        let row = |entity| row_of.get(entity).copied().unwrap_or(u32::MAX);
        SavedState {
            kept: self.kept,
            clock: self.clock,
            recovery: self.recovery,
            largest_error: self.largest_error,
            downwards: self.downwards,
            rows: self.entities.iter().map(row).collect(),
        }
    }

    fn set_state(&mut self, state: SavedState, rows: &[Entity]) -> Result<(), &'static str> {
        let entity = |&row: &u32| rows.get(row as usize).copied();
        self.entities = (state.rows.iter())
            .map(|row| entity(row).unwrap_or(Entity::PLACEHOLDER))
            .collect();
        self.kept = state.kept;
        self.clock = state.clock;
        self.recovery = state.recovery;
        self.largest_error = state.largest_error;
        self.downwards = state.downwards;
        Ok(())
    }
}

/// Memory of the kept state besides the columns \[bytes per fluid particle].
pub const KEPT_BYTES: usize = size_of::<Entity>();

/// Selects the columns to keep.
pub(crate) fn install(world: &mut World, columns: Vec<Lasting>) {
    for column in &columns {
        (column.install_keeping)(world);
    }
    world.insert_resource(KeptState {
        columns,
        ..KeptState::default()
    });
}

/// Keeps the present state before the tables change (phase `Integrate`, if the step succeeded).
pub fn keep_state(
    mut kept: ResMut<KeptState>,
    fluid: Query<Entity, With<Fluid>>,
    adaptive: Res<AdaptiveTimeStep>,
    reorder: Option<Res<ReorderState>>,
    recovery: Option<Res<RecoveryTime>>,
    clock: Res<Clock>,
    (execution, numbers): (Res<Execution>, Query<&ParticleId>),
) {
    let kept = &mut *kept;
    kept.kept = true;
    kept.clock = *clock;
    kept.recovery = recovery.map(|recovery| *recovery);
    kept.largest_error = adaptive.largest_error;
    kept.downwards = reorder.is_some_and(|state| state.downwards);
    kept.entities.clear();
    let tables = fluid.contiguous_iter().into_iter().flatten();
    for entities in in_order(tables, |table| table) {
        kept.entities.extend_from_slice(entities);
    }
    if execution.team().is_some() {
        let number = |&entity: &Entity| numbers.get(entity).map_or(0, |id| id.get());
        kept.numbers.clear();
        kept.numbers.extend(kept.entities.iter().map(number));
    }
}

/// Rolls back if the step failed and a shorter one may succeed (phase `Observe`).
pub fn roll_back(world: &mut World) {
    let clock = *world.resource::<Clock>();
    let mut adaptive = world.resource_mut::<AdaptiveTimeStep>();
    adaptive.taken_back = None;
    let may_go_back = adaptive.may_go_back(clock.dt);
    if !may_go_back || !world.resource::<Failure>().depends_on_the_time_step() {
        return;
    }
    world.resource_scope(|world, mut adaptive: Mut<AdaptiveTimeStep>| {
        let h = world.resource::<Material>().kernel.support_radius;
        let motion = world.resource::<Motion>();
        let dt = adaptive.go_back(&clock, h, motion.max_speed, motion.max_acceleration);
        let older = world.resource_scope(|world, mut kept: Mut<KeptState>| {
            let restored = std::mem::take(&mut kept.kept) && restore(world, &kept);
            if let (true, Some(recovery)) = (restored, kept.recovery) {
                world.insert_resource(recovery);
            }
            restored.then_some((kept.clock, kept.largest_error))
        });
        let (reached, largest_error) = older.unwrap_or((clock, adaptive.largest_error));
        adaptive.largest_error = largest_error;
        *world.resource_mut::<Clock>() = Clock {
            dt: clock.dt,
            next_dt: dt,
            until: clock.until,
            ..reached
        };
        if let Some((cause, particle)) = world.resource_mut::<Failure>().forgive() {
            adaptive.taken_back = Some(TakenBack {
                steps: (clock.step + 1 - reached.step) as u32,
                cause,
                particle,
            });
        }
    });
}

/// Restores state and row of every particle. Returns false and changes nothing if the particles differ.
fn restore(world: &mut World, kept: &KeptState) -> bool {
    if world.resource::<Execution>().team().is_some() {
        let next = replace_next_number(world, 0);
        let entities = gather_particles(world, &kept.numbers);
        replace_next_number(world, next);
        if let Some(mut state) = world.get_resource_mut::<ReorderState>() {
            state.downwards = kept.downwards;
        }
        reorder::arrange(world, &entities);
        for column in &kept.columns {
            (column.restore)(world, &entities);
        }
        return true;
    }
    let present = rows(world);
    let Some(entities) = changes::undo(world, &kept.entities, &present) else {
        return false;
    };
    let mut present = rows(world);
    if present != entities {
        let mut before = entities.clone();
        present.sort_unstable();
        before.sort_unstable();
        if present != before {
            return false;
        }
        if world.contains_resource::<ReorderState>() {
            reorder::bring_back(world, &entities, kept.downwards);
        } else {
            reorder::arrange(world, &entities);
        }
        world.resource_mut::<FluidIndex>().reordered = true;
    }
    for column in &kept.columns {
        (column.restore)(world, &entities);
    }
    true
}

/// The fluid particles in the order of the rows.
fn rows(world: &mut World) -> Vec<Entity> {
    let mut fluid = world.query_filtered::<Entity, With<Fluid>>();
    let mut rows = Vec::new();
    let tables = fluid.contiguous_iter(world).into_iter().flatten();
    for entities in in_order(tables, |table| table) {
        rows.extend_from_slice(entities);
    }
    rows
}
