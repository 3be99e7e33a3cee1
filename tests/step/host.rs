//! Misuse by a host: every step is refused with the reason and the right particle, nothing is lost, and the next step
//! can be taken.

use std::collections::HashMap;

use bevy_ecs::prelude::*;
use glam::Vec3;
use overfall::{
    Simulation,
    boundary::{BoundaryError, refresh_boundary},
    install,
    output::Frame,
    scene::{BoundaryShape, IndexStructure, Scene, TimeStep},
    state::{
        Clock, Execution, FailureCause, StepError,
        particle::{
            Boundary, BoundaryNormal, BoundaryVolume, Density, Fluid, ParticleId, Position,
            Pressure, Velocity,
        },
    },
    take_step,
};

use crate::common::{self, DAM_PARTICLES, bits, dam, methods, run, sesph, simulation, state};

/// A component of the host.
#[derive(Component)]
pub(super) struct Tag;

/// A particle inside the fluid.
pub(super) fn culprit(simulation: &mut Simulation) -> Entity {
    state(simulation.world_mut())[DAM_PARTICLES / 2 + 55].0
}

/// Takes a step that must fail and must not change anything.
fn refused(simulation: &mut Simulation) -> StepError {
    let before = bits(simulation.world_mut());
    let clock = *simulation.world().resource::<Clock>();
    let error = simulation.step().expect_err("a step that goes wrong");
    assert!(bits(simulation.world_mut()) == before);
    let after = *simulation.world().resource::<Clock>();
    assert_eq!((after.step, after.time), (clock.step, clock.time));
    error
}

#[test]
fn a_particle_that_lacks_a_component_is_named_with_it() {
    type Change = fn(&mut EntityWorldMut);
    fn changes<C: Component + Default>(name: &'static str) -> (&'static str, Change, Change) {
        (
            name,
            |particle| _ = particle.remove::<C>(),
            |particle| _ = particle.insert(C::default()),
        )
    }
    let changes = [
        changes::<Position>("Position"),
        changes::<Velocity>("Velocity"),
        changes::<Density>("Density"),
        changes::<Pressure>("Pressure"),
        changes::<ParticleId>("ParticleId"),
    ];
    for (name, remove, insert) in changes {
        for many in [1, 7] {
            let mut simulation = simulation(&dam());
            run(&mut simulation, 1);
            let all: Vec<Entity> = state(simulation.world_mut()).iter().map(|p| p.0).collect();
            let victims = &all[500..500 + many];
            for &victim in victims {
                remove(&mut simulation.world_mut().entity_mut(victim));
            }
            let error = refused(&mut simulation);
            match error.cause {
                FailureCause::LacksComponent {
                    component,
                    particles,
                } => assert_eq!((component, particles), (name, many)),
                other => panic!("{other}"),
            }
            assert!(victims.contains(&error.particle.expect("one of them").0));
            assert!(error.to_string().contains(&format!("`{name}`")), "{error}");
            for &victim in victims {
                insert(&mut simulation.world_mut().entity_mut(victim));
            }
            if name != "Position" {
                run(&mut simulation, 2);
            }
        }
    }
}

#[test]
fn the_particle_that_a_host_spoilt_is_named_and_not_its_neighbour() {
    for pressure in methods() {
        for value in [f32::NAN, f32::INFINITY, 1e18, 1e30] {
            let mut simulation = simulation(&Scene { pressure, ..dam() });
            run(&mut simulation, 2);
            let entity = culprit(&mut simulation);
            let refused_and_named = |simulation: &mut Simulation| {
                let error = refused(simulation);
                let named = error.particle.map(|particle| particle.0);
                assert_eq!(named, Some(entity), "{value}: {error}");
            };
            let world = simulation.world_mut();
            let (x, v) = (
                *world.get::<Position>(entity).expect("a particle"),
                *world.get::<Velocity>(entity).expect("a particle"),
            );
            world
                .entity_mut(entity)
                .insert(Velocity(Vec3::new(0.0, -value, 0.0)));
            refused_and_named(&mut simulation);
            let mut particle = simulation.world_mut().entity_mut(entity);
            particle
                .insert(v)
                .insert(Position(Vec3::new(value, 0.1, 0.1)));
            refused_and_named(&mut simulation);
            let mut particle = simulation.world_mut().entity_mut(entity);
            particle.insert(x);
            particle.insert(Pressure(value));
            refused_and_named(&mut simulation);
            let mut particle = simulation.world_mut().entity_mut(entity);
            particle.insert(Pressure(0.0));
            run(&mut simulation, 2);
        }
    }
}

