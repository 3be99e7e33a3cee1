//! Destinations of the sums of a pass: one sink per chunk of rows, called with the index of a row in the chunk and its
//! sum.

use std::ops::AddAssign;

use rayon::prelude::*;

use crate::state::CHUNK;

/// Sinks that store sums in a column with one entry per row.
pub fn store<T: Send>(
    column: &mut [T],
) -> impl IndexedParallelIterator<Item = impl FnMut(usize, T) + Send> {
    let chunks = column.par_chunks_mut(CHUNK);
    chunks.map(|column| |k: usize, sum| column[k] = sum)
}

/// Sinks that add sums to a column with one entry per row.
pub fn add<T: Send + AddAssign>(
    column: &mut [T],
) -> impl IndexedParallelIterator<Item = impl FnMut(usize, T) + Send> {
    let chunks = column.par_chunks_mut(CHUNK);
    chunks.map(|column| |k: usize, sum| column[k] += sum)
}

/// Sinks for the sums of two fused passes.
pub fn zip<A, B>(
    first: impl IndexedParallelIterator<Item = impl FnMut(usize, A) + Send>,
    second: impl IndexedParallelIterator<Item = impl FnMut(usize, B) + Send>,
) -> impl IndexedParallelIterator<Item = impl FnMut(usize, (A, B)) + Send> {
    first.zip(second).map(|(mut first, mut second)| {
        move |k: usize, (a, b)| {
            first(k, a);
            second(k, b);
        }
    })
}
