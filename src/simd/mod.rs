//! Eight lanes of `f32`, chosen at run time: the only module with `unsafe`.
//!
//! A neighbour loop is written once, generic over [`Simd`], and [`InstructionSet::dispatch`] compiles it for every
//! instruction set. Eight lanes in every path, IEEE division and square root, sums folded in one fixed tree: paths
//! with fused multiply-add give the same bits. AVX-512 changes no arithmetic; it tests sixteen candidates at once
//! and compacts the hits, which gives the same lists.
//!
//! Tried and dropped: sixteen lanes, one vector of AVX-512 or two of AVX2, which gives the same bits on all machines,
//! too. With AVX-512 a density pass took 15 % less, but a step 0 to 5 %, since most passes wait for loads; and compact
//! hashing, whose cells have eight points, compared them 1.4 times as long with AVX-512 and three times with AVX2.

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
