//! Water in a host's own world: a host system runs between the engine's phases, some particles have a host component,
//! and particles are spawned and despawned between steps.
//!
//! `cargo run --release --example embed`
#![allow(clippy::print_stdout, reason = "an example talks to its reader")]

use bevy_ecs::prelude::*;
use overfall::{
    Phase, Step,
    scene::Scene,
    state::particle::{Fluid, Position, Velocity},
};

/// A component of the host.
#[derive(Component)]
struct Dye;

/// State of the host.
#[derive(Resource, Default)]
struct DyeFront(f32);

fn watch_the_dye(mut front: ResMut<DyeFront>, dyed: Query<&Position, With<Dye>>) {
    front.0 = dyed.iter().map(|x| x.0.x).fold(f32::NEG_INFINITY, f32::max);
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let scene = r#"(
        name: "pond",
        spacing: 0.05,
        bodies: [(shape: Box(min: (0, 0, 0), max: (0.5, 1, 0.5)))],
        boundaries: [Tank(min: (0, 0, 0), max: (2, 1.5, 0.5), open: true)],
    )"#;
    let mut world = World::new();
    overfall::install(&mut world, &Scene::parse(scene, "pond", &[])?)?;

    // The host's system runs within the step, after the particles have moved.
    world.init_resource::<DyeFront>();
    world.schedule_scope(Step, |_, step| {
        step.add_systems(watch_the_dye.after(Phase::Integrate).before(Phase::Reorder));
    });

    // Some particles are tagged, which moves them to another table. The engine handles that.
    let mut fluid = world.query_filtered::<(Entity, &Position), With<Fluid>>();
    let low: Vec<Entity> = fluid
        .iter(&world)
        .filter(|(_, x)| x.0.y < 0.2)
        .map(|(e, _)| e)
        .collect();
    world.insert_batch(low.into_iter().map(|entity| (entity, Dye)));

    for step in 0..200 {
        let report = overfall::take_step(&mut world)?;
        if step % 50 == 0 {
            let front = world.resource::<DyeFront>().0;
            println!(
                "t = {:.3} s: {} particles, dye up to x = {front:.3} m",
                report.time, report.particles
            );
            // A jet from above, one particle at a time.
            world.spawn((
                Fluid,
                Position([1.5, 1.2, 0.25].into()),
                Velocity([0.0, -1.0, 0.0].into()),
            ));
        }
    }
    Ok(())
}
