//! Reordering along the Z-curve (paper 4.5.4), by moving rows: an entity goes on naming its particle, with every
//! component a host gave it.
//!
//! Option 1: permute the values of the columns, 13–22 ns per row; but then an entity names a place and no particle, and
//! a host's own components stay behind. Option 2: move rows. A table marker that is inserted (or removed) in the wanted
//! order moves each row to the end of another table, which is then in that order, about 350 ns per row: 1 to 5 % of
//! twenty-five steps. We use 2. Rows are taken last first, which saves the swap that fills a hole, so the Z-curve runs
//! through the table upwards and downwards in turn.
//!
//! The second table takes as much memory as the first for ever. Of more than [`MANY`] rows each goes out of its table
//! and back to its end instead, which changes places with the last row: twice the moves, and no second table.

use std::{collections::BTreeMap, iter};

use bevy_ecs::{
    prelude::*,
    storage::{Table, TableId},
};
use glam::Vec4;

use crate::{
    index::{FluidIndex, z_curve},
    neighbours::{BoundaryNeighbours, FluidNeighbours},
    pairs::KernelGradients,
    scene::RowOrder,
    state::{
        Clock, Execution, Phase, Remembers, Stage, in_order,
        particle::{Fluid, Position},
    },
};

/// Rows along the Z-curve, every `reorder_interval` steps of the scene.
pub(crate) const STAGE: Stage = Stage {
    invalidates: true,
    wanted: |scene| scene.reorder_interval > 0,
    install: |world, scene| {
        let state = ReorderState::new(scene.reorder_interval).by(scene.reorder_by);
        world.insert_resource(state);
    },
    ..Stage::new("reorder", Phase::Reorder, |_| {
        reorder.run_if(reorder_is_due)
    })
};

/// From so many rows on they change places within their tables.
const MANY: usize = 1 << 20;

/// Memory that reordering so many rows with `components` lasting components of their own takes beside the rows
/// \[bytes]: the second table, with their change ticks and entities, and what is sorted.
pub(crate) fn bytes(rows: f64, components: usize) -> f64 {
    if rows > MANY as f64 {
        // Less than what is freed for it.
        return 0.0;
    }
    // Position and velocity, their ticks; density, pressure and number; the two marks; the entity, twice.
    let known = 2.0 * 20.0 + 3.0 * 12.0 + 2.0 * 8.0 + 8.0 + 12.0;
    let sorted = 8.0 + 16.0 + 16.0;
    rows * (known + 12.0 * components as f64 + sorted)
}

/// Which of two tables a particle's row is in.
#[derive(Component, Debug, Clone, Copy)]
pub struct Reordered;

/// Steps between two reorderings, and how the rows lie.
#[derive(Resource, Debug, Clone)]
pub struct ReorderState {
    /// Steps between two reorderings.
    pub(crate) interval: u32,
    /// What orders them.
    by: RowOrder,
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
            by: RowOrder::ZCurve,
            marked: false,
            downwards: false,
            handles: Vec::new(),
            entities: Vec::new(),
            points: Vec::new(),
        }
    }
}

impl ReorderState {
    /// Lets so many rows of a run lie the other way along the curve, if they are moved; true if they lie against it.
    pub(crate) fn turn(&mut self, rows: usize) -> bool {
        self.downwards ^= rows <= MANY;
        self.downwards
    }

    /// In another order.
    fn by(self, by: RowOrder) -> Self {
        Self { by, ..self }
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
        let rows = fluid.iter(world).len();
        if rows > MANY {
            // They belong to the order before, and leave room for what follows.
            if let Some(mut gradients) = world.get_resource_mut::<KernelGradients>() {
                gradients.free();
            }
        }
        state.entities.reserve_exact(rows);
        state.points.reserve_exact(rows);
        let tables = fluid.contiguous_iter(world).into_iter().flatten();
        for (entities, positions) in in_order(tables, |table| table.0) {
            state.entities.extend_from_slice(entities);
            state
                .points
                .extend(positions.iter().map(|x| x.0.extend(0.0)));
        }
        gather_strays(world, state.marked);
        let grid = world.resource::<FluidIndex>().structure.grid();
        z_curve::sort_handles(
            &state.points,
            (grid, state.by),
            &execution,
            &mut state.handles,
        );
        let many = rows > MANY;
        // Rows that change places have the shortest way where the curve keeps its direction.
        if state.turn(rows) {
            state.handles.reverse();
        }
        let entity = |handle: &z_curve::Handle| state.entities[handle.1 as usize];
        let ordered = state.handles.iter().map(entity);
        if many {
            state.points = Vec::new();
            swap_rows(world, state.marked, ordered);
        } else {
            move_rows(world, state.marked, ordered);
            state.marked = !state.marked;
        }
        let old_rows = state.handles.iter().map(|handle| handle.1 as usize);
        if let Some(mut lists) = world.get_resource_mut::<FluidNeighbours>() {
            lists.lists.expect_order(old_rows.clone());
        }
        if let Some(mut lists) = world.get_resource_mut::<BoundaryNeighbours>() {
            lists.0.expect_order(old_rows);
        }
        if many {
            (state.handles, state.entities) = (Vec::new(), Vec::new());
        }
    });
    world.resource_mut::<FluidIndex>().reordered = true;
}

