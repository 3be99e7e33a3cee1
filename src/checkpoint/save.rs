//! Saves a world to a checkpoint.

use std::io::Write;

use bevy_ecs::prelude::*;
use serde::{Serialize, de::DeserializeOwned};

use super::{
    error::CheckpointError,
    file::{Checkpoint, SCENE},
};
use crate::{
    boundary::moving::{MovingWalls, RestPose},
    communicator::Team,
    ranks,
    registry::{REMEMBERED, columns},
    state::{
        BodyForces, Clock, Execution, Lasting, Rows, in_order,
        particle::{Boundary, BoundaryNormal, BoundaryVolume, Fluid, ParticleId, Position},
        to_bytes,
    },
    step::{Installed, between_steps},
};

/// Names of parts.
pub(super) const NUMBERS: &str = "particle numbers";
pub(super) const WALLS: &str = "walls";
pub(super) const TABLES: &str = "tables";
pub(super) const FILES: &str = "files";
pub(super) const STAGES: &str = "order of the stages";
pub(super) const SAME_ROWS: &str = "rows as in the last step";
pub(super) const COLUMN: &str = "column ";
pub(super) const KEPT: &str = "kept column ";

/// Writes the state of the scene in a world. Call it between steps. Disabled fluid particles and a host's own
/// components are not saved.
///
/// # Errors
/// If the operating system reports an error, or if stages of the scene's order that do not run in every step are
/// between two runs ([`steps_until_possible`]).
pub fn write(world: &mut World, writer: &mut impl Write) -> Result<(), CheckpointError> {
    Checkpoint::of(world)?.write(writer)
}

/// Steps until a checkpoint is possible: 0 unless stages of the scene's order read what an earlier step left. Such
/// products are not saved, so all stages must run in the step after a checkpoint. `u64::MAX` if there is no such step.
pub fn steps_until_possible(world: &mut World) -> u64 {
    let (Some(installed), Some(clock)) = (
        world.get_resource::<Installed>(),
        world.get_resource::<Clock>(),
    ) else {
        return 0;
    };
    let step = clock.step;
    let wait = possible_steps(installed).map_or(u64::MAX, |(every, offset)| {
        (offset + every - step % every) % every
    });
    // All of them also run if the rows hold other particles than before.
    if wait > 0 && wait < u64::MAX && rows_will_change(world) {
        return 0;
    }
    wait
}

/// Steps between two in which a checkpoint is possible: 1 unless stages of the scene's order read what an earlier step
/// left, `u64::MAX` if there are no two. See [`steps_until_possible`].
pub fn steps_between(world: &World) -> u64 {
    let installed = world.get_resource::<Installed>();
    installed.map_or(1, |installed| {
        possible_steps(installed).map_or(u64::MAX, |steps| steps.0)
    })
}

/// The steps before which a checkpoint is possible: the number from one to the next, and the first; none if there is
/// none.
fn possible_steps(installed: &Installed) -> Option<(u64, u64)> {
    if !installed.reads_stale {
        return Some((1, 0));
    }
    // Stages under a condition make nothing that lasts.
    let due = installed.due.iter().filter(|due| !due.sometimes);
    let mut due = due.map(|due| (due.every, due.offset));
    due.try_fold((1, 0), common_steps)
}

/// Whether the rows of the next step hold other particles than those of the last.
fn rows_will_change(world: &mut World) -> bool {
    rows(world) != world.resource::<Rows>().entities
}

/// The steps in which both of two stages are due, each given by the number of steps between two runs and the first of
/// them; none if there is no such step, or the interval is more than a step number can hold.
fn common_steps((n, a): (u64, u64), (m, b): (u64, u64)) -> Option<(u64, u64)> {
    let [n, a, m, b] = [n, a, m, b].map(i128::from);
    // Extended Euclid: n s = g modulo m.
    let (mut g, mut rest, mut s, mut next) = (n, m, 1, 0);
    while rest != 0 {
        let quotient = g / rest;
        (g, rest) = (rest, g - quotient * rest);
        (s, next) = (next, s - quotient * next);
    }
    if (b - a) % g != 0 {
        return None;
    }
    let k = ((b - a) / g * s).rem_euclid(m / g);
    let every = n / g * m;
    let offset = (a + n * k) % every;
    Some((every.try_into().ok()?, offset.try_into().ok()?))
}

/// The fluid particles in the order of the rows.
pub(super) fn rows(world: &mut World) -> Vec<Entity> {
    let mut rows = Vec::new();
    let mut fluid = world.query_filtered::<Entity, With<Fluid>>();
    let tables = fluid.contiguous_iter(world).into_iter().flatten();
    for entities in in_order(tables, |table| table) {
        rows.extend_from_slice(entities);
    }
    rows
}

/// The transport of a scene's columns, by name.
pub(super) fn lasting(installed: &Installed) -> Vec<(&'static str, Lasting)> {
    columns(&installed.scene)
        .filter_map(|column| Some((column.name, column.lasting?)))
        .collect()
}

