//! Resources of the engine, sealed where its systems pause: what a host's system writes there, or exchanges with the
//! resource of another world, is found by its change tick before a system of the engine reads it.
//!
//! Option 1: compare lengths where columns are read, in forty places; columns of equal length pass. Option 2: a mark of
//! the world in every type. Option 3: the change ticks that bevy keeps anyway, about sixty where a phase begins. We use
//! 3. What bypasses change detection is not found.

use std::sync::{
    Mutex, PoisonError,
    atomic::{AtomicU32, AtomicUsize, Ordering::Relaxed},
};

use bevy_ecs::{
    change_detection::Tick, component::ComponentId, prelude::*, system::SystemChangeTick,
};

use super::{
    clock::Clock,
    columns::Accelerations,
    failure::{Failure, FailureCause, healthy},
};

/// The resources, and when the engine's systems ran last.
#[derive(Resource, Debug, Default)]
pub(crate) struct Seal {
    resources: Vec<ComponentId>,
    tick: AtomicU32,
    /// A host may add to accelerations, but not change their number.
    accelerations: AtomicUsize,
    /// Written since, and not yet noted.
    found: Mutex<Vec<Written>>,
    /// Written and not yet mended.
    pub(crate) written: Vec<Written>,
    /// Number of steps before the one at hand.
    begun: u64,
    /// Whether only the engine's systems run in the step: then nothing is written within it.
    pub(crate) is_alone: bool,
}

/// A resource that a host wrote.
#[derive(Debug, Clone)]
pub(crate) struct Written {
    pub(crate) id: ComponentId,
    at: Tick,
    name: String,
}

impl Written {
    /// Whether it was written again since: a host has put it back.
    pub(crate) fn is_put_back(&self, world: &World) -> bool {
        let ticks = world.get_resource_change_ticks_by_id(self.id);
        ticks.is_some_and(|ticks| ticks.changed != self.at)
    }

    /// The failure of a step that meets it.
    pub(crate) fn cause(&self) -> FailureCause {
        FailureCause::ResourceWritten {
            resource: self.name.clone(),
        }
    }
}

impl Seal {
    /// Seals these resources from now on.
    pub(crate) fn put(world: &mut World, resources: Vec<ComponentId>) {
        world.insert_resource(Self {
            resources,
            ..Self::default()
        });
        reseal(world);
    }

    /// Seals what there is now.
    pub(crate) fn take(&self, world: &World, now: Tick) {
        self.accelerations.store(rows(world), Relaxed);
        self.tick.store(now.get(), Relaxed);
    }

    /// Notes what was written since the seal was taken.
    fn look(&self, world: &World, now: Tick) {
        let sealed = Tick::new(self.tick.load(Relaxed));
        let at = |id| {
            let ticks = world.get_resource_change_ticks_by_id(id);
            ticks.map(|ticks| ticks.changed)
        };
        let is_new = |&id: &ComponentId| at(id).is_some_and(|at| at.is_newer_than(sealed, now));
        let same = rows(world) == self.accelerations.load(Relaxed);
        let accelerations = world.component_id::<Accelerations>().filter(|_| !same);
        let written = self.resources.iter().copied().filter(is_new);
        let written = written.chain(accelerations).map(|id| Written {
            id,
            at: at(id).unwrap_or(now),
            name: (world.components().get_name(id))
                .map_or_else(String::new, |name| name.shortname().to_string()),
        });
        let mut found = self.found.lock().unwrap_or_else(PoisonError::into_inner);
        found.extend(written);
    }

    /// Takes over what was found; whether there is anything.
    fn note(&mut self) -> bool {
        let found = self.found.get_mut().unwrap_or_else(PoisonError::into_inner);
        self.written.append(found);
        !self.written.is_empty()
    }

    /// Begins a step: notes what was written between steps, except what was put back.
    pub(crate) fn begin(&mut self, world: &World, step: u64) {
        self.begun = step;
        let (back, rest) = std::mem::take(&mut self.written)
            .into_iter()
            .partition::<Vec<_>, _>(|written| written.is_put_back(world));
        self.look(world, world.read_change_tick());
        self.note();
        let is_back = |written: &Written| back.iter().any(|back| back.id == written.id);
        self.written.retain(|written| !is_back(written));
        self.written.extend(rest);
    }
}

/// Number of accelerations.
fn rows(world: &World) -> usize {
    let accelerations = world.get_resource::<Accelerations>();
    accelerations.map_or(0, |accelerations| accelerations.0.len())
}

/// Seals what the engine wrote between steps because a host called it.
pub(crate) fn reseal(world: &mut World) {
    let now = world.increment_change_tick();
    if let Some(mut seal) = world.remove_resource::<Seal>() {
        seal.take(world, now);
        seal.written.retain(|written| !written.is_put_back(world));
        world.insert_resource(seal);
    }
}

fn watching(world: &World) -> Option<&Seal> {
    world.get_resource::<Seal>().filter(|seal| !seal.is_alone)
}

/// Seals the resources (at the end of a step).
pub(crate) fn seal_at_end(world: &World, now: SystemChangeTick) {
    if let Some(seal) = world.get_resource::<Seal>() {
        seal.take(world, now.this_run());
    }
}

/// Seals the resources (after the systems of a phase).
pub(crate) fn seal(world: &World, now: SystemChangeTick) {
    if let Some(seal) = watching(world) {
        seal.take(world, now.this_run());
    }
}

/// Looks for resources that were written since (before the systems of a phase).
pub(crate) fn check(world: &World, now: SystemChangeTick) {
    if let Some(seal) = watching(world) {
        seal.look(world, now.this_run());
    }
}

/// Fails a step for them (after [`check`]), whatever failed before. Once the tables hold the new state the step is
/// good: what remains of it is left out, and the next one fails.
pub(crate) fn refuse(mut seal: ResMut<Seal>, clock: Res<Clock>, mut failure: ResMut<Failure>) {
    if !seal.note() || clock.step != seal.begun {
        return;
    }
    if let Some(written) = seal.written.first() {
        failure.record(written.cause(), None);
        failure.explain_without_particle(written.cause());
    }
}

/// Whether nothing went wrong so far and no resource was written: stages run only then.
pub(crate) fn is_whole(failure: Res<Failure>, seal: Res<Seal>) -> bool {
    healthy(failure) && seal.written.is_empty()
}
