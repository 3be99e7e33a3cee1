//! A rank among the others: which rows it owns, which rows of others it has beside them, and what all decide together.
//!
//! Rows of the whole run are numbered along the order of the last reordering. A rank owns a range of them, whole
//! chunks, and its own rows have the numbers of the run's: those of the halo that are before its range, its range, and
//! those after it. So the rows of a rank ascend as those of a run on one rank do, and sums have their terms in that
//! order.

use std::{
    ops::Range,
    sync::{Arc, OnceLock},
};

use bytemuck::Pod;
use serde::{Serialize, de::DeserializeOwned};

use super::{Communicator, Lost};

/// Rows of others that a rank has beside its own.
#[derive(Debug, Clone, Default)]
pub(crate) struct Halo {
    /// Own rows that others have, counted from the first own one, by rank.
    pub(crate) sent: Vec<Vec<u32>>,
    /// Number of rows that come from every rank.
    pub(crate) counts: Vec<u32>,
}

/// A rank among the others.
#[derive(Clone)]
pub(crate) struct Team {
    communicator: Arc<dyn Communicator>,
    /// The first of the run's rows that every rank owns, in the order of the ranks along them, and the number of all.
    borders: Vec<u64>,
    /// Whether the last rank has the first rows: they lie against the curve after every other reordering.
    reversed: bool,
    halo: Halo,
    /// Why messages no longer come.
    lost: Arc<OnceLock<Lost>>,
}

impl Team {
    /// Of nobody's rows yet.
    pub(crate) fn new(communicator: Arc<dyn Communicator>) -> Self {
        Self {
            borders: vec![0; communicator.ranks() + 1],
            communicator,
            reversed: false,
            halo: Halo::default(),
            lost: Arc::default(),
        }
    }

    /// Gives every rank its part of so many rows: whole chunks of `chunk`, as many as the others have, or one more.
    pub(crate) fn distribute(&mut self, rows: u64, chunk: u64) {
        let (chunks, ranks) = (rows.div_ceil(chunk), self.ranks() as u64);
        self.borders = (0..=ranks)
            .map(|rank| rows.min(rank * chunks / ranks * chunk))
            .collect();
        self.halo = Halo::default();
    }

    /// Takes other rows beside the own ones.
    pub(crate) fn set_halo(&mut self, halo: Halo) {
        self.halo = halo;
    }

    /// Number of this rank.
    pub(crate) fn rank(&self) -> usize {
        self.communicator.rank()
    }

    /// Number of ranks.
    pub(crate) fn ranks(&self) -> usize {
        self.communicator.ranks()
    }

    /// Lets the last rank have the first rows, or the first rank. Nothing is known of others' rows then.
    pub(crate) fn turn(&mut self, reversed: bool) {
        if self.reversed != reversed {
            self.reversed = reversed;
            self.halo = Halo::default();
        }
    }

    /// The first of the run's rows of every rank, in the order of the ranks along them, and the number of all.
    pub(crate) fn borders(&self) -> &[u64] {
        &self.borders
    }

    /// The place of a rank among the ranks along the rows, and the rank of a place.
    pub(crate) fn place(&self, rank: usize) -> usize {
        match self.reversed {
            true => self.ranks() - 1 - rank,
            false => rank,
        }
    }

    /// What there is of every rank, in the order of the ranks along the rows.
    pub(crate) fn along_rows<T>(&self, mut of_ranks: Vec<T>) -> Vec<T> {
        if self.reversed {
            of_ranks.reverse();
        }
        of_ranks
    }

    /// The run's rows that this rank owns.
    pub(crate) fn range(&self) -> Range<u64> {
        let place = self.place(self.rank());
        self.borders[place]..self.borders[place + 1]
    }

    /// The rows here that this rank owns.
    pub(crate) fn owned(&self) -> Range<usize> {
        let range = self.range();
        let first = self.came(0..self.place(self.rank()));
        first..first + (range.end - range.start) as usize
    }

    /// Number of rows here.
    pub(crate) fn rows(&self) -> usize {
        self.owned().end + self.came(self.place(self.rank())..self.ranks())
    }

    /// Number of rows that came from the ranks of some places.
    fn came(&self, places: Range<usize>) -> usize {
        let counts = places.map(|place| self.halo.counts.get(self.place(place)));
        counts
            .map(|count| count.map_or(0, |&count| count as usize))
            .sum()
    }

    /// Number of rows of the run.
    pub(crate) fn all(&self) -> u64 {
        self.borders[self.ranks()]
    }

