//! Parallel radix sort of handles (paper 4.2, 6.1.2), least significant digit first.
//!
//! Each pass counts digits per chunk, computes destinations by a prefix sum, and moves the handles. Chunks write to
//! interleaved destinations, but each destination is written once: relaxed atomics, which compile to plain moves,
//! express this without `unsafe`. The sorted order is unique, so it does not depend on the number of threads.

use std::sync::atomic::{AtomicU64, Ordering::Relaxed};

use rayon::prelude::*;

use super::table::{Handle, key_of};
use crate::state::Execution;

/// Handles per task.
const CHUNK: usize = 8192;
/// Maximum bits of a digit: the 2 KiB of write positions of a chunk stay in the first-level cache.
const DIGIT: u32 = 9;

/// Handles and the buffers for sorting.
#[derive(Debug, Default)]
pub(super) struct RadixSort {
    handles: Vec<AtomicU64>,
    spare: Vec<AtomicU64>,
    /// For every chunk and digit the count, later the next destination.
    places: Vec<u32>,
}

impl RadixSort {
    /// The handle at a position of the sorted order.
    #[inline(always)]
    pub(super) fn get(&self, k: usize) -> Handle {
        self.handles[k].load(Relaxed)
    }

    /// Sorts handles of ascending rows by their keys, which are less than `keys`.
    pub(super) fn sort(
        &mut self,
        handles: impl IndexedParallelIterator<Item = Handle>,
        keys: u32,
        execution: &Execution,
    ) {
        let bits = u32::BITS - keys.saturating_sub(1).leading_zeros();
        let passes = bits.div_ceil(DIGIT).max(1);
        let digit = bits.div_ceil(passes);
        execution.install(|| {
            handles
                .map(AtomicU64::new)
                .collect_into_vec(&mut self.handles);
            self.spare
                .resize_with(self.handles.len(), AtomicU64::default);
            for pass in 0..passes {
                self.pass(pass * digit, digit);
                std::mem::swap(&mut self.handles, &mut self.spare);
            }
        });
    }

    fn pass(&mut self, shift: u32, bits: u32) {
        let digits = 1usize << bits;
        let digit =
            |handle: &AtomicU64| (key_of(handle.load(Relaxed)) >> shift) as usize & (digits - 1);
        let chunks = self.handles.len().div_ceil(CHUNK);
        self.places.clear();
        self.places.resize(chunks * digits, 0);
        self.places
            .par_chunks_mut(digits)
            .zip(self.handles.par_chunks(CHUNK))
            .for_each(|(places, handles)| {
                handles.iter().for_each(|handle| places[digit(handle)] += 1);
            });
        let mut place = 0;
        for digit in 0..digits {
            for chunk in 0..chunks {
                let count = &mut self.places[chunk * digits + digit];
                place += std::mem::replace(count, place);
            }
        }
        let spare = &self.spare;
        self.places
            .par_chunks_mut(digits)
            .zip(self.handles.par_chunks(CHUNK))
            .for_each(|(places, handles)| {
                for handle in handles {
                    let place = &mut places[digit(handle)];
                    spare[*place as usize].store(handle.load(Relaxed), Relaxed);
                    *place += 1;
                }
            });
    }

    pub(super) fn bytes(&self) -> usize {
        (self.handles.capacity() + self.spare.capacity()) * size_of::<u64>()
            + self.places.capacity() * size_of::<u32>()
    }
}
