//! Neighbours recomputed by every loop: the same results, without the memory of the lists.

use overfall::{
    neighbours::{BoundaryNeighbours, FluidNeighbours},
    scene::{Dimension, IndexStructure, Neighbours, Scene, Viscosity},
};

use crate::common::{bits, dam, methods, run, simulation};

/// Takes steps both ways and compares the bits.
fn assert_same_bits(scene: &Scene, steps: usize) {
    let mut stored = simulation(&Scene {
        neighbours: Neighbours::Stored,
        ..scene.clone()
    });
    let mut recomputed = simulation(&Scene {
        neighbours: Neighbours::Recomputed,
        ..scene.clone()
    });
    run(&mut stored, steps);
    run(&mut recomputed, steps);
    assert!(
        bits(stored.world_mut()) == bits(recomputed.world_mut()),
        "{scene:?}"
    );
}

#[test]
fn recomputed_neighbours_give_the_bits_of_stored_ones() {
    for pressure in methods() {
        // Including a reordering.
        let scene = Scene {
            pressure,
            reorder_interval: 7,
            ..dam()
        };
        assert_same_bits(&scene, 16);
    }
}

#[test]
fn recomputed_neighbours_give_the_bits_of_stored_ones_in_every_variant() {
    let laminar = Viscosity::Laminar {
        numerical: Some(0.1),
        kinematic_viscosity: 1e-3,
    };
    let mut scene = dam();
    scene.fluid.viscosity = laminar;
    for cell_size in [1.0 / 3.0, 0.7] {
        scene.index.cell_size = cell_size;
        assert_same_bits(&scene, 3);
    }
    scene.index.cell_size = 1.0;
    for structure in IndexStructure::ALL {
        scene.index.structure = structure;
        assert_same_bits(&scene, 4);
    }
    let mut scene = dam();
    scene.boundaries.clear();
    assert_same_bits(&scene, 5);
    let flat = Scene::parse(
        r#"(
            name: "flat",
            dimension: 2,
            spacing: 0.01,
            bodies: [(shape: Box(min: (0, 0, 0), max: (0.3, 0.4, 0)), jitter: (amplitude: 0.05))],
            boundaries: [Tank(min: (-0.01, -0.01, 0), max: (0.8, 0.8, 0))],
        )"#,
        "flat.ron",
        &[],
    )
    .expect("a scene");
    assert_eq!(flat.dimension, Dimension::Two);
    assert_same_bits(&flat, 10);
}

#[test]
fn recomputed_neighbours_hold_no_lists() {
    let scene = Scene {
        neighbours: Neighbours::Recomputed,
        ..dam()
    };
    let mut simulation = simulation(&scene);
    let report = simulation.step().expect("a step");
    assert!(!simulation.world().contains_resource::<FluidNeighbours>());
    assert!(!simulation.world().contains_resource::<BoundaryNeighbours>());
    assert_eq!(report.mean_neighbours, 0.0);
}
