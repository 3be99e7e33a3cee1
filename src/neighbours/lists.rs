//! Neighbour lists in one flat array, with a span for every row.

use std::sync::{
    Mutex, PoisonError,
    atomic::{AtomicU16, AtomicU32, Ordering::Relaxed},
};

use crate::{index::SpatialIndex, simd::prefetch, state::CHUNK};

/// Approximate number of neighbours of a particle inside the fluid at the default support: the expected length of a
/// list before its first search.
const FULL_NEIGHBOURHOOD: u16 = 30;

/// Reserve for an array of `len` entries that grows slightly between steps and should not be reallocated in each.
fn room(len: usize) -> usize {
    len / 256 + 1024
}

/// Neighbour lists of all rows.
///
/// Memory: 4 bytes per neighbour and 6 per row, plus one percent. Every block gets the part of the array that it
/// needed in the last search, so that few entries are unused; a list that does not fit is appended at the end. A
/// reserve of a sixteenth per block with spans of 8 bytes needed 17 % more.
#[derive(Debug, Default)]
pub struct NeighbourLists {
    pub(super) spans: Spans,
    /// The lists.
    pub(super) rows: Vec<u32>,
    /// One per block of partitions.
    pub(super) regions: Vec<Region>,
    /// Chosen such that a block has about [`CHUNK`] rows. Larger blocks vary less in length, and need less reserve.
    pub(super) partitions_per_block: usize,
    /// Lists that did not fit their region, each preceded by its row and length.
    pub(super) strays: Mutex<Vec<u32>>,
    /// Expected lengths of the lists after rows were permuted; otherwise empty.
    expected: Vec<AtomicU16>,
}

/// Start and length of every list. The rows of a cell are scattered, and each is written by one cell only: relaxed
/// atomics, which compile to plain moves, express this without `unsafe`.
#[derive(Debug, Default)]
pub(super) struct Spans {
    starts: Vec<AtomicU32>,
    lengths: Vec<AtomicU16>,
}

/// Part of the flat array that a block of partitions writes.
#[derive(Debug, Default, Clone, Copy)]
pub(super) struct Region {
    pub(super) start: usize,
    /// Expected number of entries.
    pub(super) len: usize,
    /// Number of entries found, which may be larger.
    pub(super) found: usize,
}

impl Spans {
    /// Sets the span of a row. Values out of range are detected at the end of the search.
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
    /// Neighbours of `row`; empty if the row was added after the search (possible if an order keeps stale lists).
    #[inline(always)]
    pub fn of(&self, row: usize) -> &[u32] {
        let (start, len) = self.spans.get(row).unwrap_or_default();
        &self.rows[start..start + len]
    }

    /// Prefetches the list of `row`, at most 48 entries.
    ///
    /// Lists are stored in cell order, rows in the order of the last reordering, and the two diverge as particles
    /// move: loops over rows waited for the lists half of the time. Prefetching reduced the time of a dam break's
    /// first 0.45 s (PCISPH, two threads, 103 ms per step) by 28 %.
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

    /// Number of pairs of a row and a neighbour in all lists.
    pub fn pairs(&self) -> usize {
        self.regions.iter().map(|region| region.found).sum()
    }

    /// Memory held \[bytes].
    pub fn bytes(&self) -> usize {
        self.spans.starts.capacity() * size_of::<AtomicU32>()
            + self.spans.lengths.capacity() * size_of::<AtomicU16>()
            + self.expected.capacity() * size_of::<AtomicU16>()
            + self.rows.capacity() * size_of::<u32>()
            + self.strays.lock().map_or(0, |strays| strays.capacity()) * size_of::<u32>()
            + self.regions.capacity() * size_of::<Region>()
    }

    /// Lengths and entries of the lists of all rows, one after the other.
    pub(super) fn to_parts(&self, rows: usize) -> (Vec<u16>, Vec<u32>) {
        let lengths = (0..rows).map(|row| self.of(row).len() as u16).collect();
        let entries = (0..rows).flat_map(|row| self.of(row)).copied().collect();
        (lengths, entries)
    }

    /// Lists of so many rows from [`to_parts`](Self::to_parts); none if they do not fit, or name one that is not
    /// `among` those that exist.
    pub(super) fn from_parts(
        (lengths, entries): (Vec<u16>, Vec<u32>),
        rows: usize,
        among: usize,
    ) -> Option<Self> {
        let total: usize = lengths.iter().map(|&len| usize::from(len)).sum();
        let fits = lengths.len() == rows
            && total == entries.len()
            && u32::try_from(total).is_ok()
            && entries.iter().all(|&entry| (entry as usize) < among);
        let mut end = 0;
        let start = |len: &u16| {
            let start = end;
            end += u32::from(*len);
            AtomicU32::new(start)
        };
        fits.then(|| Self {
            spans: Spans {
                starts: lengths.iter().map(start).collect(),
                lengths: lengths.iter().map(|&len| AtomicU16::new(len)).collect(),
            },
            rows: entries,
            regions: vec![Region {
                start: 0,
                len: total,
                found: total,
            }],
            ..Self::default()
        })
    }

    /// Removes all lists.
    pub(super) fn clear(&mut self) {
        self.spans = Spans::default();
        self.expected.clear();
        self.regions.clear();
        self.strays = Mutex::default();
    }

    /// Announces a permutation of rows before the next search: row k was `old_rows[k]`. The lists stay as they are.
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

    /// Gives every block a region as long as its lists were. If the number of blocks or rows changed, the lengths are
    /// summed over the rows of each block, which costs 3 to 5 ns per row.
    pub(super) fn lay_out(&mut self, index: &dyn SpatialIndex, points: usize) {
        let partitions = index.partitions();
        let blocks = |partitions_per_block: usize| partitions.div_ceil(partitions_per_block.max(1));
        let Spans { starts, lengths } = &mut self.spans;
        let as_before = self.expected.is_empty()
            && lengths.len() == points
            && self.regions.len() == blocks(self.partitions_per_block);
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
            self.partitions_per_block = (CHUNK * partitions / points.max(1)).max(1);
            self.regions
                .resize(blocks(self.partitions_per_block), Region::default());
            let expected = |partition: usize| {
                let (mut done, mut expected) = (0, 0);
                while let Some((_, rows)) = index.next_cell(partition, done) {
                    done += rows.len();
                    // Images of points have no lists.
                    let len = |&row: &u32| {
                        let len = lengths.get(row as usize);
                        len.map_or(0, |len| usize::from(len.load(Relaxed)))
                    };
                    expected += rows.iter().map(len).sum::<usize>();
                }
                expected
            };
            let first_partitions = (0..partitions).step_by(self.partitions_per_block);
            for (region, first) in self.regions.iter_mut().zip(first_partitions) {
                let block = first..partitions.min(first + self.partitions_per_block);
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

    /// Sets the length of the array.
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

    /// Appends the lists that did not fit, and returns the resulting length of the array.
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
