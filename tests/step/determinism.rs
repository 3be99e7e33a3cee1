//! The determinism contract: the same scene gives the same bits, whatever the threads, the executor and, among machines
//! with fused multiply-add, the machine.

use bevy_ecs::schedule::{IntoScheduleConfigs, LogLevel, ScheduleBuildSettings};
use overfall::{
    Simulation, Step, StepReport,
    scene::{Executor, IndexStructure, Neighbours, Scene, TimeStep},
    simd::InstructionSet,
    state::Execution,
};

use crate::common::{bits, bits_after, dam, methods, run, sesph};

/// Three reorderings and some steps.
const STEPS: usize = 61;

fn scenes() -> [Scene; 5] {
    methods().map(|pressure| Scene { pressure, ..dam() })
}

#[test]
fn the_number_of_threads_changes_no_bit() {
    for scene in scenes() {
        assert!(matches!(scene.time_step, TimeStep::Cfl(_)));
        let expected = bits_after(&scene, 1, STEPS);
        for threads in 2..=8 {
            assert!(
                bits_after(&scene, threads, STEPS) == expected,
                "{threads} threads, {:?}",
                scene.pressure
            );
        }
    }
}

#[test]
fn the_number_of_threads_changes_no_bit_of_recomputed_neighbours() {
    for scene in scenes() {
        let scene = Scene {
            neighbours: Neighbours::Recomputed,
            reorder_interval: 3,
            ..scene
        };
        let expected = bits_after(&scene, 1, 8);
        assert!(bits_after(&scene, 3, 8) == expected, "{:?}", scene.pressure);
    }
}

#[test]
fn the_number_of_threads_changes_no_bit_of_any_structure() {
    for structure in IndexStructure::ALL {
        let mut scene = Scene {
            pressure: sesph(),
            reorder_interval: 7,
            ..dam()
        };
        scene.index.structure = structure;
        let expected = bits_after(&scene, 1, 20);
        assert!(bits_after(&scene, 3, 20) == expected, "{structure:?}");
    }
}

#[test]
fn the_executor_changes_no_bit() {
    for scene in scenes() {
        let [single, parallel] = [Executor::SingleThreaded, Executor::Parallel].map(|executor| {
            let scene = Scene {
                executor,
                ..scene.clone()
            };
            bits_after(&scene, 2, 30)
        });
        assert!(single == parallel, "{:?}", scene.pressure);
    }
}

/// Two systems without an order between them, and nothing else to order them by.
fn idle() {}

/// What may run in any order does: none of it decides a bit.
#[test]
fn the_order_of_what_is_free_changes_no_bit() {
    for pressure in methods() {
        let scene = Scene { pressure, ..dam() };
        let expected = bits_after(&scene, 1, 25);
        for seed in 0..4 {
            let executor = [Executor::SingleThreaded, Executor::Parallel][seed as usize % 2];
            let scene = Scene {
                executor,
                ..scene.clone()
            };
            let mut simulation = Simulation::with_threads(&scene, 2).expect("a scene that runs");
            simulation.world_mut().schedule_scope(Step, |_, step| {
                step.set_build_settings(ScheduleBuildSettings {
                    ambiguity_detection: LogLevel::Error,
                    shuffle_seed: Some(seed),
                    ..Default::default()
                });
                // A new system, so that the schedule is built again.
                step.add_systems((idle.ambiguous_with_all(), idle.ambiguous_with_all()));
            });
            run(&mut simulation, 25);
            assert!(
                bits(simulation.world_mut()) == expected,
                "seed {seed}, {pressure:?}"
            );
        }
    }
}

#[test]
fn a_scene_that_was_stored_and_reloaded_gives_the_same_bits() {
    for scene in scenes() {
        let text = scene.to_ron().expect("a text");
        let again = Scene::parse(&text, "again.ron", &[]).expect("the same scene");
        assert!(bits_after(&again, 2, 20) == bits_after(&scene, 1, 20));
    }
}

