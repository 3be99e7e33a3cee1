//! Lists in one flat array, each where its row's span says.

use std::sync::{
    Mutex, PoisonError,
    atomic::{AtomicU16, AtomicU32, Ordering::Relaxed},
};

use crate::{index::SpatialIndex, simd::prefetch, state::CHUNK};

/// Neighbours of a particle within the fluid at the default support, roughly: what a list is expected to need
/// before its first search.
const FULL_NEIGHBOURHOOD: u16 = 30;

/// Room for lists of so many entries that grow a little from step to step and shall not be moved in every one.
fn room(len: usize) -> usize {
    len / 256 + 1024
}

/// Neighbour lists of all rows.
///
/// Memory: 4 bytes a neighbour and 6 a row, and one in a hundred more. Every block has as much of the array as it
/// needed in the last search, so that few entries are left over, and a list that finds no room goes behind the last
/// block's. A sixteenth of room for every block and spans of 8 bytes took 17 % more.
#[derive(Debug, Default)]
pub struct NeighbourLists {
    pub(super) spans: Spans,
    /// The lists.
    pub(super) rows: Vec<u32>,
    /// One for every block of places.
    pub(super) regions: Vec<Region>,
    /// So that a block has some [`CHUNK`] rows. The more they are the less their number changes, and with it the room.
    pub(super) places_a_block: usize,
    /// Lists that found no room, each behind its row and its length.
    pub(super) strays: Mutex<Vec<u32>>,
    /// How long lists are expected to be after rows were put into another order; empty if they were not.
    expected: Vec<AtomicU16>,
}

/// Where the lists begin and how long they are. The rows of a cell are scattered and each is written by one cell alone:
/// relaxed atomics, plain moves on every machine, say so without `unsafe`.
#[derive(Debug, Default)]
pub(super) struct Spans {
    starts: Vec<AtomicU32>,
    lengths: Vec<AtomicU16>,
}

/// Part of the flat array that a block of places writes.
#[derive(Debug, Default, Clone, Copy)]
pub(super) struct Region {
    pub(super) start: usize,
    /// Entries that are expected.
    pub(super) len: usize,
    /// Entries found, which may be more.
    pub(super) found: usize,
}

impl Spans {
    /// Sets the span of a row; where it says more than it can, the search finds out at its end.
    #[inline(always)]
    pub(super) fn set(&self, row: u32, start: usize, len: usize) {
        self.starts[row as usize].store(start as u32, Relaxed);
        self.lengths[row as usize].store(len as u16, Relaxed);
    }

    #[inline(always)]
    fn get(&self, row: usize) -> Option<(usize, usize)> {
        let start = self.starts.get(row)?.load(Relaxed) as usize;
        Some((start, self.lengths.get(row)?.load(Relaxed).into()))
    }
}

impl NeighbourLists {
    /// Neighbours of `row`; none if it came after the search, in an order that keeps stale lists.
    #[inline(always)]
    pub fn of(&self, row: usize) -> &[u32] {
        let (start, len) = self.spans.get(row).unwrap_or_default();
        &self.rows[start..start + len]
    }

    /// Hints that the list of `row` is about to be read: 48 of its entries at most.
    ///
    /// Lists lie in the order of the cells, rows in that of the last reordering, and as particles move the one goes
    /// ever less along with the other: a loop over rows waited for the lists half of its time. Of a dam break's first
    /// 0.45 s (PCISPH, two threads, 103 ms a step) asking ahead took 28 %.
    #[inline(always)]
    pub(crate) fn prefetch(&self, row: usize) {
        let (start, len) = self.spans.get(row).unwrap_or_default();
        let last = (start + len).wrapping_sub(1);
        for line in [0, 16, 32] {
            if let Some(entry) = self.rows.get((start + line).min(last)) {
                prefetch(entry);
            }
        }
    }

    /// Pairs of a row and a neighbour in all lists.
    pub fn pairs(&self) -> usize {
        self.regions.iter().map(|region| region.found).sum()
    }

