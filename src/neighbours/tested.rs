//! The paper's count of tested pairs.

use super::search::{Scratch, Search};
use crate::simd::Portable;

/// Number of distances that the paper's query computes: for every row all candidates around its cell, including the
/// row itself. This implementation computes fewer, since it first rejects candidates that no point of the cell
/// reaches.
pub fn tested_pairs(search: &Search) -> usize {
    let mut scratch = Scratch::default();
    let mut tested = 0;
    for partition in 0..search.of.partitions() {
        let mut done = 0;
        while let Some((coordinates, members)) = search.of.next_cell(partition, done) {
            done += members.len();
            scratch.fetch(Portable, search, (Some(partition), coordinates), &[]);
            let own = members
                .iter()
                .filter(|&&row| (row as usize) < search.points.len());
            tested += own.count() * scratch.candidates.len();
        }
    }
    tested
}
