//! The determinism contract: the same scene gives the same bits, whatever the threads, the executor and, among machines
//! with fused multiply-add, the machine.

use overfall::{
    Simulation,
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
        for threads in [2, 3] {
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
    0,
    0x7d1f_9c39_ee44_aaed,
    0xa326_ff87_f821_0d4e,
    0x7489_dc06_defb_a8a3,
    0xad24_5d69_758c_fd8b,
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