/// Reports and the failure of a run that fails, without wall times.
fn told(scene: &Scene, threads: usize) -> (Vec<StepReport>, String) {
    let mut simulation = Simulation::with_threads(scene, threads).expect("a scene that runs");
    let mut reports = Vec::new();
    loop {
        match simulation.step() {
            Ok(mut report) => {
                report.phase_seconds = Default::default();
                reports.push(report);
            }
            Err(error) => return (reports, error.to_string()),
        }
        assert!(reports.len() < 500, "it never fails");
    }
}

#[test]
fn reports_and_failures_are_the_same_on_any_number_of_threads_and_again() {
    let domain = overfall::scene::Bounds {
        min: glam::Vec3::splat(-0.1),
        max: glam::Vec3::new(0.27, 0.5, 0.5),
    };
    for scene in scenes() {
        let scene = Scene {
            domain: Some(domain),
            ..scene
        };
        let expected = told(&scene, 1);
        assert!(
            expected.1.contains("domain") && expected.0.len() > 5,
            "{}",
            expected.1
        );
        for threads in [1, 2, 5, 8] {
            assert!(told(&scene, threads) == expected, "{threads} threads");
        }
        let parallel = Scene {
            executor: Executor::Parallel,
            ..scene
        };
        assert!(told(&parallel, 2) == expected, "parallel systems");
    }
}

/// Bits of a run on one instruction set.
fn bits_with(scene: &Scene, instruction_set: InstructionSet, steps: usize) -> Vec<[u32; 6]> {
    let mut simulation = Simulation::with_threads(scene, 2).expect("a scene that runs");
    let mut execution = simulation.world_mut().resource_mut::<Execution>();
    execution.instruction_set = instruction_set;
    run(&mut simulation, steps);
    bits(simulation.world_mut())
}

#[test]
fn instruction_sets_with_fused_multiply_add_give_the_same_bits() {
    let fused: Vec<_> = InstructionSet::available()
        .into_iter()
        .filter(|&set| set != InstructionSet::Portable)
        .collect();
    for scene in scenes() {
        for pair in fused.windows(2) {
            let [first, second] = [pair[0], pair[1]].map(|set| bits_with(&scene, set, 20));
            assert!(first == second, "{pair:?}, {:?}", scene.pressure);
        }
    }
}

/// FNV-1a over the bits of positions and velocities, by entity.
fn hash(bits: &[[u32; 6]]) -> u64 {
    let bytes = bits.iter().flatten().flat_map(|word| word.to_le_bytes());
    bytes.fold(0xcbf2_9ce4_8422_2325, |hash, byte| {
        (hash ^ u64::from(byte)).wrapping_mul(0x0000_0100_0000_01b3)
    })
}

/// Hashes of SESPH, PCISPH, IISPH, DFSPH and δ-SPH after [`STEPS`] steps.
///
/// They change with the arithmetic of the particle loops and with the order of sums, and with nothing else. If such a
/// change is intended, run `cargo test --test step golden` and copy the numbers that it prints. Otherwise the change
/// has introduced a forbidden dependence.
const GOLDEN: [u64; 5] = [
    0x7d1f_9c39_ee44_aaed,
    0x8b8c_db0b_80a8_e5a4,
    0x671e_e4ef_ff8b_c3aa,
    0x6d04_1c37_40b9_0d9b,
    0x3330_856f_f8c3_ce9d,
];

#[test]
fn the_golden_hash_is_reached_with_fused_multiply_add() {
    // Without fused multiply-add every product is rounded separately, which gives other bits of equal accuracy.
    if InstructionSet::detect() == InstructionSet::Portable && !cfg!(target_feature = "fma") {
        return;
    }
    let found = scenes().map(|scene| hash(&bits_after(&scene, 2, STEPS)));
    assert!(found == GOLDEN, "found {found:#018x?}");
}
