//! Where loops run: a rayon pool of their own and an instruction set.
//!
//! Systems of bevy's executor run on bevy's task threads, which rayon's `install` around the step would not reach:
//! so the pool is a resource, and every loop enters it.

use std::{io, num::NonZero, sync::Arc, thread::available_parallelism};

use bevy_ecs::prelude::*;
use rayon::prelude::*;

use super::room::needs_room;
use crate::{communicator::Team, simd::InstructionSet};

/// Rows that one task works on. Fixed, so that partial results do not depend on the number of threads.
pub const CHUNK: usize = 1024;

/// Threads and instruction set of all loops.
#[derive(Resource, Clone)]
pub struct Execution {
    pool: Arc<rayon::ThreadPool>,
    /// Instruction set of the neighbour loops.
    pub instruction_set: InstructionSet,
    /// The other ranks, where there are some.
    pub(super) team: Option<Arc<Team>>,
}

impl Execution {
    /// A pool of `threads`; 0 takes one for every core. Fails if the system refuses the threads or their memory.
    pub fn new(threads: usize) -> io::Result<Self> {
        let cores = || available_parallelism().map_or(1, NonZero::get);
        needs_room(if threads == 0 { cores() } else { threads })?;
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(threads)
            .thread_name(|k| format!("overfall-{k}"))
            .build()
            .map_err(io::Error::other)?;
        Ok(Self::with_pool(Arc::new(pool)))
    }

    /// A pool of the host's, which its own loops may share. Insert it before the scene is installed.
    pub fn with_pool(pool: Arc<rayon::ThreadPool>) -> Self {
        Self {
            pool,
            instruction_set: InstructionSet::detect(),
            team: None,
        }
    }

    /// The pool.
    pub fn pool(&self) -> &Arc<rayon::ThreadPool> {
        &self.pool
    }

    /// Number of threads.
    pub fn threads(&self) -> usize {
        self.pool.current_num_threads()
    }

    /// Whether the thread that asks is one of the pool's.
    pub(crate) fn is_inside(&self) -> bool {
        self.pool.current_thread_index().is_some()
    }

    /// Runs `work` in the pool.
    pub fn install<R: Send>(&self, work: impl FnOnce() -> R + Send) -> R {
        self.pool.install(work)
    }

    /// Calls `work` with the first row and the chunk of `column`, for every chunk, in parallel.
    pub fn for_each_chunk<T: Send>(&self, column: &mut [T], work: impl Fn(usize, &mut [T]) + Sync) {
        self.install(|| {
            column
                .par_chunks_mut(CHUNK)
                .enumerate()
                .for_each(|(chunk, rows)| work(chunk * CHUNK, rows));
        });
    }
}

impl Execution {
    /// Copies a column onto one of the same length, in parallel.
    pub fn copy<T: Copy + Send + Sync>(&self, to: &mut [T], from: &[T]) {
        self.for_each_chunk(to, |first, to| {
            to.copy_from_slice(&from[first..first + to.len()]);
        });
    }

    /// Calls `work` with the first row and the chunks of two columns of one length, for every chunk, in parallel, and
    /// keeps what it gives.
    pub fn map_chunks<A: Send, B: Send, R: Send>(
        &self,
        (a, b): (&mut [A], &mut [B]),
        results: &mut [R],
        work: impl Fn(usize, &mut [A], &mut [B]) -> R + Sync,
    ) {
        self.install(|| {
            results
                .par_iter_mut()
                .zip(a.par_chunks_mut(CHUNK))
                .zip(b.par_chunks_mut(CHUNK))
                .enumerate()
                .for_each(|(chunk, ((result, a), b))| *result = work(chunk * CHUNK, a, b));
        });
    }
}

/// One result a chunk, kept from step to step and folded in the order of the rows: the same for any number of threads.
#[derive(Debug, Default, Clone)]
pub struct ChunkResults<T>(pub(super) Vec<T>);

impl<T: Default + Clone + Send> ChunkResults<T> {
    /// A place for every chunk of `rows` rows, at its default.
    pub fn reset(&mut self, rows: usize) -> &mut [T] {
        self.0.clear();
        self.0.resize(rows.div_ceil(CHUNK), T::default());
        &mut self.0
    }

    /// The results in the order of the rows.
    pub fn iter(&self) -> std::slice::Iter<'_, T> {
        self.0.iter()
    }
}
