//! A game loop with frames of 1/60 s, each with as many steps of the fluid as fit; wind between forces and pressure;
//! drops that are spawned and despawned; a level that restarts.
//!
//! `cargo run --release --example game_loop`
#![allow(clippy::print_stdout, reason = "an example talks to its reader")]

use bevy_ecs::prelude::*;
use overfall::{
    Phase, Step,
    particle::{Fluid, Position, Velocity},
    scene::{BoundaryShape, FluidBody, Scene, Shape},
    step::{Accelerations, Velocities},
};

/// State of the host: speed of the wind along x \[m/s].
#[derive(Resource)]
struct Wind(f32);

/// Adds to the accelerations, by row.
fn blow(wind: Res<Wind>, velocities: Res<Velocities>, mut accelerations: ResMut<Accelerations>) {
    for (a, v) in accelerations.iter_mut().zip(velocities.iter()) {
        a.x += 2.0 * (wind.0 - v.x);
    }
}

fn start_level(world: &mut World, scene: &Scene) -> Result<(), Box<dyn std::error::Error>> {
    overfall::install(world, scene)?;
    // The host's systems are removed with the level, so they are added with it again.
    world.schedule_scope(Step, |_, step| {
        step.add_systems(blow.after(Phase::Forces).before(Phase::Pressure));
    });
    Ok(())
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let scene = Scene {
        bodies: vec![FluidBody::new(Shape::cuboid([0.0; 3], [1.0, 0.3, 0.4]))],
        boundaries: vec![BoundaryShape::open_tank([0.0; 3], [1.0, 1.0, 0.4])],
        ..Scene::new("level", 0.1)
    };
    let mut world = World::new();
    world.insert_resource(Wind(3.0));
    for level in 0..2 {
        start_level(&mut world, &scene)?;
        for frame in 0..20 {
            // A slow frame requests no more than the game can wait for.
            let frame_time: f64 = 1.0 / 60.0;
            let done = overfall::advance(&mut world, frame_time.min(0.05))?;
            if frame % 10 == 0 {
                let at = Position([0.5, 0.8, 0.2].into());
                world.spawn((Fluid, at, Velocity([0.0, -1.0, 0.0].into())));
            }
            if let Some(report) = done.report.filter(|_| frame % 5 == 0) {
                let (steps, fluid) = (done.steps, report.particles);
                println!("level {level}, frame {frame}: {steps} steps, {fluid} particles");
            }
        }
        overfall::uninstall(&mut world)?;
    }
    Ok(())
}
