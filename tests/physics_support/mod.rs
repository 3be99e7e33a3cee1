//! Shared by the physics tests: scenes from text, particles as plain values, sums over them.
#![allow(
    dead_code,
    reason = "every crate that has this module uses a part of it"
)]

use std::path::Path;

use bevy_ecs::prelude::*;
use glam::Vec3;
#[allow(
    unused_imports,
    reason = "every crate that has this module uses a part of it"
)]
pub(crate) use overfall::validate::{METHODS, Method, Particle, RigidMotion, rigid_motion};
use overfall::{
    Simulation, StepError, StepReport,
    scene::Scene,
    state::{
        FailureCause,
        particle::{Fluid, Position, Velocity},
    },
};

/// Reads a scene from the text of a file.
pub(crate) fn scene(text: &str) -> Scene {
    Scene::parse(text, "test.ron", &[]).unwrap_or_else(|error| panic!("{error}\n{text}"))
}

/// Sets up the scene of `text` on two threads.
pub(crate) fn simulation(text: &str) -> Simulation {
    Simulation::with_threads(&scene(text), 2).unwrap_or_else(|error| panic!("{error}\n{text}"))
}

/// Sets up the scene of `text` and replaces its bodies by particles with `(position, velocity)` \[m, m/s].
pub(crate) fn simulation_of(text: &str, particles: &[(Vec3, Vec3)]) -> Simulation {
    let mut simulation = simulation(text);
    for particle in particles_of(&mut simulation) {
        simulation.world_mut().despawn(particle.entity);
    }
    for &(position, velocity) in particles {
        simulation
            .world_mut()
            .spawn((Fluid, Position(position), Velocity(velocity)));
    }
    simulation
}

/// Takes a step that must not fail.
pub(crate) fn step(simulation: &mut Simulation) -> StepReport {
    simulation
        .step()
        .unwrap_or_else(|error| panic!("the step failed: {error}"))
}

/// Takes steps until `time` \[s]; `observe` gets the simulation and the report after every step.
pub(crate) fn run(
    simulation: &mut Simulation,
    time: f64,
    mut observe: impl FnMut(&mut Simulation, &StepReport),
) {
    while simulation.time() < time {
        let report = step(simulation);
        observe(simulation, &report);
    }
}

/// Replaces all particles by a single one and lets it fly for `steps` steps from a position with a velocity \[m, m/s].
/// `observe` gets its position and returns whether to continue. At almost h/2 per step, a wall that pushes back
/// slightly faster exceeds the limit: with `may_be_refused` that ends the flight.
pub(crate) fn shoot(
    jet: &mut Simulation,
    (start, velocity): (Vec3, Vec3),
    steps: usize,
    may_be_refused: bool,
    mut observe: impl FnMut(&mut Simulation, Vec3) -> bool,
) {
    for particle in particles_of(jet) {
        jet.world_mut().despawn(particle.entity);
    }
    jet.world_mut()
        .spawn((Fluid, Position(start), Velocity(velocity)));
    for _ in 0..steps {
        match jet.step() {
            Ok(_) => {}
            Err(StepError {
                cause: FailureCause::TooFast { .. },
                ..
            }) if may_be_refused => return,
            Err(error) => panic!("the step failed: {error}"),
        }
        let place = particles_of(jet)[0].position;
        if !observe(jet, place) {
            return;
        }
    }
}

/// Every fluid particle.
pub(crate) fn particles_of(simulation: &mut Simulation) -> Vec<Particle> {
    overfall::validate::particles_of(simulation.world_mut())
}

/// Sets the velocity \[m/s] of every particle from a field.
pub(crate) fn set_velocities(simulation: &mut Simulation, mut field: impl FnMut(Vec3) -> Vec3) {
    let world = simulation.world_mut();
    let mut query = world.query_filtered::<(&Position, &mut Velocity), With<Fluid>>();
    for (position, mut velocity) in query.iter_mut(world) {
        velocity.0 = field(position.0);
    }
}

/// Two columns of numbers of a file of `assets/reference`, by the names in its header.
pub(crate) fn reference(file: &str, names: [&str; 2]) -> Vec<[f64; 2]> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("assets/reference")
        .join(file);
    let text = std::fs::read_to_string(&path)
        .unwrap_or_else(|error| panic!("{}: {error}", path.display()));
    let mut rows = text.lines().filter(|line| !line.starts_with('#'));
    let header: Vec<&str> = rows.next().unwrap_or_default().split(',').collect();
    let place = names.map(|name| {
        let mut columns = header.iter();
        columns.position(|found| *found == name).expect("a column")
    });
    rows.map(|row| {
        let cells: Vec<&str> = row.split(',').collect();
        place.map(|place| cells[place].parse().expect("a number"))
    })
    .collect()
}

/// Prints a measurement; `cargo test -- --nocapture` shows it.
#[expect(
    clippy::print_stdout,
    reason = "measured figures are for whoever runs the tests with --nocapture"
)]
pub(crate) fn measured(what: &str) {
    println!("measured: {what}");
}
