//! A scene on several ranks: worlds that share its particles and take every step together, with the same bits as one.
//!
//! Every rank owns a range of the run's rows, along the Z-curve, in whole chunks, and has the rows of others around its
//! own, the halo. Systems work on the rows that are here; they know of no ranks. What they make of the halo's rows is
//! replaced by what the owners made of theirs, at these places:
//!
//! - before `gather` the halo is found, after it the state is copied into it;
//! - after `density` densities are, before `pressure` accelerations;
//! - within `pressure` the pressure terms, the pressures and their accelerations.
//!
//! Results of chunks of rows are gathered and folded in the order of the run's rows, as are failures, after every stage
//! ([`Execution`] does so). Why and how is in `docs/decisions/ranks.md`.

mod halo;
mod reorder;
mod unsupported;

use bevy_ecs::prelude::*;

pub use self::unsupported::Unsupported;
pub(crate) use self::unsupported::{check_checkpoints, unsupported};
use crate::{
    registry::columns,
    reorder::reorder_is_due,
    scene::Scene,
    state::{
        Accelerations, CHUNK, Densities, Execution, Systems, chain, particle::replace_next_number,
    },
};

/// Systems that run before a stage.
pub(crate) fn before(stage: &str) -> Option<Systems> {
    match stage {
        "gather" => Some(halo::find_halo.into_configs()),
        "pressure" => Some(share_accelerations.into_configs()),
        _ => None,
    }
}

/// Systems that run after a stage.
pub(crate) fn after(stage: &str, scene: &Scene) -> Option<Systems> {
    match stage {
        "gather" => {
            let lasting = columns(scene).filter_map(|column| column.lasting);
            let shared = lasting.filter_map(|column| Some((column.share?)()));
            Some(chain(shared.collect()))
        }
        "density" => Some(share_densities.into_configs()),
        _ => None,
    }
}

/// Systems that run in the place of a stage's.
pub(crate) fn instead_of(stage: &str) -> Option<Systems> {
    (stage == "reorder").then(|| reorder::reorder.run_if(reorder_is_due))
}

/// Inserts what reordering over several ranks needs.
pub(crate) fn install(world: &mut World, scene: &Scene) {
    if world.resource::<Execution>().team().is_some() {
        let lasting = columns(scene).filter_map(|column| column.lasting);
        world.insert_resource(reorder::Travelling(lasting.collect()));
    }
}

fn share_densities(mut densities: ResMut<Densities>, execution: Res<Execution>) {
    execution.share(&mut densities.0);
}

fn share_accelerations(mut accelerations: ResMut<Accelerations>, execution: Res<Execution>) {
    execution.share(&mut accelerations.0);
}

/// Runs `spawn` with the rows of the run, of so many, that this rank spawns; all of them on one rank. Particles have
/// the numbers that they have there.
pub(crate) fn spawn_own(
    world: &mut World,
    rows: usize,
    spawn: impl FnOnce(&mut World, std::ops::Range<usize>),
) {
    let mut execution = world.resource_mut::<Execution>();
    let Some(mut team) = execution.team().cloned() else {
        return spawn(world, 0..rows);
    };
    team.distribute(rows as u64, CHUNK as u64);
    let range = team.range();
    execution.set_team(Some(team));
    let first = replace_next_number(world, 0);
    replace_next_number(world, first + range.start as u32);
    spawn(world, range.start as usize..range.end as usize);
    replace_next_number(world, first + rows as u32);
}
