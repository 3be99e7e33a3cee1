//! A step after warm-up allocates no memory.

use overfall::scene::{Executor, Neighbours};
use stats_alloc::Region;

use crate::common::{dam, methods, run, simulation};
use crate::{ALLOCATOR, alone};

/// The queue of the thread pool occasionally allocates a block for 63 jobs.
const QUEUE_BLOCK: usize = 1520;

/// Steps that are observed.
const STEPS: usize = 30;

#[test]
fn a_warm_step_allocates_nothing_but_the_queue_of_the_thread_pool() {
    let _alone = alone();
    for pressure in methods() {
        for neighbours in [Neighbours::Stored, Neighbours::Recomputed] {
            let mut scene = dam();
            scene.pressure = pressure;
            scene.neighbours = neighbours;
            // bevy's parallel executor creates a task per system: about 30 allocations of its own per step.
            scene.executor = Executor::SingleThreaded;
            // Reordering rows may allocate space in tables.
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
            // A splash occasionally makes a list longer than ever before; a buffer that grows in every step would be
            // noticed.
            assert!(
                change.reallocations <= STEPS / 2,
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
