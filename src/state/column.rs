//! What a column is, and the systems that carry one between the tables and the rows of a step.
//!
//! A column of the state is a component that lasts from step to step. Its row in the list of columns says everything
//! about it once: name, unit, how it is gathered and scattered, kept to go back to, and what it takes.

use std::ops::Range;

use bevy_ecs::{change_detection::Tick, prelude::*, system::SystemChangeTick};
use bytemuck::TransparentWrapper;
use glam::Vec3;
use smallvec::SmallVec;

use super::{
    execution::Execution,
    failure::{Failure, FailureCause},
    particle::{Fluid, Position, Pressure},
    remembered::LoadRows,
    rows::Rows,
    saved,
    stage::Systems,
    state_column::{GatheredColumn, Kept, StateColumn},
};
use crate::scene::Scene;

/// A column of values, one per fluid particle.
#[derive(Debug, Clone, Copy)]
pub struct Column {
    /// Its name.
    pub name: &'static str,
    /// SI unit; "-" if it has none.
    pub unit: &'static str,
    /// What it is.
    pub about: &'static str,
    /// Whether other ranks need the rows near their border.
    pub halo: bool,
    /// Memory, change ticks and packed copies included \[bytes per particle].
    pub bytes: usize,
    /// Whether a scene asks for it.
    pub wanted: fn(&Scene) -> bool,
    /// How it lasts from step to step; none for a column that every step writes afresh.
    pub lasting: Option<Lasting>,
}

/// A column's bytes, or why there are none.
pub(crate) type Bytes = Result<Vec<u8>, String>;

/// What carries a column of the state from step to step.
#[derive(Debug, Clone, Copy)]
pub struct Lasting {
    /// Refuses a step in which a particle lacks it.
    pub(crate) check: Option<fn() -> Systems>,
    /// Copies it into rows at the start of a step.
    pub(crate) gather: Option<fn() -> Systems>,
    /// Copies it from other ranks into the rows of their particles.
    pub(crate) share: Option<fn() -> Systems>,
    /// Refuses a step in which a host wrote it after it was gathered.
    pub(crate) check_unwritten: fn() -> Systems,
    /// Copies rows into the tables at the end of a step.
    pub(crate) scatter: fn() -> Systems,
    /// Keeps what the tables hold before they take a new state.
    pub(crate) keep: fn() -> Systems,
    /// Inserts what keeping needs.
    pub(crate) install_keeping: fn(&mut World),
    /// Gives the particles, in the order of the rows, what was kept.
    pub(crate) restore: fn(&mut World, &[Entity]),
    /// Its values of particles as bytes.
    pub(crate) save: fn(&World, &[Entity]) -> Bytes,
    /// Gives particles the values that bytes hold.
    pub(crate) load: LoadRows,
    /// The bytes of all ranks' particles, from those of every rank.
    pub(crate) join: fn(&[Vec<u8>]) -> Bytes,
    /// The bytes of some of the rows.
    pub(crate) part: fn(&[u8], Range<usize>) -> Bytes,
    /// What is kept as bytes; none where nothing is.
    pub(crate) save_kept: fn(&World) -> Result<Option<Vec<u8>>, String>,
    /// Keeps what bytes hold.
    pub(crate) load_kept: fn(&mut World, &[u8]) -> Result<(), String>,
}

/// Bytes of the two change ticks that a table holds per component.
const TICKS: usize = 8;

impl Column {
    /// A column that every step writes afresh, of so many bytes per row.
    pub(crate) const fn derived(
        name: &'static str,
        unit: &'static str,
        about: &'static str,
        bytes: usize,
    ) -> Self {
        Self {
            name,
            unit,
            about,
            halo: false,
            bytes,
            wanted: |_| true,
            lasting: None,
        }
    }

    /// A column of the state whose rows take so many bytes.
    pub(crate) const fn lasting<C: StateColumn>(
        name: &'static str,
        unit: &'static str,
        about: &'static str,
        row_bytes: usize,
    ) -> Self {
        Self {
            name,
            unit,
            about,
            halo: true,
            bytes: size_of::<C>() + TICKS + row_bytes,
            wanted: |_| true,
            lasting: Some(Lasting {
                check: Some(|| check::<C>.into_configs()),
                gather: None,
                share: None,
                check_unwritten: || check_unwritten::<C>.into_configs(),
                scatter: || scatter::<C>.into_configs(),
                keep: || keep::<C>.into_configs(),
                install_keeping: |world| world.insert_resource(Kept::<C>(Vec::new())),
                restore: restore::<C>,
                save: saved::save::<C>,
                load: saved::load::<C>,
                join: saved::join::<C>,
                part: saved::part::<C>,
                save_kept: saved::save_kept::<C>,
                load_kept: saved::load_kept::<C>,
            }),
        }
    }

    /// The same, copied into rows at the start of a step.
    pub(crate) const fn gathered<C: GatheredColumn>(mut self) -> Self {
        if let Some(lasting) = &mut self.lasting {
            lasting.gather = Some(|| gather::<C>.into_configs());
            lasting.share = Some(|| share::<C>.into_configs());
        }
        self
    }

    /// The same, in scenes that ask for it. Particles that a host spawned earlier may lack it.
    pub(crate) const fn only_if(mut self, wanted: fn(&Scene) -> bool) -> Self {
        self.wanted = wanted;
        if let Some(lasting) = &mut self.lasting {
            lasting.check = None;
        }
        self
    }

    /// The same, of which other ranks need rows near their border.
    pub(crate) const fn in_halo(mut self) -> Self {
        self.halo = true;
        self
    }
}

