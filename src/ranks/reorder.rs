//! Reordering along the Z-curve over all ranks. Particles go to the ranks that own their new rows.

use bevy_ecs::prelude::*;
use glam::{IVec3, Vec4};
use serde::{Deserialize, Serialize};

use crate::{
    communicator::{Lost, Team},
    index::{FluidIndex, z_curve},
    reorder::{ReorderState, arrange},
    state::{
        Execution, Lasting, in_order,
        particle::{Fluid, ParticleId, Position, give_number_back, replace_next_number},
        to_bytes,
    },
};

/// The columns that go with particles.
#[derive(Resource)]
pub(crate) struct Travelling(pub(crate) Vec<Lasting>);

/// Particles on their way, in the order of the curve.
#[derive(Debug, Default, Serialize, Deserialize)]
struct Parcel {
    /// Keys of their cells.
    keys: Vec<u64>,
    /// Their numbers.
    numbers: Vec<u32>,
    /// Their columns.
    columns: Vec<Vec<u8>>,
}

/// Moves every particle to its row along the Z-curve (phase `Reorder`).
pub(super) fn reorder(world: &mut World) {
    let execution = world.resource::<Execution>().clone();
    let Some(team) = execution.team() else { return };
    let (entities, points) = rows(world);
    let mut handles = Vec::new();
    let grid = world.resource::<FluidIndex>().structure().grid();
    let origin = z_curve::origin(&points, grid, &execution).to_array();
    let Some(origins) = team.gather(&origin) else {
        return;
    };
    let least = |least: IVec3, of: [i32; 3]| least.min(IVec3::from_array(of));
    let origin = origins.into_iter().fold(IVec3::MAX, least);
    z_curve::sort_handles_from(&points, (grid, origin), &execution, &mut handles);
    let downwards = world
        .resource_mut::<ReorderState>()
        .turn(team.all() as usize);
    let keys: Vec<u64> = handles.iter().map(|handle| handle.0).collect();
    let sorted: Vec<Entity> = handles
        .iter()
        .map(|handle| entities[handle.1 as usize])
        .collect();
    let Some(cuts) = cuts(team, &keys, downwards) else {
        return;
    };
    let moved = exchange(world, team, (&keys, &sorted, &cuts));
    let mut moved = match moved {
        Ok(Some(moved)) => moved,
        Ok(None) => return,
        Err(reason) => return team.lose(Lost::Other(reason)),
    };
    if downwards {
        moved.reverse();
    }
    arrange(world, &moved);
}

/// The particles of the world and their positions, in the order of the rows.
fn rows(world: &mut World) -> (Vec<Entity>, Vec<Vec4>) {
    let mut fluid = world.query_filtered::<(Entity, &Position), With<Fluid>>();
    let (mut entities, mut points) = (Vec::new(), Vec::new());
    let tables = fluid.contiguous_iter(world).into_iter().flatten();
    for (of_table, positions) in in_order(tables, |table| table.0) {
        entities.extend_from_slice(of_table);
        points.extend(positions.iter().map(|x| x.0.extend(0.0)));
    }
    (entities, points)
}

