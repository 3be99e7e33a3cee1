//! Steps that start from mean pressures: the values of the means, the iterations that they save, and their absence
//! elsewhere.

use std::collections::HashMap;

use bevy_ecs::prelude::*;
use glam::Vec3;
use overfall::{
    Simulation,
    scene::{Dfsph, Iisph, PressureMethod, Scene, TimeStep},
    state::MeanPressures,
    state::particle::{Fluid, MeanPressure, Position, Pressure},
};

use crate::common::{bits_after, dam, run, simulation};

/// A scene with means over `steps`.
fn from_means(steps: u32) -> Scene {
    let dfsph = Dfsph {
        warm_start: 1.0,
        warm_start_steps: steps,
        ..Dfsph::default()
    };
    Scene {
        pressure: PressureMethod::Dfsph(dfsph),
        time_step: TimeStep::Fixed(1e-3),
        reorder_interval: 3,
        ..dam()
    }
}

/// Pressure and mean, by entity.
fn pressures(simulation: &mut Simulation) -> HashMap<Entity, (f32, f32)> {
    let world = simulation.world_mut();
    let mut fluid = world.query_filtered::<(Entity, &Pressure, &MeanPressure), With<Fluid>>();
    let pressures = fluid.iter(world);
    pressures
        .map(|(entity, p, mean)| (entity, (p.0, mean.0)))
        .collect()
}

#[test]
fn a_mean_follows_its_particle_over_reorderings_and_takes_in_who_comes() {
    let mut simulation = simulation(&from_means(5));
    let mut before = pressures(&mut simulation);
    let mut jet = None;
    for step in 0..20 {
        if step == 7 {
            let world = simulation.world_mut();
            let gone = *before.keys().min().expect("a particle");
            world.despawn(gone);
            jet = Some(
                world
                    .spawn((Fluid, Position(Vec3::new(0.1, 0.22, 0.1))))
                    .id(),
            );
        }
        run(&mut simulation, 1);
        let after = pressures(&mut simulation);
        for (entity, &(p, mean)) in &after {
            let (_, old) = before.get(entity).copied().unwrap_or_default();
            assert_eq!(mean, old + 0.2 * (p - old), "{entity} in step {step}");
        }
        before = after;
    }
    let jet = jet.expect("it came");
    assert!(before[&jet].1 > 0.0, "it fell on the water");
}

#[test]
fn means_save_iterations_and_leave_no_more_error() {
    let block = |pressure: Dfsph| {
        let scene = r#"(
            name: "block",
            spacing: 0.02,
            bodies: [(shape: Box(min: (0, 0, 0), max: (0.4, 0.5, 0.3)))],
            boundaries: [Tank(min: (0, 0, 0), max: (0.8, 0.6, 0.3))],
            time_step: Fixed(0.001),
        )"#;
        let scene = Scene {
            pressure: PressureMethod::Dfsph(pressure),
            ..Scene::parse(scene, "block.ron", &[]).expect("a scene")
        };
        let mut simulation = simulation(&scene);
        run(&mut simulation, 60);
        let (mut iterations, mut error) = (0, 0.0);
        for _ in 0..100 {
            let report = simulation.step().expect("a good step");
            iterations += report.iterations;
            error += report.mean_density_error / 100.0;
        }
        (iterations, error)
    };
    let last = block(Dfsph::default());
    let means = block(Dfsph {
        warm_start: 1.0,
        warm_start_steps: 15,
        ..Dfsph::default()
    });
    assert!(
        4 * means.0 < 3 * last.0 && means.1 < 1.02 * last.1,
        "iterations and mean error {means:?}, from the last pressures {last:?}"
    );
}

#[test]
fn the_number_of_threads_changes_no_bit() {
    let scene = from_means(4);
    assert!(bits_after(&scene, 1, 15) == bits_after(&scene, 2, 15));
}

#[test]
fn nothing_of_it_is_in_a_world_that_does_not_ask_for_it() {
    for pressure in [
        PressureMethod::Dfsph(Dfsph::default()),
        PressureMethod::Iisph(Iisph::default()),
    ] {
        let mut simulation = simulation(&Scene { pressure, ..dam() });
        run(&mut simulation, 2);
        assert!(!simulation.world().contains_resource::<MeanPressures>());
        assert!(pressures(&mut simulation).is_empty());
    }
}
