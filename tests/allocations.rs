//! A step after warm-up allocates no memory.

mod common;

use std::alloc::System;

use common::{dam, methods, run, simulation};
use overfall::scene::{Executor, Neighbours};
use stats_alloc::{INSTRUMENTED_SYSTEM, Region, StatsAlloc};

#[global_allocator]
static ALLOCATOR: &StatsAlloc<System> = &INSTRUMENTED_SYSTEM;

/// The queue of the thread pool occasionally allocates a block for 63 jobs.
const QUEUE_BLOCK: usize = 1520;

/// Steps that are observed.
const STEPS: usize = 30;

/// Two measures in a single test, so that nothing else allocates at the same time.
#[test]
fn a_warm_step_and_a_bare_scene_allocate_no_more_than_they_need() {
    what_a_scene_leaves_out_takes_no_memory();
    a_warm_step_allocates_nothing_but_the_queue_of_the_thread_pool();
}

/// Memory of a scene's world after a few steps \[bytes].
fn held(scene: &overfall::scene::Scene) -> f64 {
    let region = Region::new(ALLOCATOR);
    let mut simulation = simulation(scene);
    run(&mut simulation, 3);
    let change = region.change();
    let held = change.bytes_allocated as f64 - change.bytes_deallocated as f64;
    drop(simulation);
    held
}

/// Each thing that is left out frees what `check` says that it takes, or more; all of them together a third of the
/// memory and more.
fn what_a_scene_leaves_out_takes_no_memory() {
    let change = |scene: &overfall::scene::Scene, set: &[&str]| {
        let changes = set
            .iter()
            .map(|text| overfall::Override::parse(text).expect("an override"));
        let scene = changes.fold(scene.clone(), |scene, change| {
            change.apply(&scene).expect("a scene")
        });
        let bytes = overfall::plan(&scene).expect("a plan").bytes_per_particle;
        let bytes: f64 = bytes.iter().map(|part| part.1).sum();
        (held(&scene), bytes, scene)
    };
    let mut full = dam();
    full.executor = Executor::SingleThreaded;
    let (all, planned, _) = change(&full, &[]);
    let set = [
        "neighbours=Recomputed",
        "fluid.viscosity=None",
        "fluid.surface_tension=None",
        "boundaries=[]",
    ];
    for leave_out in set {
        let (without, less, scene) = change(&full, &[leave_out]);
        let saved = (planned - less) * common::DAM_PARTICLES as f64;
        // Vectors grow in steps of two.
        assert!(
            all - without >= 0.8 * saved - 0.01 * all,
            "{leave_out}: {all} {without}, planned {saved}"
        );
        assert!(
            without <= all && less <= planned,
            "{leave_out}: {} bytes",
            less
        );
        drop(scene);
    }
    let (bare, _, _) = change(&full, &set);
    assert!(bare < 0.67 * all, "{bare} of {all} bytes");
}

fn a_warm_step_allocates_nothing_but_the_queue_of_the_thread_pool() {
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
