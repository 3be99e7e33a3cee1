//! Reordering along the Z-curve (paper 4.5.4), by moving rows: an entity goes on naming its particle, with every
//! component a host gave it.
//!
//! Option 1: permute the values of the columns, 13–22 ns per row; but then an entity names a place and no particle, and
//! a host's own components stay behind. Option 2: move rows. A table marker that is inserted (or removed) in the wanted
//! order moves each row to the end of another table, which is then in that order, about 350 ns per row: 1 to 5 % of
//! twenty-five steps. We use 2. Rows are taken last first, which saves the swap that fills a hole, so the Z-curve runs
//! through the table upwards and downwards in turn.

use bevy_ecs::prelude::*;
use glam::Vec4;

use crate::{
    index::{FluidIndex, z_curve},
    neighbours::{BoundaryNeighbours, FluidNeighbours},
    state::{
        Clock, Execution, Phase, Remembers, Stage, in_order,
        particle::{Fluid, Position},
    },
};

/// Rows along the Z-curve, every `reorder_interval` steps of the scene.
pub(crate) const STAGE: Stage = Stage {
    invalidates: true,
    wanted: |scene| scene.reorder_interval > 0,
    install: |world, scene| world.insert_resource(ReorderState::new(scene.reorder_interval)),
    ..Stage::new("reorder", Phase::Reorder, |_| {
        reorder.run_if(reorder_is_due)
    })
};

/// Which of two tables a particle's row is in.
#[derive(Component, Debug, Clone, Copy)]
pub struct Reordered;

/// Steps between two reorderings, and how the rows lie.
#[derive(Resource, Debug, Clone)]
pub struct ReorderState {
    /// Steps between two reorderings.
    pub(crate) interval: u32,
    /// Whether rows lie in the tables with the marker.
    marked: bool,
    /// Whether rows lie against the Z-curve.
    pub(crate) downwards: bool,
    handles: Vec<z_curve::Handle>,
    entities: Vec<Entity>,
    points: Vec<Vec4>,
}

impl ReorderState {
    /// Steps between two reorderings.
    pub fn interval(&self) -> u32 {
        self.interval
    }

    /// Every `interval` steps; particles are spawned along the Z-curve and without the marker.
    pub fn new(interval: u32) -> Self {
        Self {
            interval,
            marked: false,
            downwards: false,
            handles: Vec::new(),
            entities: Vec::new(),
            points: Vec::new(),
        }
    }
}

impl Remembers for ReorderState {
    type State = (bool, bool);

    fn state(&self, _: &[Entity]) -> Self::State {
        (self.marked, self.downwards)
    }

    fn set_state(&mut self, state: Self::State, _: &[Entity]) -> Result<(), &'static str> {
        (self.marked, self.downwards) = state;
        Ok(())
    }
}

/// Whether rows lie in the tables with the marker, where new ones belong.
pub(crate) fn is_marked(world: &World) -> bool {
    let state = world.get_resource::<ReorderState>();
    state.is_some_and(|state| state.marked)
}

/// In a table that holds rows while the others are filled in a given order.
#[derive(Component)]
struct Waiting;

/// Moves rows into the order of `entities`, all to the side where rows lie.
pub(crate) fn arrange(world: &mut World, entities: &[Entity]) {
    let marked = is_marked(world);
    for &entity in entities {
        if let Ok(mut particle) = world.get_entity_mut(entity) {
            particle.insert(Waiting);
            if marked {
                particle.insert(Reordered);
            } else {
                particle.remove::<Reordered>();
            }
        }
    }
    // A row that leaves a table goes to the end of the next.
    for &entity in entities {
        if let Ok(mut particle) = world.get_entity_mut(entity) {
            particle.remove::<Waiting>();
        }
    }
    if let Some(mut index) = world.get_resource_mut::<FluidIndex>() {
        index.reordered = true;
    }
}

/// Whether this step ends with a reordering.
pub fn reorder_is_due(state: Res<ReorderState>, clock: Res<Clock>) -> bool {
    clock.step.is_multiple_of(u64::from(state.interval.max(1)))
}

/// Moves every row to its place along the Z-curve (phase `Reorder`).
pub fn reorder(world: &mut World) {
    world.resource_scope(|world, mut state: Mut<ReorderState>| {
        let state = &mut *state;
        let execution = world.resource::<Execution>().clone();
        state.entities.clear();
        state.points.clear();
        // In the order of the rows: particles of one cell keep it, whichever tables they were in.
        let mut fluid = world.query_filtered::<(Entity, &Position), With<Fluid>>();
        let tables = fluid.contiguous_iter(world).into_iter().flatten();
        for (entities, positions) in in_order(tables, |table| table.0) {
            state.entities.extend_from_slice(entities);
            state
                .points
                .extend(positions.iter().map(|x| x.0.extend(0.0)));
        }
        gather_strays(world, state.marked);
        let grid = world.resource::<FluidIndex>().structure.grid();
        z_curve::sort_handles(&state.points, grid, &execution, &mut state.handles);
        let entity = |handle: &z_curve::Handle| state.entities[handle.1 as usize];
        if !state.downwards {
            state.handles.reverse();
        }
        move_rows(world, state.marked, state.handles.iter().map(entity));
        let old_rows = state.handles.iter().map(|handle| handle.1 as usize);
        if let Some(mut lists) = world.get_resource_mut::<FluidNeighbours>() {
            lists.lists.expect_order(old_rows.clone());
        }
        if let Some(mut lists) = world.get_resource_mut::<BoundaryNeighbours>() {
            lists.0.expect_order(old_rows);
        }
        state.marked = !state.marked;
        state.downwards = !state.downwards;
    });
    world.resource_mut::<FluidIndex>().reordered = true;
}

/// Moves every row to the place it had when the rows were of `entities`.
pub(crate) fn bring_back(world: &mut World, entities: &[Entity], downwards: bool) {
    world.resource_scope(|world, mut state: Mut<ReorderState>| {
        gather_strays(world, state.marked);
        move_rows(world, state.marked, entities.iter().copied());
        state.marked = !state.marked;
        state.downwards = downwards;
    });
}

/// Moves the rows of `entities`, in this order, from the one side to the other.
fn move_rows(world: &mut World, marked: bool, entities: impl Iterator<Item = Entity>) {
    for entity in entities {
        if let Ok(mut particle) = world.get_entity_mut(entity) {
            if marked {
                particle.remove::<Reordered>();
            } else {
                particle.insert(Reordered);
            }
        }
    }
}

/// Brings particles that a host spawned since the last time to the side where the others are, so that no row waits in
/// the table that the others move to.
fn gather_strays(world: &mut World, marked: bool) {
    if marked {
        let mut strays = world.query_filtered::<Entity, (With<Fluid>, Without<Reordered>)>();
        let strays: Vec<Entity> = strays.iter(world).collect();
        strays.into_iter().for_each(|stray| {
            world.entity_mut(stray).insert(Reordered);
        });
    } else {
        let mut strays = world.query_filtered::<Entity, (With<Fluid>, With<Reordered>)>();
        let strays: Vec<Entity> = strays.iter(world).collect();
        strays.into_iter().for_each(|stray| {
            world.entity_mut(stray).remove::<Reordered>();
        });
    }
}
