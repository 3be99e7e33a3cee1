//! What the physics tests share: scenes from text, particles as plain values, sums over them.
#![allow(
    dead_code,
    reason = "every crate that has this module uses a part of it"
)]

use std::path::Path;

use bevy_ecs::prelude::*;
use glam::{DVec3, Vec3};
use overfall::{
    Simulation, StepError, StepReport,
    scene::Scene,
    state::{
        FailureCause,
        particle::{Density, Fluid, Position, Pressure, Velocity},
    },
};

/// A fluid particle after a step. Position and velocity are those at its end, density and pressure those that it
/// computed at its start.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Particle {
    pub(crate) entity: Entity,
    pub(crate) position: Vec3,
    pub(crate) velocity: Vec3,
    pub(crate) density: f32,
    pub(crate) pressure: f32,
}

/// Reads a scene from the text of a file.
pub(crate) fn scene(text: &str) -> Scene {
    Scene::parse(text, "test.ron", &[]).unwrap_or_else(|error| panic!("{error}\n{text}"))
}

/// Sets the scene of `text` up, on two threads.
pub(crate) fn simulation(text: &str) -> Simulation {
    Simulation::with_threads(&scene(text), 2).unwrap_or_else(|error| panic!("{error}\n{text}"))
}

/// Sets the scene of `text` up and puts `(position, velocity)` \[m, m/s] in the place of its bodies.
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

/// Steps until `time` \[s]; `observe` sees the simulation and the report after every step.
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

/// Lets a lone particle, in the place of those there are, fly for so many steps from a place with a velocity \[m, m/s].
/// `observe` sees where it is and says whether to go on. At nearly h/2 a step a wall that pushes back a little faster
/// breaks the limit: with `may_be_refused` that is the end.
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
    let world = simulation.world_mut();
    let mut query =
        world.query_filtered::<(Entity, &Position, &Velocity, &Density, &Pressure), With<Fluid>>();
    query
        .iter(world)
        .map(|(entity, position, velocity, density, pressure)| Particle {
            entity,
            position: position.0,
            velocity: velocity.0,
            density: density.0,
            pressure: pressure.0,
        })
        .collect()
}

/// Gives every particle the velocity \[m/s] of a field.
pub(crate) fn set_velocities(simulation: &mut Simulation, mut field: impl FnMut(Vec3) -> Vec3) {
    let world = simulation.world_mut();
    let mut query = world.query_filtered::<(&Position, &mut Velocity), With<Fluid>>();
    for (position, mut velocity) in query.iter_mut(world) {
        velocity.0 = field(position.0);
    }
}

/// Centre, velocity, and angular momentum about the centre of the particles, for a mass of 1 in all.
#[derive(Debug, Clone, Copy)]
pub(crate) struct RigidMotion {
    pub(crate) center: DVec3,
    pub(crate) velocity: DVec3,
    pub(crate) angular_momentum: DVec3,
}

/// The rigid part of the motion; sums in f64.
pub(crate) fn rigid_motion(particles: &[Particle]) -> RigidMotion {
    let mean = |value: &dyn Fn(&Particle) -> DVec3| -> DVec3 {
        particles.iter().map(value).sum::<DVec3>() / particles.len() as f64
    };
    let center = mean(&|particle| particle.position.as_dvec3());
    let velocity = mean(&|particle| particle.velocity.as_dvec3());
    let angular_momentum = mean(&|particle| {
        let arm = particle.position.as_dvec3() - center;
        arm.cross(particle.velocity.as_dvec3() - velocity)
    });
    RigidMotion {
        center,
        velocity,
        angular_momentum,
    }
}

/// A pressure method.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Method {
    pub(crate) name: &'static str,
    /// The method in a scene. SESPH needs a speed of sound \[m/s]: ten times the largest speed expected allows 1 % of
    /// compression.
    pub(crate) pressure: fn(sound_speed: f32) -> String,
}

/// Every pressure method, with the parameters that it comes with.
pub(crate) const METHODS: [Method; 5] = [
    Method {
        name: "SESPH, gas",
        pressure: |c| format!("Sesph(equation: Gas(stiffness: {}))", c * c),
    },
    Method {
        name: "SESPH, Tait",
        pressure: |c| format!("Sesph(equation: Tait(stiffness: {}))", 1000.0 * c * c / 7.0),
    },
    Method {
        name: "PCISPH",
        pressure: |_| "Pcisph()".to_owned(),
    },
    Method {
        name: "IISPH",
        pressure: |_| "Iisph()".to_owned(),
    },
    Method {
        name: "DFSPH",
        pressure: |_| "Dfsph()".to_owned(),
    },
];

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

/// Prints what a test measured; `cargo test -- --nocapture` shows it.
#[expect(
    clippy::print_stdout,
    reason = "measured figures are for whoever runs the tests with --nocapture"
)]
pub(crate) fn measured(what: &str) {
    println!("measured: {what}");
}
