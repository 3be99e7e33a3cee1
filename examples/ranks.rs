//! One fluid in several worlds of one process, each in a thread: what a host with MPI does with a process per rank and
//! a [`Communicator`](overfall::communicator::Communicator) of its own.
//!
//! `cargo run --release --example ranks`
#![allow(clippy::print_stdout, reason = "an example talks to its reader")]

use std::{error::Error, sync::Arc, thread};

use bevy_ecs::prelude::*;
use overfall::{
    Execution,
    communicator::{Communicator, Local},
    install_on_rank,
    particle::{Fluid, Position},
    scene::{BoundaryShape, FluidBody, Scene, Shape},
    take_step,
};

type Failure = Box<dyn Error + Send + Sync>;

/// What a rank does: the same on every rank.
fn run(scene: &Scene, rank: Local) -> Result<String, Failure> {
    let name = format!("rank {} of {}", rank.rank(), rank.ranks());
    let mut world = World::new();
    // Loops of a rank run in a pool of its own, because a step waits for the other ranks.
    world.insert_resource(Execution::new(1)?);
    install_on_rank(&mut world, scene, Arc::new(rank))?;
    let mut last = take_step(&mut world)?;
    for _ in 0..50 {
        world.clear_trackers();
        last = take_step(&mut world)?;
    }
    let mut fluid = world.query_filtered::<&Position, With<Fluid>>();
    let own = fluid.iter(&world).count();
    let front = fluid.iter(&world).map(|x| x.0.x).fold(0.0, f32::max);
    Ok(format!(
        "{name}: {own} of {} particles, up to x = {front:.3} m; the fastest of all has {:.3} m/s at {:.4} s",
        last.particles, last.max_speed, last.time
    ))
}

fn main() -> Result<(), Failure> {
    let scene = Scene {
        bodies: vec![FluidBody::new(Shape::cuboid([0.0; 3], [0.5, 1.0, 0.5]))],
        boundaries: vec![BoundaryShape::tank([0.0; 3], [1.5, 1.5, 0.5])],
        reorder_interval: 20,
        ..Scene::new("dam", 0.04)
    };
    thread::scope(|scope| {
        let ranks: Vec<_> = (Local::team(2).into_iter())
            .map(|rank| scope.spawn(|| run(&scene, rank)))
            .collect();
        for rank in ranks {
            let told = rank.join().map_err(|_| "a rank panicked")?;
            println!("{}", told?);
        }
        Ok(())
    })
}
