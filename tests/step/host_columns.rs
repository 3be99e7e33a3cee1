//! Accelerations and components that a host spoils: the step names them, and the particle.

use bevy_ecs::prelude::*;
use overfall::{
    Phase, Step,
    particle::Velocity,
    scene::{Executor, Scene},
    step::{Accelerations, FailureCause, Rows},
};

use super::host::{Tag, culprit};
use crate::common::{bits, dam, methods, run, simulation, state};

#[test]
fn accelerations_that_a_host_spoilt_are_named() {
    for executor in [Executor::SingleThreaded, Executor::Parallel] {
        for pressure in methods() {
            spoils_accelerations(&Scene {
                executor,
                pressure,
                ..dam()
            });
        }
    }
}

fn spoils_accelerations(scene: &Scene) {
    type Add = fn(&mut Schedule);
    let add: [(&str, Add); 2] = [
        ("inf", |step| {
            let spoil = |mut a: ResMut<Accelerations>| a[77].y = f32::INFINITY;
            step.add_systems(spoil.after(Phase::Forces).before(Phase::Pressure));
        }),
        ("1e38", |step| {
            let spoil = |mut a: ResMut<Accelerations>| a[77].y = 1e38;
            step.add_systems(spoil.after(Phase::Forces).before(Phase::Pressure));
        }),
    ];
    for (name, add) in add {
        let mut simulation = simulation(scene);
        run(&mut simulation, 1);
        let before = bits(simulation.world_mut());
        simulation
            .world_mut()
            .schedule_scope(Step, |_, step| add(step));
        let error = simulation.step().expect_err("a column that is none");
        let quantity = "acceleration";
        assert_eq!(error.cause, FailureCause::NotFinite { quantity }, "{name}");
        let row = simulation.world().resource::<Rows>().entity_of(77);
        assert_eq!(error.particle.map(|particle| particle.0), row, "{name}");
        assert!(bits(simulation.world_mut()) == before, "{name}");
    }
}

#[test]
fn all_particles_that_lack_a_component_are_counted() {
    let mut simulation = simulation(&dam());
    run(&mut simulation, 1);
    let all: Vec<Entity> = state(simulation.world_mut()).iter().map(|p| p.0).collect();
    let victim = culprit(&mut simulation);
    let world = simulation.world_mut();
    for &particle in &all[..3] {
        world.entity_mut(particle).remove::<Velocity>();
    }
    world.entity_mut(victim).insert(Tag).remove::<Velocity>();
    let error = simulation.step().expect_err("no velocity");
    let counted = matches!(
        error.cause,
        FailureCause::LacksComponent { particles: 4, .. }
    );
    assert!(counted, "{error}");
}

/// Methods that start from mean pressures name them.
#[test]
fn a_mean_pressure_is_not_called_a_pressure() {
    use overfall::particle::MeanPressure;
    for pressure in methods() {
        let mut simulation = simulation(&Scene { pressure, ..dam() });
        run(&mut simulation, 1);
        let victim = culprit(&mut simulation);
        let world = simulation.world_mut();
        let Some(mut mean) = world.get_mut::<MeanPressure>(victim) else {
            continue;
        };
        mean.0 = f32::NAN;
        let error = simulation.step().expect_err("no pressure");
        assert!(
            error.to_string().contains("mean pressure is not finite"),
            "{error}"
        );
        assert_eq!(error.particle.map(|particle| particle.0), Some(victim));
    }
}
