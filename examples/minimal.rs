//! Water in a world of its own, in twenty lines.
//!
//! `cargo run --release --example minimal`
#![allow(clippy::print_stdout, reason = "an example talks to its reader")]

use bevy_ecs::prelude::*;
use overfall::{
    particle::{Fluid, Position},
    scene::{BoundaryShape, FluidBody, Scene, Shape},
};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let scene = Scene {
        bodies: vec![FluidBody::new(Shape::cuboid([0.0; 3], [0.5, 0.8, 0.4]))],
        boundaries: vec![BoundaryShape::tank([0.0; 3], [1.6, 1.2, 0.4])],
        ..Scene::new("pond", 0.1)
    };
    let mut world = World::new();
    overfall::install(&mut world, &scene)?;
    let done = overfall::advance(&mut world, 0.5)?;
    let mut fluid = world.query_filtered::<&Position, With<Fluid>>();
    let front = fluid.iter(&world).map(|x| x.0.x).fold(0.0, f32::max);
    println!("{} steps, the water is at x = {front:.2} m", done.steps);
    Ok(())
}