#[test]
fn a_particle_far_away_panics_nowhere() {
    for structure in IndexStructure::ALL {
        for place in [3e4_f32, 1e7, 1e12, 9e16] {
            let mut scene = Scene {
                pressure: sesph(),
                reorder_interval: 1,
                ..dam()
            };
            scene.index.structure = structure;
            let mut simulation = simulation(&scene);
            let entity = culprit(&mut simulation);
            let far = Position(Vec3::new(place, -place, 0.1));
            simulation.world_mut().entity_mut(entity).insert(far);
            for _ in 0..2 {
                if let Err(error) = simulation.step() {
                    let named = error.particle.map(|particle| particle.0);
                    assert_eq!(named, Some(entity), "{structure:?}, {place}: {error}");
                }
            }
        }
    }
}

#[test]
fn a_time_step_that_is_none_is_refused() {
    for pressure in methods() {
        let mut simulation = simulation(&Scene { pressure, ..dam() });
        run(&mut simulation, 1);
        let good = simulation.world().resource::<Clock>().next_dt;
        for dt in [f32::INFINITY, f32::NAN, 0.0, -1e-3, f32::NEG_INFINITY] {
            simulation.world_mut().resource_mut::<Clock>().next_dt = dt;
            let error = refused(&mut simulation);
            assert!(
                matches!(error.cause, FailureCause::TimeStep { .. }),
                "{error}"
            );
            // A time limit does not give the step a length.
            let until = simulation.time() + 0.5 * f64::from(good);
            let error = simulation.step_until(until).expect_err("no time step");
            assert!(
                matches!(error.cause, FailureCause::TimeStep { .. }),
                "{error}"
            );
        }
        // Far too long, but a number: refused or shortened, and it ends.
        simulation.world_mut().resource_mut::<Clock>().next_dt = 10.0;
        let _ = simulation.step();
        simulation.world_mut().resource_mut::<Clock>().next_dt = good;
        run(&mut simulation, 2);
    }
}

#[test]
fn a_step_without_a_scene_is_an_error() {
    let mut world = World::new();
    let error = take_step(&mut world).expect_err("no scene");
    assert!(
        error.to_string().contains("call `install` first"),
        "{error}"
    );
    world.insert_resource(Execution::new(1).expect("a thread"));
    take_step(&mut world).expect_err("no scene still");
}

/// Entities, and whether there is a clock, before and after a failing installation.
fn leaves_nothing(scene: &Scene) {
    let mut world = World::new();
    let count = |world: &mut World| world.query::<Entity>().iter(world).count();
    // Entities of the host remain.
    world.spawn(Tag);
    let before = count(&mut world);
    install(&mut world, scene).expect_err("a scene that cannot be");
    assert_eq!(count(&mut world), before);
    assert!(!world.contains_resource::<Clock>());
    take_step(&mut world).expect_err("no scene");
    install(&mut world, &dam()).expect("the world is free");
    let report = take_step(&mut world).expect("a step");
    assert_eq!(report.particles, DAM_PARTICLES);
    let mut alone = simulation(&dam());
    run(&mut alone, 1);
    assert!(bits(&mut world) == bits(alone.world_mut()));
}

#[test]
fn an_install_that_fails_leaves_nothing_and_another_works() {
    let mut negative = dam();
    negative.spacing = -1.0;
    leaves_nothing(&negative);

    let mut far = dam();
    far.index.structure = IndexStructure::UniformGrid;
    far.index.cell_size = 0.05;
    far.boundaries.push(BoundaryShape::Sphere {
        center: Vec3::splat(800.0),
        radius: 0.1,
        rotation: glam::DVec3::ZERO,
        name: None,
        motion: None,
        slip: overfall::scene::WallSlip::Free,
    });
    leaves_nothing(&far);

    let mut disorderly = dam();
    disorderly.order = Some("/there/is/no/such/file".to_owned());
    leaves_nothing(&disorderly);
}