    /// The number in the run of a row that this rank owns.
    pub(crate) fn number(&self, row: usize) -> Option<u64> {
        let owned = self.owned();
        (owned.contains(&row)).then(|| self.range().start + (row - owned.start) as u64)
    }

    /// The row here of a number in the run, if this rank owns it.
    pub(crate) fn row(&self, number: u64) -> Option<usize> {
        let range = self.range();
        (range.contains(&number)).then(|| self.owned().start + (number - range.start) as usize)
    }

    /// Why the run cannot go on, if it cannot.
    pub(crate) fn lost(&self) -> Option<&Lost> {
        self.lost.get()
    }

    /// Notes that it cannot.
    pub(crate) fn lose(&self, lost: Lost) {
        // The first reason counts.
        let _ = self.lost.set(lost);
    }

    /// Sends a message to every rank and returns those that came; none from now on when ranks are lost.
    pub(crate) fn exchange(&self, messages: Vec<Vec<u8>>) -> Option<Vec<Vec<u8>>> {
        self.unless_lost(|communicator| communicator.exchange(messages))
    }

    fn unless_lost(
        &self,
        work: impl FnOnce(&dyn Communicator) -> Result<Vec<Vec<u8>>, Lost>,
    ) -> Option<Vec<Vec<u8>>> {
        if self.lost().is_some() {
            return None;
        }
        let missing = || Lost::Other("the communicator has no message of every rank".to_owned());
        let came = work(&*self.communicator).and_then(|came| match came.len() == self.ranks() {
            true => Ok(came),
            false => Err(missing()),
        });
        came.map_err(|lost| self.lose(lost)).ok()
    }

    /// The values of all ranks, in their order.
    pub(crate) fn gather<T: Serialize + DeserializeOwned>(&self, value: &T) -> Option<Vec<T>> {
        let bytes =
            postcard::to_stdvec(value).map_err(|error| self.lose(Lost::Other(error.to_string())));
        let came =
            self.unless_lost(|communicator| communicator.gather(bytes.unwrap_or_default()))?;
        self.read(came)
    }

    /// Values that came from all ranks.
    pub(crate) fn read<T: DeserializeOwned>(&self, came: Vec<Vec<u8>>) -> Option<Vec<T>> {
        let values = came.iter().enumerate().map(|(rank, bytes)| {
            let value = postcard::from_bytes(bytes);
            value.map_err(|_| self.lose(Lost::OutOfStep { rank })).ok()
        });
        values.collect()
    }

    /// Writes what others have of their rows beside the own ones. `get` is the part of a row that travels.
    pub(crate) fn share<R, T: Pod>(
        &self,
        column: &mut [R],
        get: impl Fn(&R) -> T,
        set: impl Fn(&mut R, T),
    ) {
        let owned = self.owned();
        let message = |rank: usize| {
            let of_row = |&row: &u32| get(&column[owned.start + row as usize]);
            let rows = self.halo.sent.get(rank).into_iter().flatten();
            let values: Vec<T> = rows.map(of_row).collect();
            bytemuck::cast_slice(&values).to_vec()
        };
        let Some(came) = self.exchange((0..self.ranks()).map(message).collect()) else {
            return;
        };
        let mut row = 0;
        for place in 0..self.ranks() {
            let rank = self.place(place);
            let bytes = &came[rank];
            if rank == self.rank() {
                row = owned.end;
                continue;
            }
            let count = self.halo.counts.get(rank).copied().unwrap_or_default();
            let rows = row..row + count as usize;
            if bytes.len() != rows.len() * size_of::<T>() {
                return self.lose(Lost::OutOfStep { rank });
            }
            for (row, bytes) in column[rows.clone()]
                .iter_mut()
                .zip(bytes.chunks_exact(size_of::<T>()))
            {
                set(row, bytemuck::pod_read_unaligned(bytes));
            }
            row = rows.end;
        }
    }

    /// Lets the ranks fold their parts one after the other along the rows: as one rank folds all rows in turn.
    pub(crate) fn in_turn<T: Clone + Serialize + DeserializeOwned>(
        &self,
        mut value: T,
        mut fold: impl FnMut(T) -> T,
    ) -> T {
        for place in 0..self.ranks() {
            let part = (self.place(place) == self.rank()).then(|| fold(value.clone()));
            let came = self.gather(&part).unwrap_or_default();
            value = came.into_iter().flatten().next().unwrap_or(value);
        }
        value
    }
}
