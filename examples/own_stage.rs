//! A stage of the host that an order file names: wind, between the engine's forces and pressure.
//!
//! `cargo run --release --example own_stage`
#![allow(clippy::print_stdout, reason = "an example talks to its reader")]

use bevy_ecs::prelude::*;
use overfall::{
    Phase, Simulation,
    scene::{BoundaryShape, FluidBody, Scene, Shape},
    step::{Accelerations, Product, Stage, Stages, Velocities},
};

/// Speed of the wind along x \[m/s].
#[derive(Resource)]
struct Wind(f32);

/// The stage, declared in one place: an order file may run it after the columns are gathered and before pressure.
const MY_WIND: Stage = Stage {
    needs: &[Product::Columns],
    makes: &[Product::Forces],
    // Removed with the scene.
    install: |world, _| world.insert_resource(Wind(5.0)),
    // The drag would oscillate if a step were longer \[s].
    limits: |_| vec![("my_wind", 0.5 / DRAG)],
    ..Stage::new("my_wind", Phase::Forces, |_| blow.into_configs())
};

/// Drag \[1/s].
const DRAG: f32 = 2.0;

fn blow(wind: Res<Wind>, velocities: Res<Velocities>, mut accelerations: ResMut<Accelerations>) {
    for (a, v) in accelerations.iter_mut().zip(velocities.iter()) {
        a.x += DRAG * (wind.0 - v.x);
    }
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let order = concat!(env!("CARGO_MANIFEST_DIR"), "/examples/own_stage.ron");
    let scene = Scene {
        bodies: vec![FluidBody::new(Shape::sphere([0.5, 1.0, 0.5], 0.3))],
        boundaries: vec![BoundaryShape::open_tank([0.0; 3], [3.0, 2.0, 1.0])],
        order: Some(order.to_owned()),
        ..Scene::new("windy", 0.1)
    };
    let mut stages = Stages::default();
    stages.register(MY_WIND)?;
    let mut world = World::new();
    world.insert_resource(stages);
    let mut simulation = Simulation::in_world(world, &scene)?;
    for _ in 0..4 {
        simulation.advance(0.05)?;
        let snapshot = simulation.snapshot()?;
        let x: f32 = (snapshot.particles().iter())
            .filter_map(|&drop| simulation.world().get::<overfall::particle::Position>(drop))
            .map(|x| x.0.x)
            .sum();
        let mean = x / snapshot.particles().len() as f32;
        println!(
            "t = {:.2} s: the drop is at x = {mean:.2} m",
            simulation.time()
        );
    }
    Ok(())
}