/// Number of boundary particles, and a checksum of their bits; of moving ones, of their state at time 0.
pub(super) fn walls(world: &mut World) -> (u64, u32) {
    type Parts<'w> = (
        Entity,
        &'w Position,
        &'w BoundaryNormal,
        &'w BoundaryVolume,
        Option<&'w RestPose>,
    );
    let mut query = world.query_filtered::<Parts, With<Boundary>>();
    let mut sum = crc32fast::Hasher::new();
    let mut count = 0;
    let tables = query.contiguous_iter(world).into_iter().flatten();
    for (_, positions, normals, volumes, rest) in in_order(tables, |table| table.0) {
        count += positions.len() as u64;
        for (row, volume) in volumes.iter().enumerate() {
            let (position, normal) = match rest {
                Some(rest) => (rest[row].position, rest[row].normal),
                None => (positions[row].0, normals[row].0),
            };
            for x in (position.to_array().into_iter())
                .chain(normal.to_array())
                .chain([volume.0])
            {
                sum.update(&x.to_le_bytes());
            }
        }
    }
    (count, sum.finalize())
}

/// A sum over the tables that motions of walls and body forces are read from; 0 without any.
pub(super) fn tables(world: &World) -> u32 {
    let mut sum = crc32fast::Hasher::new();
    if let Some(walls) = world.get_resource::<MovingWalls>() {
        walls.figures().for_each(|x| sum.update(&x.to_le_bytes()));
    }
    if let Some(forces) = world.get_resource::<BodyForces>() {
        forces.figures().for_each(|x| sum.update(&x.to_le_bytes()));
    }
    sum.finalize()
}

/// What all ranks have.
fn of_all<T: Serialize + DeserializeOwned>(
    team: &Team,
    own: &T,
) -> Result<Vec<T>, CheckpointError> {
    team.gather(own).ok_or(CheckpointError::RanksLost)
}

impl Checkpoint {
    /// The state of the scene in a world, as [`write()`] writes it. On several ranks all call it, and each gets the
    /// state of the whole run, as one rank has it.
    pub fn of(world: &mut World) -> Result<Self, CheckpointError> {
        let installed = world.get_resource::<Installed>();
        let installed = installed.ok_or(CheckpointError::NotInstalled)?.clone();
        between_steps(world)?;
        ranks::check_checkpoints(world, &installed.scene)?;
        let steps = steps_until_possible(world);
        if steps == u64::MAX {
            return Err(CheckpointError::NeverPossible);
        }
        if steps > 0 {
            return Err(CheckpointError::BetweenRuns { steps });
        }
        let same_rows = !installed.reads_stale && !rows_will_change(world);
        let rows = rows(world);
        let execution = world.resource::<Execution>().clone();
        let same_rows = !execution.any(!same_rows);
        let walls = walls(world);
        let tables = tables(world);
        let numbers: Vec<u32> = (rows.iter())
            .map(|&particle| {
                world
                    .get::<ParticleId>(particle)
                    .map_or(u32::MAX, |id| id.get())
            })
            .collect();
        let mut checkpoint = Self::default();
        let mut put = |name: String, bytes: Result<Vec<u8>, String>| {
            let bytes = bytes.map_err(|reason| CheckpointError::malformed(&name, reason))?;
            checkpoint.put(name, bytes);
            Ok::<(), CheckpointError>(())
        };
        put(SCENE.to_owned(), Ok(installed.scene.to_ron()?.into_bytes()))?;
        put(FILES.to_owned(), to_bytes(&installed.files))?;
        put(STAGES.to_owned(), to_bytes(&installed.stages))?;
        put(SAME_ROWS.to_owned(), to_bytes(&same_rows))?;
        put(WALLS.to_owned(), to_bytes(&walls))?;
        put(TABLES.to_owned(), to_bytes(&tables))?;
        let numbers = match execution.team() {
            None => numbers,
            Some(team) => team.along_rows(of_all(team, &numbers)?).concat(),
        };
        put(NUMBERS.to_owned(), to_bytes(&numbers))?;
        for (name, lasting) in lasting(&installed) {
            let mut column = (lasting.save)(world, &rows);
            if let (Some(team), Ok(own)) = (execution.team(), &column) {
                column = (lasting.join)(&team.along_rows(of_all(team, own)?));
            }
            put(format!("{COLUMN}{name}"), column)?;
            if let Some(kept) = (lasting.save_kept)(world).transpose() {
                put(format!("{KEPT}{name}"), kept)?;
            }
        }
        for remembered in REMEMBERED {
            if let Some(mut state) = (remembered.save)(world, &rows).transpose() {
                // All ranks have the same, but for the rows that it names.
                if let (Some(team), Ok(own)) = (execution.team(), &state) {
                    state = Ok(of_all(team, own)?.swap_remove(0));
                }
                put(remembered.name.to_owned(), state)?;
            }
        }
        Ok(checkpoint)
    }
}

#[cfg(test)]
mod tests {
    use super::common_steps;

    #[test]
    fn steps_in_which_all_are_due_are_found_or_there_are_none() {
        for n in 1..9 {
            for m in 1..9 {
                for (a, b) in (0..n).flat_map(|a| (0..m).map(move |b| (a, b))) {
                    let both = |step: &u64| step % n == a && step % m == b;
                    let first = (0..n * m).find(both);
                    let found = common_steps((n, a), (m, b));
                    assert_eq!(found.map(|found| found.1), first, "{n} {a} {m} {b}");
                    let next = first.and_then(|first| (first + 1..3 * n * m).find(both));
                    let period = next.zip(first).map(|(next, first)| next - first);
                    assert_eq!(found.map(|found| found.0), period, "{n} {a} {m} {b}");
                }
            }
        }
        let most = u64::from(u32::MAX);
        assert!(common_steps((most, 5), (most - 1, 7)).is_some());
    }
}
