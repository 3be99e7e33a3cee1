//! What a rank does together with the others, where there are some: loops know only what they run in ([`Execution`]).
//!
//! On one rank every function here gives what it was given.

use std::{ops::Range, sync::Arc};

use bevy_ecs::prelude::*;
use bytemuck::Pod;
use glam::Vec4;
use serde::{Deserialize, Serialize, de::DeserializeOwned};

use super::{
    execution::{ChunkResults, Execution},
    failure::{Failure, FailureCause},
};
use crate::communicator::Team;

/// A row that results name where no rank's rows have it.
const NO_ROW: u64 = u64::MAX;

/// What a chunk of rows results in, with the rows that it names.
pub(crate) trait ChunkResult: Serialize + DeserializeOwned {
    /// Gives the rows other names.
    fn rename(&mut self, name: impl Fn(usize) -> usize);
}

impl Execution {
    /// The other ranks, where there are some.
    pub(crate) fn team(&self) -> Option<&Team> {
        self.team.as_deref()
    }

    /// Takes other ranks, or another part of the run's rows.
    pub(crate) fn set_team(&mut self, team: Option<Team>) {
        self.team = team.map(Arc::new);
    }

    /// The rows, of so many here, that this rank owns.
    pub(crate) fn owned(&self, rows: usize) -> Range<usize> {
        self.team().map_or(0..rows, Team::owned)
    }

    /// Number of rows of the run, if so many are here.
    pub(crate) fn all(&self, rows: usize) -> usize {
        self.team().map_or(rows, |team| team.all() as usize)
    }

    /// Writes what others have of their rows beside the own ones.
    pub(crate) fn share<T: Pod>(&self, column: &mut [T]) {
        if let Some(team) = self.team() {
            team.share(column, |value| *value, |value, new| *value = new);
        }
    }

    /// The same of the fourth entries.
    pub(crate) fn share_fourth(&self, column: &mut [Vec4]) {
        if let Some(team) = self.team() {
            team.share(column, |value| value.w, |value, w| value.w = w);
        }
    }

    /// Takes the results of all ranks' chunks, in the order of the run's rows, in the place of those of the own chunks.
    pub(crate) fn join<T: ChunkResult>(&self, chunks: &mut ChunkResults<T>) {
        let Some(team) = self.team() else { return };
        for chunk in &mut chunks.0 {
            chunk.rename(|row| team.number(row).unwrap_or(NO_ROW) as usize);
        }
        if let Some(all) = team.gather(&chunks.0) {
            chunks.0 = team.along_rows(all).into_iter().flatten().collect();
        }
        for chunk in &mut chunks.0 {
            chunk.rename(|row| team.row(row as u64).unwrap_or(usize::MAX));
        }
    }

    /// The largest value of all ranks.
    pub(crate) fn largest(&self, value: f32) -> f32 {
        let all = self.team().and_then(|team| team.gather(&value));
        all.map_or(value, |all| all.into_iter().fold(value, f32::max))
    }

    /// The sum over all ranks.
    pub(crate) fn total(&self, count: u64) -> u64 {
        let all = self.team().and_then(|team| team.gather(&count));
        all.map_or(count, |all| all.into_iter().sum())
    }

    /// Whether it is so on any rank.
    pub(crate) fn any(&self, holds: bool) -> bool {
        let all = self.team().and_then(|team| team.gather(&holds));
        all.map_or(holds, |all| all.contains(&true))
    }

    /// Folds own rows into a value, after the ranks before have done so with theirs.
    pub(crate) fn in_turn<T: Clone + Serialize + DeserializeOwned>(
        &self,
        start: T,
        mut fold: impl FnMut(T) -> T,
    ) -> T {
        match self.team() {
            Some(team) => team.in_turn(start, fold),
            None => fold(start),
        }
    }
}

/// A failure as other ranks are told it.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub(super) struct Told {
    /// The run's row concerned.
    row: u64,
    /// Whether a shorter step may go right.
    depends_on_the_time_step: bool,
    /// What went wrong, with the particle.
    text: String,
}

/// Lets all ranks fail if one does: with the failure of the run's first row, or else of the first rank.
pub(crate) fn agree(mut failure: ResMut<Failure>, execution: Res<Execution>) {
    let Some(team) = execution.team() else { return };
    let told = failure
        .told()
        .map(|(row, depends_on_the_time_step, text)| Told {
            row: row.and_then(|row| team.number(row)).unwrap_or(NO_ROW),
            depends_on_the_time_step,
            text,
        });
    let all = team.gather(&told).unwrap_or_default();
    let failures = all.into_iter().enumerate();
    let failures = failures.filter_map(|(rank, told)| Some((rank, told?)));
    match failures.min_by_key(|(rank, told)| (told.row, *rank)) {
        Some((rank, told)) if rank != team.rank() => {
            *failure = Failure::default();
            let cause = FailureCause::OnAnotherRank {
                rank,
                cause: told.text,
                depends_on_the_time_step: told.depends_on_the_time_step,
            };
            failure.record(cause, None);
        }
        _ => {}
    }
    if let Some(lost) = team.lost() {
        *failure = Failure::default();
        failure.record(FailureCause::RanksLost(lost.clone()), None);
    }
}
