//! Every variant of a scene has a valid schedule, and every index structure gives the same result.

use glam::Vec3;
use overfall::{
    Simulation,
    scene::{
        Executor, IndexStructure, Neighbours, PressureMethod, Scene, SurfaceTension, TimeStep,
        Viscosity,
    },
    state::particle::{Fluid, Position},
};

use crate::common::{self, dam, methods, run, sesph, simulation, state};

/// Four particles per side, quick to set up.
fn small(flat: bool) -> Scene {
    let (dimension, depth) = if flat { (2, 0.0) } else { (3, 0.08) };
    let text = format!(
        r#"(
            name: "small",
            dimension: {dimension},
            spacing: 0.02,
            bodies: [(shape: Box(min: (0, 0, 0), max: (0.08, 0.08, {depth})))],
            boundaries: [Tank(min: (0, 0, 0), max: (0.2, 0.2, {depth}))],
        )"#
    );
    Scene::parse(&text, "small.ron", &[]).expect("a scene")
}

/// Every scene that differs from `scenes` in one field.
fn with<T: Clone>(scenes: Vec<Scene>, values: &[T], set: impl Fn(&mut Scene, T)) -> Vec<Scene> {
    let variants = |scene: Scene| {
        let variant = |value: &T| {
            let mut scene = scene.clone();
            set(&mut scene, value.clone());
            scene
        };
        values.iter().map(variant).collect::<Vec<_>>()
    };
    scenes.into_iter().flat_map(variants).collect()
}

#[test]
fn every_variant_of_a_scene_has_a_schedule_without_ambiguities() {
    let viscosities = [
        Viscosity::None,
        Viscosity::Laminar {
            kinematic_viscosity: 1e-5,
            numerical: Some(0.2),
        },
        Viscosity::Artificial {
            alpha: 0.05,
            sound_speed: 20.0,
        },
    ];
    let tensions = [
        SurfaceTension::None,
        SurfaceTension::BeckerTeschner { kappa: 0.01 },
    ];
    let pressures: [PressureMethod; 5] = methods();
    let scenes = vec![small(false), small(true)];
    let scenes = with(scenes, &viscosities, |scene, v| scene.fluid.viscosity = v);
    let scenes = with(scenes, &tensions, |scene, t| {
        scene.fluid.surface_tension = t
    });
    let scenes = with(scenes, &pressures, |scene, p| scene.pressure = p);
    let scenes = with(scenes, &[true, false], |scene, solid| {
        if !solid {
            scene.boundaries.clear();
        }
    });
    let lists = [Neighbours::Stored, Neighbours::Recomputed];
    let scenes = with(scenes, &lists, |scene, n| scene.neighbours = n);
    let steps = [TimeStep::default(), TimeStep::Fixed(1e-4)];
    let mut scenes = with(scenes, &steps, |scene, dt| scene.time_step = dt);
    // The other variants, spread over the ones so far.
    for (k, scene) in scenes.iter_mut().enumerate() {
        scene.reorder_interval = [0, 1][k / 3 % 2];
        scene.executor = [Executor::SingleThreaded, Executor::Parallel][k / 5 % 2];
        scene.index.structure = IndexStructure::ALL[k / 7 % IndexStructure::ALL.len()];
    }
    assert_eq!(scenes.len(), 480);
    for scene in scenes {
        let mut simulation = match Simulation::with_threads(&scene, 1) {
            Ok(simulation) => simulation,
            Err(error) => panic!("{error}: {scene:?}"),
        };
        run(&mut simulation, 2);
    }
}

#[test]
fn every_structure_gives_the_same_with_any_reordering() {
    for reorder_interval in [0, 1, 3] {
        let with = |structure| {
            let mut scene = Scene {
                pressure: sesph(),
                reorder_interval,
                ..dam()
            };
            scene.index.structure = structure;
            let mut simulation = simulation(&scene);
            run(&mut simulation, 12);
            // Changes by a host in between: rows are added, and removed by swapping with the last.
            let world = simulation.world_mut();
            let place = |k: u8| Vec3::new(0.3, 0.01 * f32::from(k), 0.1);
            world.spawn_batch((0..30).map(|k| (Fluid, Position(place(k)))));
            for (entity, ..) in state(world).into_iter().skip(5).step_by(100) {
                world.despawn(entity);
            }
            run(&mut simulation, 5);
            state(simulation.world_mut())
        };
        let expected = with(IndexStructure::BruteForce);
        for structure in IndexStructure::ALL {
            common::assert_near(&with(structure), &expected, 1e-5);
        }
    }
}