    /// Memory held [bytes].
    pub fn bytes(&self) -> usize {
        self.spans.starts.capacity() * size_of::<AtomicU32>()
            + self.spans.lengths.capacity() * size_of::<AtomicU16>()
            + self.expected.capacity() * size_of::<AtomicU16>()
            + self.rows.capacity() * size_of::<u32>()
            + self.strays.lock().map_or(0, |strays| strays.capacity()) * size_of::<u32>()
            + self.regions.capacity() * size_of::<Region>()
    }

    /// Forgets all lists.
    pub(super) fn clear(&mut self) {
        self.spans = Spans::default();
        self.expected.clear();
        self.regions.clear();
        self.strays = Mutex::default();
    }

    /// Rows will be in another order at the next search: the `k`-th was `old_rows[k]`. The lists stay as they are.
    pub fn expect_order(&mut self, old_rows: impl Iterator<Item = usize>) {
        let lengths = &self.spans.lengths;
        let length = |row: usize| {
            lengths
                .get(row)
                .map_or(FULL_NEIGHBOURHOOD, |x| x.load(Relaxed))
        };
        self.expected.clear();
        self.expected
            .extend(old_rows.map(length).map(AtomicU16::new));
    }

    /// Gives every block a region as long as its lists were; if there are other blocks or rows now, as the lists of its
    /// rows were: to ask every row takes 3 to 5 ns.
    pub(super) fn lay_out(&mut self, index: &dyn SpatialIndex, points: usize) {
        let places = index.places();
        let blocks = |places_a_block: usize| places.div_ceil(places_a_block.max(1));
        let Spans { starts, lengths } = &mut self.spans;
        let as_before = self.expected.is_empty()
            && lengths.len() == points
            && self.regions.len() == blocks(self.places_a_block);
        if !self.expected.is_empty() {
            *lengths = std::mem::take(&mut self.expected);
        }
        starts.resize_with(points, AtomicU32::default);
        lengths.resize_with(points, || AtomicU16::new(FULL_NEIGHBOURHOOD));
        if as_before {
            for region in &mut self.regions {
                region.len = region.found;
            }
        } else {
            self.places_a_block = (CHUNK * places / points.max(1)).max(1);
            self.regions
                .resize(blocks(self.places_a_block), Region::default());
            let expected = |place: usize| {
                let (mut done, mut expected) = (0, 0);
                while let Some((_, rows)) = index.group(place, done) {
                    done += rows.len();
                    let len = |&row: &u32| usize::from(lengths[row as usize].load(Relaxed));
                    expected += rows.iter().map(len).sum::<usize>();
                }
                expected
            };
            let first_places = (0..places).step_by(self.places_a_block);
            for (region, first) in self.regions.iter_mut().zip(first_places) {
                let block = first..places.min(first + self.places_a_block);
                region.len = block.map(expected).sum();
            }
        }
        let mut start = 0;
        for region in &mut self.regions {
            region.start = start;
            region.found = 0;
            start += region.len;
        }
        self.set_len(start);
    }

    /// Makes the array so long.
    fn set_len(&mut self, len: usize) {
        self.rows.truncate(len);
        if self.rows.capacity() > len + 2 * room(len) {
            self.rows.shrink_to(len + room(len));
        }
        if self.rows.capacity() < len {
            self.rows.reserve_exact(len + room(len) - self.rows.len());
        }
        self.rows.resize(len, 0);
    }

    /// Brings the lists that found no room behind the others, and says how long the array is then.
    pub(super) fn gather_strays(&mut self) -> usize {
        let mut strays = std::mem::take(
            self.strays
                .get_mut()
                .unwrap_or_else(PoisonError::into_inner),
        );
        let mut start = self.rows.len();
        self.set_len(start + strays.len());
        let mut rest = &strays[..];
        while let &[row, len, ref lists @ ..] = rest {
            let (list, lists) = lists.split_at(len as usize);
            self.rows[start..start + list.len()].copy_from_slice(list);
            self.spans.set(row, start, list.len());
            start += list.len();
            rest = lists;
        }
        self.rows.truncate(start);
        strays.clear();
        if strays.capacity() > 4 * room(start) {
            strays.shrink_to(room(start));
        }
        self.strays = Mutex::new(strays);
        start
    }
}
