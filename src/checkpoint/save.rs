//! Saves a world to a checkpoint.

use std::io::Write;

use bevy_ecs::prelude::*;

use super::{
    error::CheckpointError,
    file::{Checkpoint, SCENE},
};
use crate::{
    boundary::moving::{MovingWalls, RestPose},
    registry::{REMEMBERED, columns},
    state::{
        BodyForces, Clock, Lasting, Rows, in_order,
        particle::{Boundary, BoundaryNormal, BoundaryVolume, Fluid, ParticleId, Position},
        to_bytes,
    },
    step::Installed,
};

/// Names of parts.
pub(super) const NUMBERS: &str = "particle numbers";
pub(super) const WALLS: &str = "walls";
pub(super) const TABLES: &str = "tables";
pub(super) const FILES: &str = "files";
pub(super) const STAGES: &str = "order of the stages";
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

/// Steps until a checkpoint is possible: 0 unless stages of the scene's order do not run in every step. Their products
/// are not saved, so all of them must run in the step after a checkpoint.
pub fn steps_until_possible(world: &mut World) -> u64 {
    let (Some(installed), Some(clock)) = (
        world.get_resource::<Installed>(),
        world.get_resource::<Clock>(),
    ) else {
        return 0;
    };
    let step = clock.step;
    let intervals = installed.stages.iter().map(|stage| stage.1);
    let common = intervals.fold(1, least_common_multiple);
    let wait = (common - step % common) % common;
    // All of them also run if the rows hold other particles than before.
    if wait > 0 && rows(world) != world.resource::<Rows>().entities {
        return 0;
    }
    wait
}

fn least_common_multiple(a: u64, b: u64) -> u64 {
    let (mut x, mut y) = (a.max(1), b.max(1));
    while y > 0 {
        (x, y) = (y, x % y);
    }
    (a.max(1) / x).saturating_mul(b.max(1))
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
        &'w Position,
        &'w BoundaryNormal,
        &'w BoundaryVolume,
        Option<&'w RestPose>,
    );
    let mut query = world.query_filtered::<Parts, With<Boundary>>();
    let mut sum = crc32fast::Hasher::new();
    let mut count = 0;
    for (position, normal, volume, rest) in query.iter(world) {
        count += 1;
        let (position, normal) = match rest {
            Some(rest) => (rest.position, rest.normal),
            None => (position.0, normal.0),
        };
        for x in (position.to_array().into_iter())
            .chain(normal.to_array())
            .chain([volume.0])
        {
            sum.update(&x.to_le_bytes());
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

impl Checkpoint {
    /// The state of the scene in a world, as [`write()`] writes it.
    pub fn of(world: &mut World) -> Result<Self, CheckpointError> {
        let installed = world.get_resource::<Installed>();
        let installed = installed.ok_or(CheckpointError::NotInstalled)?.clone();
        let steps = steps_until_possible(world);
        if steps > 0 {
            return Err(CheckpointError::BetweenRuns { steps });
        }
        let rows = rows(world);
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
        put(WALLS.to_owned(), to_bytes(&walls))?;
        put(TABLES.to_owned(), to_bytes(&tables))?;
        put(NUMBERS.to_owned(), to_bytes(&numbers))?;
        for (name, lasting) in lasting(&installed) {
            put(format!("{COLUMN}{name}"), (lasting.save)(world, &rows))?;
            if let Some(kept) = (lasting.save_kept)(world).transpose() {
                put(format!("{KEPT}{name}"), kept)?;
            }
        }
        for remembered in REMEMBERED {
            if let Some(state) = (remembered.save)(world, &rows).transpose() {
                put(remembered.name.to_owned(), state)?;
            }
        }
        Ok(checkpoint)
    }
}
