//! Finds the rows of others that a rank needs: all in the cells around its own rows.

use std::collections::HashSet;

use bevy_ecs::prelude::*;
use glam::{IVec3, Vec4};

use crate::{
    communicator::{Halo, Team},
    index::{FluidIndex, Grid, Images},
    neighbours::KeptLists,
    reorder::ReorderState,
    scene::Period,
    state::{
        Execution, Failure, FailureCause, Material, in_order,
        particle::{Fluid, Position},
    },
};

/// Finds the halo of the step (before the columns are gathered).
pub(super) fn find_halo(
    fluid: Query<(Entity, &Position), With<Fluid>>,
    (index, kept): (Res<FluidIndex>, Option<Res<KeptLists>>),
    reordered: Option<Res<ReorderState>>,
    material: Res<Material>,
    mut execution: ResMut<Execution>,
    mut failure: ResMut<Failure>,
) {
    let Some(mut team) = execution.team().cloned() else {
        let reason =
            "the host replaced `Execution`, which knows the other ranks; install the scene anew";
        return failure.record(FailureCause::NotInstalled { reason }, None);
    };
    let (mut entities, mut points) = (Vec::new(), Vec::new());
    let tables = fluid.contiguous_iter().into_iter().flatten();
    for (of_table, positions) in in_order(tables, |table| table.0) {
        entities.extend_from_slice(of_table);
        let wrapped = |x: &Position| material.period.wrap(x.0).extend(0.0);
        points.extend(positions.iter().map(wrapped));
    }
    // Lists that are kept name rows of the halo that they were found with.
    let holds = kept.is_some_and(|kept| {
        let own = (team.owned().start, &entities[..]);
        kept.hold(own, &points, &material.period)
    });
    let is_known = !execution.any(!holds);
    team.turn(reordered.is_some_and(|state| state.downwards));
    let (before, now) = (team.owned().len(), points.len());
    if before != now {
        failure.record(FailureCause::ParticlesChanged { before, now }, None);
    }
    if is_known {
        return;
    }
    if let Some(halo) = found(&team, &points, index.structure().grid(), material.period) {
        team.set_halo(halo);
        execution.set_team(Some(team));
    }
}

/// Cells of points and of their images, each with the row, in the order of the rows; those of the points first.
fn cells_of(points: &[Vec4], grid: &Grid, period: Period) -> Vec<(IVec3, u32)> {
    let rows = |points: &[Vec4]| -> Vec<(IVec3, u32)> {
        let cells = points.iter().map(|&point| grid.cell_of(point));
        cells.zip(0..).collect()
    };
    if !period.is_any() {
        return rows(points);
    }
    let mut images = Images::new(period, grid.support_radius);
    images.take(points);
    let mut cells = rows(images.points());
    for (_, place) in &mut cells {
        *place = images.source(*place);
    }
    cells
}

/// A box of cells; the first corner is beyond the second where there is none.
type Corners = ([i32; 3], [i32; 3]);

fn box_of<'a>(cells: impl Iterator<Item = &'a IVec3>) -> Corners {
    let none = (IVec3::MAX, IVec3::MIN);
    let (low, high) = cells.fold(none, |(low, high), cell| (low.min(*cell), high.max(*cell)));
    (low.to_array(), high.to_array())
}

/// Whether a cell is within reach of a box.
fn is_near(cell: IVec3, (low, high): Corners, reach: IVec3) -> bool {
    let [low, high] = [low, high].map(IVec3::from_array);
    let from_low = cell.cmpge(low.saturating_sub(reach)).all();
    from_low && cell.cmple(high.saturating_add(reach)).all()
}

/// The rows that go to every rank, and the number of those that come.
fn found(team: &Team, points: &[Vec4], grid: &Grid, period: Period) -> Option<Halo> {
    let cells = cells_of(points, grid, period);
    let own: HashSet<IVec3> = cells[..points.len()]
        .iter()
        .map(|(cell, _)| *cell)
        .collect();
    let boxes: Vec<Corners> = team.gather(&box_of(own.iter()))?;
    // What may be near to cells of another rank is in its box, or its images are.
    let all = box_of(cells.iter().map(|(cell, _)| cell));
    let boxes_with_images: Vec<Corners> = team.gather(&all)?;
    let message = |rank: usize| -> Vec<u8> {
        let near = own.iter().filter(|&&cell| {
            rank != team.rank() && is_near(cell, boxes_with_images[rank], grid.reach)
        });
        let near: Vec<[i32; 3]> = near.map(|cell| cell.to_array()).collect();
        bytemuck::cast_slice(&near).to_vec()
    };
    let came = team.exchange((0..team.ranks()).map(message).collect())?;
    let sent = came.iter().zip(boxes).map(|(bytes, corners)| {
        let theirs: HashSet<IVec3> = bytes
            .chunks_exact(size_of::<IVec3>())
            .map(bytemuck::pod_read_unaligned)
            .collect();
        let is_wanted = |cell: IVec3| {
            let around = || grid.neighbourhood.iter().map(|&to| cell.wrapping_add(to));
            is_near(cell, corners, grid.reach) && around().any(|cell| theirs.contains(&cell))
        };
        rows_of(&cells, is_wanted)
    });
    let sent: Vec<Vec<u32>> = sent.collect();
    let counts = sent
        .iter()
        .map(|rows| (rows.len() as u32).to_le_bytes().to_vec());
    let came = team.exchange(counts.collect())?;
    let counts = came.iter().map(|bytes| {
        let count = bytes.first_chunk().map(|bytes| u32::from_le_bytes(*bytes));
        count.unwrap_or_default()
    });
    Some(Halo {
        counts: counts.collect(),
        sent,
    })
}

/// The rows of which a cell is wanted, ascending. Neighbours in the order of the rows are often in one cell.
fn rows_of(cells: &[(IVec3, u32)], is_wanted: impl Fn(IVec3) -> bool) -> Vec<u32> {
    let mut last = None;
    let mut rows = Vec::new();
    for &(cell, row) in cells {
        let wanted = match last {
            Some((of, wanted)) if of == cell => wanted,
            _ => is_wanted(cell),
        };
        last = Some((cell, wanted));
        if wanted {
            rows.push(row);
        }
    }
    rows.sort_unstable();
    rows.dedup();
    rows
}
