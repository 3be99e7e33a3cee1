//! Eight lanes of `f32`, chosen at run time: the only module with `unsafe`.
//!
//! A neighbour loop is written once, generic over [`Simd`], and [`InstructionSet::dispatch`] compiles it for every
//! instruction set. Every path has eight lanes, IEEE division and square root, and sums in one fixed tree, so paths
//! with fused multiply-add give the same bits. AVX-512 does not change the arithmetic: it tests sixteen candidates at
//! once and compacts the hits, which gives the same lists.
//!
//! Tried and rejected: sixteen lanes (one AVX-512 vector or two of AVX2), with the same bits on all machines. A density
//! pass with AVX-512 took 15 % less time, but a step only 0 to 5 %, because most passes wait for loads. Compact
//! hashing, with eight points per cell, took 1.4 times as long to compare them with AVX-512 and 3 times with AVX2.

#[cfg(target_arch = "x86_64")]
mod avx512;
mod cache;
mod candidates;
mod instruction_set;
mod portable;
mod vector;
#[cfg(target_arch = "x86_64")]
mod wide;
#[cfg(target_arch = "x86_64")]
mod x86;

pub(crate) use cache::prefetch;
pub(crate) use candidates::FIRST_ROOM;
pub use candidates::{CANDIDATE_ALIGNMENT, Candidates, Near, Probe, Run};
pub use instruction_set::InstructionSet;
pub use portable::Portable;
pub use vector::{Cube, LANES, Lanes, Simd, Vectorised};

#[cfg(test)]
mod tests;
