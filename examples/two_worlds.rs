//! Two scenes side by side on the host's threads: the same fluid with low and high viscosity.
//!
//! `cargo run --release --example two_worlds`
#![allow(clippy::print_stdout, reason = "an example talks to its reader")]

use std::sync::Arc;

use bevy_ecs::prelude::*;
use overfall::{
    Execution, Simulation,
    scene::{self, BoundaryShape, FluidBody, Scene, Shape, Viscosity},
};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    // The thread pool in which the host's own loops run.
    let pool = Arc::new(rayon::ThreadPoolBuilder::new().num_threads(2).build()?);
    let water = Scene {
        bodies: vec![FluidBody::new(Shape::cuboid([0.0; 3], [0.5, 0.8, 0.4]))],
        boundaries: vec![BoundaryShape::tank([0.0; 3], [1.6, 1.2, 0.4])],
        ..Scene::new("water", 0.1)
    };
    let syrup = Scene {
        name: "syrup".to_owned(),
        fluid: scene::Fluid {
            viscosity: Viscosity::Laminar {
                kinematic_viscosity: 0.05,
                numerical: Some(0.0),
            },
            ..water.fluid.clone()
        },
        ..water.clone()
    };
    let start = |scene: &Scene| {
        let mut world = World::new();
        world.insert_resource(Execution::with_pool(pool.clone()));
        Simulation::in_world(world, scene)
    };
    let mut worlds = [start(&water)?, start(&syrup)?];
    for frame in 0..5 {
        for (simulation, scene) in worlds.iter_mut().zip([&water, &syrup]) {
            let done = simulation.advance(0.05)?;
            let speed = done.report.map_or(0.0, |report| report.max_speed);
            println!("frame {frame}: {} at up to {speed:.2} m/s", scene.name);
        }
    }
    Ok(())
}
