//! A warm step works in the memory that it has.

mod common;

use std::alloc::System;

use common::{dam, methods, run, simulation};
use overfall::scene::{Executor, Neighbours};
use stats_alloc::{INSTRUMENTED_SYSTEM, Region, StatsAlloc};

#[global_allocator]
static ALLOCATOR: &StatsAlloc<System> = &INSTRUMENTED_SYSTEM;

/// What the queue of the thread pool takes now and then: a block for 63 pieces of work.
const QUEUE_BLOCK: usize = 1520;

/// Steps that are watched.
const STEPS: usize = 30;

/// One test, so that nothing else allocates meanwhile.
#[test]
fn a_warm_step_allocates_nothing_but_the_queue_of_the_thread_pool() {
    for pressure in methods() {
        for neighbours in [Neighbours::Stored, Neighbours::Recomputed] {
            let mut scene = dam();
            scene.pressure = pressure;
            scene.neighbours = neighbours;
            // Bevy's parallel executor makes a task of every system: some 30 allocations of its own a step.
            scene.executor = Executor::SingleThreaded;
            // Moving rows is allowed to make room in tables.
            scene.reorder_interval = 0;
            let mut simulation = simulation(&scene);
            run(&mut simulation, 60);
            let region = Region::new(ALLOCATOR);
            run(&mut simulation, STEPS);
            let change = region.change();
            assert!(
                change.allocations <= 2 * STEPS,
                "{pressure:?} {neighbours:?}: {} allocations in {STEPS} steps",
                change.allocations
            );
            // A splash makes some list longer than ever now and then; a buffer that grew in every step would show.
            assert!(
                change.reallocations <= STEPS / 3,
                "{pressure:?} {neighbours:?}: {} buffers grew in {STEPS} steps",
                change.reallocations
            );
            let fresh = change.bytes_allocated as isize - change.bytes_reallocated;
            assert!(
                fresh <= (2 * STEPS * QUEUE_BLOCK) as isize,
                "{pressure:?} {neighbours:?}: {fresh} bytes in {STEPS} steps",
            );
        }
    }
}
