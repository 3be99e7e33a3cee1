//! Scenes and comparisons that several tests share.

#![allow(
    dead_code,
    reason = "every crate that has this module uses a part of it"
)]

use bevy_ecs::prelude::*;
use glam::Vec3;
use overfall::{
    Phase, Simulation,
    scene::{DeltaSph, Dfsph, Iisph, Pcisph, PressureMethod, Scene, Sesph, StateEquation},
    state::particle::{Fluid, Position, Velocity},
};

/// The phases after and before which a host's system may run within a step.
pub(crate) const PLACES: [(Phase, Phase); 7] = [
    (Phase::RebuildIndex, Phase::FindNeighbours),
    (Phase::FindNeighbours, Phase::Density),
    (Phase::Density, Phase::Forces),
    (Phase::Forces, Phase::Pressure),
    (Phase::Pressure, Phase::Integrate),
    (Phase::Integrate, Phase::Reorder),
    (Phase::Reorder, Phase::Observe),
];

/// A column of 10 × 12 × 10 particles that collapses in a tank, with every feature of a scene switched on. It is
/// disordered, so that pressure acts from the first step.
pub(crate) fn dam() -> Scene {
    Scene::parse(
        r#"(
            name: "dam",
            spacing: 0.02,
            fluid: (
                viscosity: Artificial(alpha: 0.05, sound_speed: 20),
                surface_tension: BeckerTeschner(kappa: 0.01),
            ),
            bodies: [(
                shape: Box(min: (0, 0, 0), max: (0.2, 0.24, 0.2)),
                velocity: (0.5, 0, 0.2),
                jitter: (amplitude: 0.05, seed: 1),
            )],
            boundaries: [Tank(min: (-0.02, -0.02, -0.02), max: (0.4, 0.4, 0.22))],
            reorder_interval: 20,
        )"#,
        "dam.ron",
        &[],
    )
    .expect("a scene")
}

/// Particles of [`dam`].
pub(crate) const DAM_PARTICLES: usize = 1200;

/// The equation of state, stiff enough for [`dam`].
pub(crate) fn sesph() -> PressureMethod {
    PressureMethod::Sesph(Sesph {
        equation: StateEquation::Tait {
            stiffness: 60_000.0,
        },
    })
}

/// The iterative method at its defaults.
pub(crate) fn pcisph() -> PressureMethod {
    PressureMethod::Pcisph(Pcisph::default())
}

/// Every pressure method: SESPH, PCISPH, IISPH, DFSPH, δ-SPH.
pub(crate) fn methods() -> [PressureMethod; 5] {
    [
        sesph(),
        pcisph(),
        PressureMethod::Iisph(Iisph::default()),
        PressureMethod::Dfsph(Dfsph::default()),
        PressureMethod::DeltaSph(DeltaSph {
            sound_speed: Some(20.0),
            ..DeltaSph::default()
        }),
    ]
}

/// The simulation of a scene on two threads.
pub(crate) fn simulation(scene: &Scene) -> Simulation {
    Simulation::with_threads(scene, 2).expect("a scene that runs")
}

/// Takes `steps` steps, which must succeed.
pub(crate) fn run(simulation: &mut Simulation, steps: usize) {
    for _ in 0..steps {
        if let Err(error) = simulation.step() {
            panic!("{error}");
        }
    }
}

/// Entity, position \[m] and velocity \[m/s] of every fluid particle, by entity.
pub(crate) fn state(world: &mut World) -> Vec<(Entity, Vec3, Vec3)> {
    let mut fluid = world.query_filtered::<(Entity, &Position, &Velocity), With<Fluid>>();
    let mut state: Vec<_> = fluid.iter(world).map(|(e, x, v)| (e, x.0, v.0)).collect();
    state.sort_by_key(|particle| particle.0);
    state
}

/// The bits of positions and velocities, by entity.
pub(crate) fn bits(world: &mut World) -> Vec<[u32; 6]> {
    let bits = |(_, x, v): (Entity, Vec3, Vec3)| [x.x, x.y, x.z, v.x, v.y, v.z].map(f32::to_bits);
    state(world).into_iter().map(bits).collect()
}

/// Runs the scene and returns the bits of its state.
pub(crate) fn bits_after(scene: &Scene, threads: usize, steps: usize) -> Vec<[u32; 6]> {
    let mut simulation = Simulation::with_threads(scene, threads).expect("a scene that runs");
    run(&mut simulation, steps);
    bits(simulation.world_mut())
}

/// Asserts that the entities are the same, and no position differs by more than `tolerance` \[m].
pub(crate) fn assert_near(
    found: &[(Entity, Vec3, Vec3)],
    expected: &[(Entity, Vec3, Vec3)],
    tolerance: f32,
) {
    assert_eq!(found.len(), expected.len());
    for ((entity, x, _), (expected_entity, expected_x, _)) in found.iter().zip(expected) {
        assert_eq!(entity, expected_entity);
        let distance = x.distance(*expected_x);
        assert!(
            distance <= tolerance,
            "{entity} is at {x}, {distance:e} m from {expected_x}"
        );
    }
}