/// Where the parts of sorted keys begin that go to every rank, and where they end. All ranks' keys are one sequence,
/// equal ones in the order of the rows; every rank owns as much of it as before.
fn cuts(team: &Team, keys: &[u64], downwards: bool) -> Option<Vec<(usize, usize)>> {
    let (borders, all) = (team.borders(), team.all());
    // Rows against the curve begin at its end. Either way the first rank has the beginning of the curve.
    let places: Vec<u64> = match downwards {
        true => borders.iter().rev().map(|border| all - border).collect(),
        false => borders.to_vec(),
    };
    // The key of every place: the least that has more keys up to it than there are before the place.
    let mut found = vec![0_u64; places.len()];
    for bit in (0..u64::BITS).rev() {
        let tried: Vec<u64> = found.iter().map(|key| key | 1 << bit).collect();
        let below = |&key: &u64| keys.partition_point(|&other| other < key) as u64;
        let counts = sums(&team.gather(&tried.iter().map(below).collect())?);
        for ((found, tried), (count, place)) in
            found.iter_mut().zip(tried).zip(counts.iter().zip(&places))
        {
            if count <= place {
                *found = tried;
            }
        }
    }
    let equal = |&key: &u64| {
        let first = keys.partition_point(|&other| other < key);
        let end = keys.partition_point(|&other| other <= key);
        (first as u64, (end - first) as u64)
    };
    let own: Vec<(u64, u64)> = found.iter().map(equal).collect();
    let of_all: Vec<Vec<(u64, u64)>> = team.along_rows(team.gather(&own)?);
    let before_own = &of_all[..team.place(team.rank())];
    let cut = |k: usize| {
        let before: u64 = of_all.iter().map(|of| of[k].0).sum();
        let equal_before: u64 = before_own.iter().map(|of| of[k].1).sum();
        let wanted = places[k].saturating_sub(before + equal_before);
        (own[k].0 + wanted.min(own[k].1)) as usize
    };
    let cuts: Vec<usize> = (0..places.len()).map(cut).collect();
    Some(cuts.windows(2).map(|pair| (pair[0], pair[1])).collect())
}

/// The sums of the entries of all ranks.
fn sums(counts: &[Vec<u64>]) -> Vec<u64> {
    let mut sums = vec![0; counts.first().map_or(0, Vec::len)];
    for counts in counts {
        for (sum, count) in sums.iter_mut().zip(counts) {
            *sum += count;
        }
    }
    sums
}

/// Sends particles to their ranks, and returns those that are here then, in the order of the curve; none if ranks are
/// lost.
fn exchange(
    world: &mut World,
    team: &Team,
    (keys, sorted, cuts): (&[u64], &[Entity], &[(usize, usize)]),
) -> Result<Option<Vec<Entity>>, String> {
    let columns = world.remove_resource::<Travelling>();
    let columns = columns.ok_or("nothing says which columns travel")?;
    let mut messages = Vec::new();
    for (rank, &(first, end)) in cuts.iter().enumerate() {
        let mut parcel = Parcel {
            keys: keys[first..end].to_vec(),
            ..Parcel::default()
        };
        if rank != team.rank() {
            let particles = &sorted[first..end];
            let number = |&particle| world.get::<ParticleId>(particle).map_or(0, |id| id.get());
            parcel.numbers = particles.iter().map(number).collect();
            let saved = columns
                .0
                .iter()
                .map(|column| (column.save)(world, particles));
            parcel.columns = saved.collect::<Result<_, _>>()?;
        }
        messages.push(to_bytes(&parcel)?);
    }
    let Some(parcels) = team
        .exchange(messages)
        .and_then(|came| team.read::<Parcel>(came))
    else {
        world.insert_resource(columns);
        return Ok(None);
    };
    let (first, end) = cuts[team.rank()];
    for &particle in sorted[..first].iter().chain(&sorted[end..]) {
        world.despawn(particle);
    }
    let next = replace_next_number(world, 0);
    let mut here: Vec<(u64, Entity)> = Vec::new();
    let parcels = parcels.into_iter().enumerate().collect();
    for (rank, parcel) in team.along_rows(parcels) {
        let particles: Vec<Entity> = if rank == team.rank() {
            sorted[first..end].to_vec()
        } else {
            parcel
                .keys
                .iter()
                .map(|_| world.spawn(Fluid).id())
                .collect()
        };
        for (&particle, &number) in particles.iter().zip(&parcel.numbers) {
            give_number_back(world, particle, number);
        }
        for (column, bytes) in columns.0.iter().zip(&parcel.columns) {
            (column.load)(world, &particles, bytes)?;
        }
        here.extend(parcel.keys.into_iter().zip(particles));
    }
    replace_next_number(world, next);
    world.insert_resource(columns);
    // Equal keys stay in the order of the rows.
    here.sort_by_key(|(key, _)| *key);
    Ok(Some(
        here.into_iter().map(|(_, particle)| particle).collect(),
    ))
}