#[test]
fn walls_that_a_host_spoilt_are_refused() {
    let scene = dam();
    let mut simulation = simulation(&scene);
    run(&mut simulation, 1);
    let mut expected = common::simulation(&scene);
    run(&mut expected, 3);
    let world = simulation.world_mut();
    let mut walls = world.query_filtered::<(Entity, &Position, &BoundaryNormal), With<Boundary>>();
    let walls: Vec<_> = walls.iter(world).map(|(e, x, n)| (e, *x, *n)).collect();
    let (wall, position, normal) = walls[walls.len() / 2];
    let named = |error: &BoundaryError| match *error {
        BoundaryError::LacksComponent { particle, .. }
        | BoundaryError::Unusable { particle, .. } => particle,
        ref other => panic!("{other}"),
    };
    for bad in [f32::NAN, f32::INFINITY, 1e30] {
        let place = Position(position.0.with_y(bad));
        world.entity_mut(wall).insert(place);
        let error = refresh_boundary(world, &scene).expect_err("no place");
        assert_eq!(named(&error), wall, "{error}");
        world.entity_mut(wall).insert(position);
        for normal in [normal.0 * bad, Vec3::ZERO, normal.0 * 2.0] {
            world.entity_mut(wall).insert(BoundaryNormal(normal));
            let error = refresh_boundary(world, &scene).expect_err("no direction");
            assert_eq!(named(&error), wall, "{error}");
        }
        world.entity_mut(wall).insert(normal);
    }
    world.entity_mut(wall).remove::<BoundaryVolume>();
    let error = refresh_boundary(world, &scene).expect_err("no volume");
    assert_eq!(named(&error), wall, "{error}");
    world.entity_mut(wall).insert(BoundaryVolume(0.0));
    refresh_boundary(&mut World::new(), &scene).expect_err("no scene");
    // The step never saw it.
    refresh_boundary(world, &scene).expect("the walls as they were");
    run(&mut simulation, 2);
    assert!(bits(simulation.world_mut()) == bits(expected.world_mut()));
}

#[test]
fn a_number_in_a_frame_is_never_another_particles() {
    let scene = Scene {
        pressure: sesph(),
        time_step: TimeStep::Fixed(1e-4),
        reorder_interval: 3,
        ..dam()
    };
    let mut world = World::new();
    // Also before the scene is installed.
    let early = world
        .spawn((Fluid, Position(Vec3::new(0.35, 0.35, 0.1))))
        .id();
    install(&mut world, &scene).expect("a scene");
    let mut owners: HashMap<u32, Entity> = HashMap::new();
    let mut numbers: HashMap<Entity, u32> = HashMap::new();
    let mut drops = vec![early];
    for k in 0..60 {
        take_step(&mut world).expect("a step");
        let mut fluid = world.query_filtered::<(Entity, &ParticleId), With<Fluid>>();
        for (entity, id) in fluid.iter(&world) {
            assert_eq!(*owners.entry(id.get()).or_insert(entity), entity);
            assert_eq!(*numbers.entry(entity).or_insert(id.get()), id.get());
        }
        let frame = Frame::from_world(&mut world);
        let mut ids = frame.ids.clone();
        ids.sort_unstable();
        ids.dedup();
        assert_eq!(ids.len(), frame.len());
        assert!(ids.iter().all(|id| owners.contains_key(id)));
        for drop in drops.drain(..) {
            world.despawn(drop);
        }
        for corner in 0..2 {
            let place = Vec3::new(0.3 + 0.05 * corner as f32, 0.35, 0.02 + 0.002 * k as f32);
            drops.push(world.spawn((Fluid, Position(place))).id());
        }
    }
    assert_eq!(owners.len(), DAM_PARTICLES + 1 + 2 * 59);
}
