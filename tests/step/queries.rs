//! Queries of a host: neighbours, interpolated quantities, rows of particles.

use crate::common::{dam, run, simulation};
use bevy_ecs::prelude::*;
use glam::Vec3;
use overfall::{
    gauge::{Gauges, SnapshotError},
    particle::{Density, Fluid, Position, Pressure, Velocity},
    scene::{Dimension, FluidBody, Gauge, GaugeKind, Scene, Shape},
};

/// Particles within h of a point, found by testing each.
fn near(world: &mut World, point: Vec3, h: f32) -> Vec<Entity> {
    let mut fluid = world.query_filtered::<(Entity, &Position), With<Fluid>>();
    let found = fluid.iter(world).filter(|(_, x)| x.0.distance(point) < h);
    let mut found: Vec<Entity> = found.map(|found| found.0).collect();
    found.sort_unstable();
    found
}

#[test]
fn neighbours_are_those_that_looking_at_each_particle_finds() {
    let flat = Scene {
        dimension: Dimension::Two,
        bodies: vec![FluidBody::new(Shape::cuboid([0.0; 3], [0.5, 0.4, 0.0]))],
        ..Scene::new("flat", 0.02)
    };
    for scene in [dam(), flat] {
        let mut simulation = simulation(&scene);
        let h = scene.support_radius();
        // Before the first step, after it, and after changes by a host.
        for moment in 0..3 {
            match moment {
                1 => run(&mut simulation, 25),
                2 => {
                    let far = Position(Vec3::new(900.0, 0.1, 0.0));
                    simulation.world_mut().spawn((Fluid, far));
                }
                _ => {}
            }
            let snapshot = simulation.snapshot().expect("a scene");
            let particles = snapshot.particles().to_vec();
            for k in 0..20 {
                let particle = particles[k * (particles.len() - 1) / 19];
                let at = simulation
                    .world()
                    .get::<Position>(particle)
                    .expect("a particle")
                    .0;
                let point = at + 0.3 * h * Vec3::new(1.0, -1.0, 0.0);
                let of_point = simulation.neighbours_of(point).expect("a scene");
                assert!(of_point.is_sorted_by(|a, b| a.distance <= b.distance));
                let mut found: Vec<Entity> = of_point.iter().map(|n| n.particle).collect();
                found.sort_unstable();
                assert_eq!(found, near(simulation.world_mut(), point, h));
                let of_particle = simulation.neighbours_of(particle).expect("a scene");
                let mut found: Vec<Entity> = of_particle.iter().map(|n| n.particle).collect();
                found.push(particle);
                found.sort_unstable();
                assert_eq!(found, near(simulation.world_mut(), at, h));
            }
        }
        let nobody = simulation.world_mut().spawn_empty().id();
        let error = simulation.neighbours_of(nobody).expect_err("no place");
        assert_eq!(error, SnapshotError::NoPlace { entity: nobody });
    }
}

#[test]
fn a_constant_is_interpolated_exactly_and_a_linear_field_within_the_fluid() {
    let mut simulation = simulation(&Scene {
        bodies: vec![FluidBody::new(Shape::cuboid([0.0; 3], [0.4; 3]))],
        ..Scene::new("cube", 0.02)
    });
    let world = simulation.world_mut();
    let mut fluid = world.query::<(&Position, &mut Pressure, &mut Density, &mut Velocity)>();
    for (x, mut p, mut rho, mut v) in fluid.iter_mut(world) {
        p.0 = 9810.0 * (0.4 - x.0.y);
        rho.0 = 998.0;
        v.0 = Vec3::new(1.0, 2.0 * x.0.x, 0.0);
    }
    let inside: Vec<Vec3> = (0..20)
        .map(|k| Vec3::splat(0.1 + 0.01 * k as f32))
        .collect();
    let pressures = simulation
        .interpolate::<Pressure>(&inside)
        .expect("a scene");
    let velocities = simulation
        .interpolate::<Velocity>(&inside)
        .expect("a scene");
    for ((at, p), v) in inside.iter().zip(pressures).zip(velocities) {
        assert!(p.neighbours > 20 && p.neighbours == v.neighbours);
        // A lattice is not symmetric about a point between its nodes.
        let (p, v) = (p.value.expect("fluid").0, v.value.expect("fluid").0);
        assert!(
            (p - 9810.0 * (0.4 - at.y)).abs() < 9810.0 * 0.001,
            "{at}: {p}"
        );
        assert!(
            (v - Vec3::new(1.0, 2.0 * at.x, 0.0)).length() < 0.002,
            "{at}: {v}"
        );
    }
    // Near a surface, at it, and outside.
    for x in [0.005, 0.0, -0.02, -0.03, -0.05, 1e6, f32::NAN] {
        let found = simulation.interpolate::<Density>(&[Vec3::new(x, 0.2, 0.2)]);
        let found = found.expect("a scene")[0];
        // Particles 0.01 m and more inside are near a point off the fluid, too.
        let is_in_fluid = (-0.015..0.4).contains(&x);
        assert_eq!(found.value.is_some(), is_in_fluid, "{x}");
        let is_near = (-0.03 + f32::EPSILON..0.4).contains(&x);
        assert_eq!(found.neighbours > 0, is_near, "{x}: {}", found.neighbours);
        assert!(found.value.is_none_or(|rho| (rho.0 - 998.0).abs() < 1e-3));
    }
}

#[test]
fn a_gauge_at_the_same_place_shows_the_same() {
    let at = Vec3::new(0.1, 0.1, 0.1);
    let scene = Scene {
        gauges: vec![Gauge::new("p", GaugeKind::Pressure { at, radius: None })],
        reorder_interval: 0,
        ..dam()
    };
    let mut simulation = simulation(&scene);
    run(&mut simulation, 10);
    let found = simulation.interpolate::<Pressure>(&[at]).expect("a scene")[0];
    let gauges = simulation.world().resource::<Gauges>();
    let gauge = gauges.get("p").expect("a gauge");
    let pressure = gauge.value("pressure_Pa").expect("fluid");
    assert!((f64::from(found.value.expect("fluid").0) / pressure - 1.0).abs() < 1e-5);
    assert_eq!(gauge.value("neighbours"), Some(found.neighbours.into()));
}

#[test]
fn rows_and_particles_name_each_other() {
    let mut simulation = simulation(&dam());
    let particles = simulation.snapshot().expect("a scene").particles().to_vec();
    assert_eq!(simulation.row_of(particles[0]), None);
    run(&mut simulation, 3);
    for &particle in particles.iter().step_by(97) {
        let row = simulation.row_of(particle).expect("a row");
        assert_eq!(simulation.entity_of(row), Some(particle));
    }
    assert_eq!(simulation.entity_of(particles.len()), None);
    assert_eq!(simulation.row_of(Entity::PLACEHOLDER), None);
}
