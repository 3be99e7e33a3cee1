//! Where the sums of a pass go: takers, one a chunk of rows, that are called with a row's place in the chunk and its
//! sum.

use std::ops::AddAssign;

use rayon::prelude::*;

use crate::state::CHUNK;

/// Takers that put sums into a column, which has one entry a row.
pub fn putting<T: Send>(
    column: &mut [T],
) -> impl IndexedParallelIterator<Item = impl FnMut(usize, T) + Send> {
    let chunks = column.par_chunks_mut(CHUNK);
    chunks.map(|column| |k: usize, sum| column[k] = sum)
}

/// Takers that add sums to a column, which has one entry a row.
pub fn adding<T: Send + AddAssign>(
    column: &mut [T],
) -> impl IndexedParallelIterator<Item = impl FnMut(usize, T) + Send> {
    let chunks = column.par_chunks_mut(CHUNK);
    chunks.map(|column| |k: usize, sum| column[k] += sum)
}

/// Takers of the sums of two passes in one.
pub fn both<A, B>(
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