/// Tables in one order for all queries. Bevy goes through new tables in the order of a hash map: a query that saw them
/// in one go (its system skipped a failed step) has another order than one that saw them in two.
pub(crate) fn in_order<T>(
    tables: impl IntoIterator<Item = T>,
    entities: impl Fn(&T) -> &[Entity],
) -> impl Iterator<Item = T> {
    // Room for the tables of most hosts without an allocation.
    let mut tables: SmallVec<[T; 4]> = tables.into_iter().collect();
    tables.sort_unstable_by_key(|table| entities(table).first().copied());
    tables.into_iter()
}

/// Refuses a step of particles that lack a component (phase `RebuildIndex`): they would take no part in it.
pub(super) fn check<C: StateColumn>(
    fluid: Query<(Entity, Has<C>), With<Fluid>>,
    places: Query<&Position>,
    failure: ResMut<Failure>,
) {
    refuse_lack(fluid, places, failure, C::COMPONENT);
}

/// The same for a component that is no column.
pub(crate) fn refuse_lack<C: Component>(
    fluid: Query<(Entity, Has<C>), With<Fluid>>,
    places: Query<&Position>,
    mut failure: ResMut<Failure>,
    component: &'static str,
) {
    let tables = fluid.contiguous_iter().into_iter().flatten();
    let mut first = None;
    let mut particles = 0;
    for (entities, _) in in_order(tables, |table| table.0).filter(|table| !table.1) {
        first = first.or(entities.first().copied());
        particles += entities.len();
    }
    if let Some(first) = first {
        let at = places.get(first).map_or(Vec3::NAN, |x| x.0);
        let cause = FailureCause::LacksComponent {
            component,
            particles,
        };
        failure.record_of(cause, (first, at));
    }
}

/// Copies a column of all tables into rows (phase `RebuildIndex`). A value that is not finite, or too large to be
/// squared, fails the step here, where its own particle is known: later its neighbours have it, too.
fn gather<C: GatheredColumn>(
    fluid: Query<(Entity, Option<&C>, &Pressure), With<Fluid>>,
    mut start: ResMut<C::Start>,
    mut failure: ResMut<Failure>,
    rows: Res<Rows>,
    execution: Res<Execution>,
) {
    C::resize(&mut start, rows.all);
    let mut first = rows.first;
    let mut unusable = None;
    let tables = fluid.contiguous_iter().into_iter().flatten();
    for (entities, values, pressures) in in_order(tables, |table| table.0) {
        let values = values
            .map(C::peel_slice)
            .or_else(|| C::stand_in(Pressure::peel_slice(pressures)));
        if let Some(values) = values {
            unusable = unusable.or(C::gather(&mut start, first, values, &execution));
        }
        first += entities.len();
    }
    if let Some((row, is_large)) = unusable {
        let quantity = C::QUANTITY;
        let cause = if is_large {
            FailureCause::TooLarge { quantity }
        } else {
            FailureCause::NotFinite { quantity }
        };
        failure.record(cause, Some(row));
    }
}

fn share<C: GatheredColumn>(mut start: ResMut<C::Start>, execution: Res<Execution>) {
    C::share(&mut start, &execution);
}

/// Refuses a step in which the tables changed since they were gathered (phase `Integrate`): its result would overwrite
/// what a host wrote.
fn check_unwritten<C: StateColumn>(
    fluid: Query<(Entity, Option<Ref<C>>), With<Fluid>>,
    places: Query<&Position>,
    mut failure: ResMut<Failure>,
    rows: Res<Rows>,
    now: SystemChangeTick,
) {
    let is_late = |tick: &Tick| tick.is_newer_than(rows.gathered, now.this_run());
    let tables = fluid.contiguous_iter().into_iter().flatten();
    for (entities, values) in in_order(tables, |table| table.0) {
        let Some(values) = values else { continue };
        if let Some(row) = values.changed_ticks_slice().iter().position(is_late) {
            let at = places.get(entities[row]).map_or(Vec3::NAN, |x| x.0);
            let component = C::COMPONENT;
            failure.record_of(FailureCause::Overwritten { component }, (entities[row], at));
            return;
        }
    }
}

/// Writes a column of the step's result into the tables and marks it as changed (phase `Integrate`).
fn scatter<C: StateColumn>(
    mut fluid: Query<(Entity, Option<&mut C>), With<Fluid>>,
    result: Res<C::Result>,
    execution: Res<Execution>,
) {
    let mut first = execution.owned(0).start;
    let tables = fluid.contiguous_iter_mut().into_iter().flatten();
    for (entities, values) in in_order(tables, |table| table.0) {
        let rows = first..first + entities.len();
        first = rows.end;
        if let Some(mut values) = values {
            // One `deref_mut` for the column: it marks all its rows.
            let values: &mut [C] = &mut values;
            C::scatter(&result, rows, C::peel_slice_mut(values), &execution);
        }
    }
}

fn keep<C: StateColumn>(
    mut kept: ResMut<Kept<C>>,
    fluid: Query<(Entity, Option<&C>, &Pressure), With<Fluid>>,
) {
    kept.0.clear();
    let tables = fluid.contiguous_iter().into_iter().flatten();
    for (_, values, pressures) in in_order(tables, |table| table.0) {
        match values {
            Some(values) => kept.0.extend_from_slice(values),
            None => {
                let stand_in = C::stand_in(Pressure::peel_slice(pressures)).unwrap_or_default();
                kept.0.extend_from_slice(C::wrap_slice(stand_in));
            }
        }
    }
}

fn restore<C: StateColumn>(world: &mut World, entities: &[Entity]) {
    world.resource_scope(|world, kept: Mut<Kept<C>>| {
        let mut values = world.query::<&mut C>();
        for (&entity, kept) in entities.iter().zip(&kept.0) {
            if let Ok(mut value) = values.get_mut(world, entity) {
                *value = *kept;
            }
        }
    });
}
