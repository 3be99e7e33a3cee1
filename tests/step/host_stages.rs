//! Stages and systems that a host adds to the step.

use super::orders::{STAGES, ordered, unordered};
use crate::common::{bits, dam, run, simulation};
use bevy_ecs::prelude::*;
use overfall::{
    Phase, Simulation, Step, install,
    particle::{Fluid, Position, Pressure, Velocity},
    step::{
        Accelerations, FailureCause, InstallError, Product, Stage, StageError, Stages, Velocities,
    },
    uninstall,
};

#[derive(Resource, Default)]
struct Blown(u32);

fn blow(velocities: Res<Velocities>, mut a: ResMut<Accelerations>, mut blown: ResMut<Blown>) {
    // Gravity was added before, and pressure comes after; viscosity does not change the sum.
    let mean = a.iter().map(|a| a.y).sum::<f32>() / a.len() as f32;
    assert!((mean + 9.81).abs() < 0.1, "{mean}");
    a.iter_mut()
        .zip(velocities.iter())
        .for_each(|(a, v)| a.x += 50.0 - v.x);
    blown.0 += 1;
}

const MY_WIND: Stage = Stage {
    needs: &[Product::Columns],
    makes: &[Product::Forces],
    install: |world, _| _ = world.init_resource::<Blown>(),
    ..Stage::new("my_wind", Phase::Forces, |_| blow.into_configs())
};

fn with_wind(stages: &str) -> Result<Simulation, InstallError> {
    let (scene, _folder) = ordered(stages);
    let mut world = World::new();
    let mut known = Stages::default();
    known.register(MY_WIND).expect("a new name");
    world.insert_resource(known);
    Simulation::in_world(world, &scene)
}

#[test]
fn a_stage_of_the_hosts_runs_where_the_order_names_it() {
    let between = STAGES.replace(r#"Run("pressure")"#, r#"Run("my_wind"), Run("pressure")"#);
    let mut windy = with_wind(&format!("(stages: [{between}])")).expect("an order");
    run(&mut windy, 10);
    assert_eq!(windy.world().resource::<Blown>().0, 10);
    let mut calm = simulation(&unordered());
    run(&mut calm, 10);
    let mean = |simulation: &mut Simulation| {
        let world = simulation.world_mut();
        let mut fluid = world.query_filtered::<&Velocity, With<Fluid>>();
        fluid.iter(world).map(|v| v.0.x).sum::<f32>() / 1200.0
    };
    assert!(mean(&mut windy) > mean(&mut calm) + 0.05);
    // The stages belong to the host and remain; the resource that one of them inserted is removed with the scene.
    uninstall(windy.world_mut()).expect("a scene");
    assert!(windy.world().contains_resource::<Stages>());
    assert!(!windy.world().contains_resource::<Blown>());

    let every_other = STAGES.replace(
        r#"Run("pressure")"#,
        r#"Every(2, [Run("my_wind")]), Run("pressure")"#,
    );
    let left_out = format!(r#"(stages: [{STAGES}], leave_out: ["my_wind"])"#);
    // A force in every second step; the other steps have none of it.
    let mut gusts = with_wind(&format!("(stages: [{every_other}])")).expect("an order");
    run(&mut gusts, 10);
    assert_eq!(gusts.world().resource::<Blown>().0, 5);
    let mut without = with_wind(&left_out).expect("an order");
    run(&mut without, 10);
    assert!(bits(without.world_mut()) == bits(calm.world_mut()));
    for (order, says) in [
        // Not named; too early; misspelt.
        (format!("(stages: [{STAGES}])"), "my_wind"),
        (
            format!(r#"(stages: [Run("my_wind"), {STAGES}])"#),
            "my_wind",
        ),
        (between.replace("my_wind", "my_wnd"), "my_wnd"),
    ] {
        let order = if order.starts_with('(') {
            order
        } else {
            format!("(stages: [{order}])")
        };
        let error = with_wind(&order).err().map(|error| error.to_string());
        assert!(
            error.as_ref().is_some_and(|error| error.contains(says)),
            "{order}: {error:?}"
        );
    }
}

#[test]
fn a_stage_needs_a_name_of_its_own() {
    let mut stages = Stages::default();
    stages.register(MY_WIND).expect("a new name");
    let taken = |name| Err(StageError::NameIsTaken { name });
    assert_eq!(stages.register(MY_WIND), taken("my_wind"));
    let named = |name| Stage { name, ..MY_WIND };
    assert_eq!(stages.register(named("pressure")), taken("pressure"));
    for name in ["", "my wind", "a-b", "a\n"] {
        assert_eq!(
            stages.register(named(name)),
            Err(StageError::NoName { name })
        );
    }
}

fn push(mut fluid: Query<&mut Velocity, With<Fluid>>) {
    if let Some(mut v) = fluid.iter_mut().next() {
        v.0.x += 0.01;
    }
}

fn lift(mut fluid: Query<&mut Position, With<Fluid>>) {
    if let Some(mut x) = fluid.iter_mut().next() {
        x.0.y += 1e-4;
    }
}

fn heat(mut fluid: Query<&mut Pressure, With<Fluid>>) {
    if let Some(mut p) = fluid.iter_mut().next() {
        p.0 += 1.0;
    }
}

#[test]
fn what_a_step_would_overwrite_is_refused_by_name() {
    type Add = fn(&mut Schedule, Phase, Phase);
    let writers: [(&str, Add); 3] = [
        ("Velocity", |step, after, before| {
            _ = step.add_systems(push.after(after).before(before))
        }),
        ("Position", |step, after, before| {
            _ = step.add_systems(lift.after(after).before(before))
        }),
        ("Pressure", |step, after, before| {
            _ = step.add_systems(heat.after(after).before(before))
        }),
    ];
    for phases in Phase::ALL.windows(2) {
        for (name, add) in writers {
            let mut simulation = simulation(&dam());
            run(&mut simulation, 1);
            let world = simulation.world_mut();
            world.schedule_scope(Step, |_, step| add(step, phases[0], phases[1]));
            let before = simulation.time();
            let is_safe = phases[0] >= Phase::Integrate;
            for _ in 0..2 {
                match simulation.step() {
                    Ok(_) => assert!(is_safe, "{name} after {phases:?}"),
                    Err(error) => {
                        assert!(!is_safe, "{phases:?}: {error}");
                        assert!(
                            matches!(error.cause, FailureCause::Overwritten { component } if component == name),
                            "{error}"
                        );
                        assert!(error.particle.is_some() && simulation.time() == before);
                    }
                }
            }
        }
    }
    // Before the first phase, a write is part of the state that the step starts from.
    let mut simulation = simulation(&dam());
    simulation.world_mut().schedule_scope(Step, |_, step| {
        step.add_systems((push, lift, heat).chain().before(Phase::RebuildIndex));
    });
    run(&mut simulation, 3);
}

#[test]
fn systems_that_conflict_are_an_error_that_names_them() {
    let mut simulation = simulation(&dam());
    run(&mut simulation, 1);
    simulation.world_mut().schedule_scope(Step, |_, step| {
        step.add_systems(push);
    });
    for _ in 0..2 {
        let error = simulation.step().expect_err("a conflict").to_string();
        assert!(
            error.contains("push") && error.contains("Velocity"),
            "{error}"
        );
    }
    // The scene can be uninstalled, and runs in another world.
    uninstall(simulation.world_mut()).expect("a scene");
    install(simulation.world_mut(), &dam()).expect("a scene");
    run(&mut simulation, 2);
}