/// Moves every row to the place it had when the rows were of `entities`.
pub(crate) fn bring_back(world: &mut World, entities: &[Entity], downwards: bool) {
    world.resource_scope(|world, mut state: Mut<ReorderState>| {
        gather_strays(world, state.marked);
        if entities.len() > MANY {
            swap_rows(world, state.marked, entities.iter().copied());
        } else {
            move_rows(world, state.marked, entities.iter().copied());
            state.marked = !state.marked;
        }
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

/// Gives the rows of every table the order of `entities`, within the table.
fn swap_rows(world: &mut World, marked: bool, entities: impl Iterator<Item = Entity>) {
    // Where the row at each place of a table belongs, and how many of them are known.
    let mut tables: BTreeMap<u32, (Vec<u32>, u32)> = BTreeMap::new();
    for entity in entities {
        let Ok(particle) = world.get_entity(entity) else {
            continue;
        };
        let at = particle.location();
        let (belongs, known) = tables.entry(at.table_id.as_u32()).or_insert_with(|| {
            let rows = rows_of(world, at.table_id.as_u32());
            ((0..rows.len() as u32).collect(), 0)
        });
        belongs[at.table_row.index()] = *known;
        *known += 1;
    }
    for (table, (belongs, known)) in tables {
        // Else rows that nobody named would have no place.
        if belongs.len() == known as usize {
            swap_rows_of(world, marked, (table, belongs));
        }
    }
}

/// The entities of a table.
fn rows_of(world: &World, table: u32) -> &[Entity] {
    let table = world.storages().tables.get(TableId::from_u32(table));
    table.map_or(&[], Table::entities)
}

/// The same for a table, by exchanges with its last row.
fn swap_rows_of(world: &mut World, marked: bool, (table, mut belongs): (u32, Vec<u32>)) {
    let Some(last) = belongs.len().checked_sub(1) else {
        return;
    };
    let mut settled = 0;
    loop {
        let place = if belongs[last] as usize != last {
            belongs[last] as usize
        } else {
            while settled < last && belongs[settled] as usize == settled {
                settled += 1;
            }
            settled
        };
        if place == last {
            return;
        }
        let Some(&entity) = rows_of(world, table).get(place) else {
            return;
        };
        // The last row fills the place of one that goes; back in the table it is the last.
        move_rows(world, marked, iter::once(entity));
        move_rows(world, !marked, iter::once(entity));
        belongs.swap(place, last);
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

#[cfg(test)]
mod tests {
    use super::*;

    #[derive(Component)]
    struct Tag;

    /// Rows of all tables that hold fluid, by table.
    fn rows(world: &mut World) -> Vec<Vec<Entity>> {
        let mut fluid = world.query_filtered::<(Entity, &Position), With<Fluid>>();
        let tables = fluid.contiguous_iter(world).into_iter().flatten();
        let mut rows: Vec<Vec<Entity>> = tables.map(|table| table.0.to_vec()).collect();
        rows.retain(|rows| !rows.is_empty());
        rows.sort_by_key(|rows| rows.iter().min().copied());
        rows
    }

    /// Exchanges within a table give every table the order that moves to another one give it, whatever the order is.
    #[test]
    fn rows_that_change_places_come_into_the_same_order_as_rows_that_move() {
        let mut seed = 7_u64;
        let mut random = |below: usize| {
            seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
            (seed >> 33) as usize % below
        };
        for count in [0, 1, 2, 3, 50, 400] {
            for tagged in [0, 3, 7] {
                let mut world = World::new();
                let mut entities: Vec<Entity> = (0..count)
                    .map(|k| match tagged > 0 && k % tagged == 0 {
                        true => world.spawn((Fluid, Tag)).id(),
                        false => world.spawn(Fluid).id(),
                    })
                    .collect();
                for _ in 0..3 {
                    // Some stay where they are.
                    for k in 0..count / 2 {
                        entities.swap(random(count), 2 * k);
                    }
                    swap_rows(&mut world, false, entities.iter().copied());
                    let swapped = rows(&mut world);
                    move_rows(&mut world, false, entities.iter().copied());
                    assert_eq!(swapped, rows(&mut world), "{count} {tagged}");
                    move_rows(&mut world, true, entities.iter().copied());
                }
            }
        }
    }
}
