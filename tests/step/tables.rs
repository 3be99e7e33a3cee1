//! Particles in tables of the host: they are spawned, despawned, kept and sorted, and keep their identity.

use bevy_ecs::{entity_disabling::Disabled, prelude::*};
use glam::{IVec3, Vec3};
use overfall::{
    Simulation,
    index::{FluidIndex, z_curve},
    scene::{Neighbours, Scene},
    state::particle::{Density, Fluid, Position, Pressure, Velocity},
};

use crate::common::{
    self, DAM_PARTICLES, bits, dam, methods, pcisph, run, sesph, simulation, state,
};

/// Components of the host. Every set of table components has a table.
#[derive(Component)]
pub(super) struct Tag<const N: usize>;

#[derive(Component, Clone, Copy, Debug, PartialEq)]
pub(super) struct Start(pub(super) Vec3);

#[derive(Component)]
#[component(storage = "SparseSet")]
struct Sparse;

/// The dam with the equation of state, which does not iterate.
fn sesph_dam(reorder_interval: u32) -> Scene {
    Scene {
        pressure: sesph(),
        reorder_interval,
        ..dam()
    }
}

pub(super) fn tag(world: &mut World, entity: Entity, tags: usize) {
    let mut particle = world.entity_mut(entity);
    if tags & 1 != 0 {
        particle.insert(Tag::<0>);
    }
    if tags & 2 != 0 {
        particle.insert(Tag::<1>);
    }
    if tags & 4 != 0 {
        particle.insert(Tag::<2>);
    }
    if tags & 8 != 0 {
        particle.insert(Tag::<3>);
    }
    if tags & 16 != 0 {
        particle.insert(Sparse);
    }
}

fn entities(simulation: &mut Simulation) -> Vec<Entity> {
    let state = state(simulation.world_mut());
    state.into_iter().map(|particle| particle.0).collect()
}

/// Lengths of the tables with fluid, and the keys of their rows.
fn tables(world: &mut World) -> Vec<Vec<u64>> {
    let mut fluid = world.query_filtered::<&Position, With<Fluid>>();
    let grid = world.resource::<FluidIndex>().structure().grid();
    let cells: Vec<Vec<IVec3>> = fluid
        .contiguous_iter(world)
        .expect("table components")
        .map(|table| {
            table
                .iter()
                .map(|x| grid.cell_of(x.0.extend(0.0)))
                .collect()
        })
        .collect();
    let origin = cells.iter().flatten().copied().fold(IVec3::MAX, IVec3::min);
    let keys = |table: Vec<IVec3>| {
        let key = |cell: &IVec3| z_curve::key(*cell, origin);
        table.iter().map(key).collect()
    };
    cells.into_iter().map(keys).collect()
}

fn along_the_z_curve(keys: &[u64]) -> bool {
    keys.is_sorted() || keys.iter().rev().is_sorted()
}

#[test]
fn tables_change_the_results_by_rounding_only() {
    for (pressure, steps, tolerance) in [(sesph(), 24, 1e-5), (pcisph(), 12, 1e-4)] {
        let scene = Scene {
            pressure,
            reorder_interval: 10,
            ..dam()
        };
        let mut plain = simulation(&scene);
        let mut tagged = simulation(&scene);
        for (k, entity) in entities(&mut tagged).into_iter().enumerate() {
            tag(tagged.world_mut(), entity, k % 32);
        }
        assert_eq!(tables(tagged.world_mut()).len(), 16);
        for _ in 0..steps {
            run(&mut plain, 1);
            run(&mut tagged, 1);
        }
        let expected = state(plain.world_mut());
        common::assert_near(&state(tagged.world_mut()), &expected, tolerance);
    }
}

#[test]
fn tagging_between_steps_moves_no_particle() {
    let scene = sesph_dam(5);
    let mut plain = simulation(&scene);
    let mut tagged = simulation(&scene);
    let entities = entities(&mut tagged);
    for step in 0..20 {
        for (k, &entity) in entities.iter().enumerate().skip(step).step_by(20) {
            tag(tagged.world_mut(), entity, k % 32);
        }
        let before = bits(tagged.world_mut());
        assert_eq!(before.len(), DAM_PARTICLES);
        run(&mut plain, 1);
        run(&mut tagged, 1);
    }
    common::assert_near(
        &state(tagged.world_mut()),
        &state(plain.world_mut()),
        0.05 * scene.spacing,
    );
}

/// A query that saw several new tables at once may visit them in another order than one that saw them one by one.
#[test]
fn tables_that_appear_around_a_failed_step_keep_their_particles() {
    let scene = sesph_dam(4);
    let mut simulation = simulation(&scene);
    run(&mut simulation, 1);
    let entities = entities(&mut simulation);
    for (k, &entity) in entities.iter().enumerate() {
        tag(simulation.world_mut(), entity, k % 4);
    }
    let spoilt = entities[100];
    let position = *simulation
        .world()
        .get::<Position>(spoilt)
        .expect("a particle");
    simulation
        .world_mut()
        .entity_mut(spoilt)
        .insert(Position(Vec3::NAN));
    let error = simulation.step().expect_err("a position that is no number");
    assert_eq!(error.particle.map(|particle| particle.0), Some(spoilt));
    simulation.world_mut().entity_mut(spoilt).insert(position);
    for (k, &entity) in entities.iter().enumerate() {
        tag(simulation.world_mut(), entity, k % 16);
    }
    for _ in 0..8 {
        let before = state(simulation.world_mut());
        run(&mut simulation, 1);
        let after = state(simulation.world_mut());
        common::assert_near(&after, &before, 0.5 * scene.support_radius());
    }
}

#[test]
fn disabled_particles_rest_and_come_back() {
    let scene = sesph_dam(3);
    let mut simulation = simulation(&scene);
    run(&mut simulation, 2);
    let all = state(simulation.world_mut());
    let (resting, _) = all.split_at(300);
    for (entity, ..) in resting {
        simulation.world_mut().entity_mut(*entity).insert(Disabled);
    }
    for _ in 0..7 {
        let report = simulation.step().expect("a step");
        assert_eq!(report.particles, DAM_PARTICLES - 300);
    }
    for (entity, x, v) in resting {
        let world = simulation.world();
        assert_eq!(world.get::<Position>(*entity), Some(&Position(*x)));
        assert_eq!(world.get::<Velocity>(*entity), Some(&Velocity(*v)));
    }
    let entity = resting[0].0;
    simulation
        .world_mut()
        .entity_mut(entity)
        .insert(Position(Vec3::new(0.35, 0.3, 0.1)))
        .remove::<Disabled>();
    for _ in 0..4 {
        let report = simulation.step().expect("a step");
        assert_eq!(report.particles, DAM_PARTICLES - 299);
    }
    assert_ne!(
        simulation.world().get::<Density>(entity),
        Some(&Density(0.0))
    );
}

#[test]
fn particles_come_and_go_between_steps() {
    for pressure in methods() {
        let scene = Scene {
            pressure,
            reorder_interval: 4,
            ..dam()
        };
        let mut simulation = simulation(&scene);
        let mut alive = DAM_PARTICLES;
        let mut spawned = Vec::new();
        for step in 0..18 {
            let world = simulation.world_mut();
            let victims: Vec<Entity> = state(world)
                .iter()
                .skip(step)
                .step_by(50)
                .map(|p| p.0)
                .collect();
            alive -= victims.len();
            victims.into_iter().for_each(|entity| {
                world.despawn(entity);
            });
            // Drops above the surface, one at each corner, each in a table of its own.
            for corner in 0..4 {
                let (i, k) = ((corner % 2) as f32, (corner / 2) as f32);
                let place = Vec3::new(0.28 + 0.08 * i, 0.02 + 0.018 * step as f32, 0.04 + 0.1 * k);
                let drop = world.spawn((Fluid, Position(place))).id();
                tag(world, drop, corner);
                spawned.push((drop, place));
                alive += 1;
            }
            let report = simulation.step().expect("a step");
            assert_eq!(report.particles, alive);
        }
        let state = state(simulation.world_mut());
        assert_eq!(state.len(), alive);
        for (drop, place) in spawned {
            if let Some((_, x, v)) = state.iter().find(|particle| particle.0 == drop) {
                assert!(
                    x.distance(place) < 0.1 && v.is_finite(),
                    "{drop} from {place} at {x}"
                );
                let density = simulation.world().get::<Density>(drop).expect("required").0;
                assert!(density > 0.0);
                assert!(simulation.world().get::<Pressure>(drop).is_some());
            }
        }
    }
}

#[test]
fn reordering_keeps_every_entity_with_its_particle() {
    let run_with = |reorder_interval: u32| {
        let scene = sesph_dam(reorder_interval);
        let mut simulation = simulation(&scene);
        for (entity, x, _) in state(simulation.world_mut()) {
            simulation.world_mut().entity_mut(entity).insert(Start(x));
        }
        let started = entities(&mut simulation);
        for step in 1..=24u32 {
            run(&mut simulation, 1);
            if reorder_interval > 0 && step.is_multiple_of(reorder_interval) {
                let tables = tables(simulation.world_mut());
                assert_eq!(tables.len(), 1, "one table and no strays");
                assert!(along_the_z_curve(&tables[0]), "step {step}");
            }
        }
        let world = simulation.world_mut();
        assert_eq!(state(world).len(), started.len());
        let mut query = world.query_filtered::<(&Start, &Position, &Velocity), With<Fluid>>();
        let mut ends: Vec<_> = query
            .iter(world)
            .map(|(start, x, v)| (start.0.to_array().map(f32::to_bits), x.0, v.0))
            .collect();
        ends.sort_by_key(|end| end.0);
        ends
    };
    let never = run_with(0);
    let often = run_with(5);
    let mut moved = 0.0f32;
    for ((start, x, v), (other_start, other_x, other_v)) in never.iter().zip(&often) {
        assert_eq!(start, other_start);
        assert!(x.distance(*other_x) < 1e-4, "{x} and {other_x}");
        assert!(v.distance(*other_v) < 0.1, "{v} and {other_v}");
        moved = moved.max(x.distance(Vec3::from_array(start.map(f32::from_bits))));
    }
    assert!(moved > 1e-3, "nothing moved");
}

#[test]
fn spawned_particles_are_sorted_in_with_the_next_reordering() {
    let scene = sesph_dam(4);
    let mut simulation = simulation(&scene);
    // So that both sides of the reordering are covered.
    for round in 0..3 {
        let world = simulation.world_mut();
        for k in 0..20 {
            let place = Vec3::new(0.3, 0.02 * k as f32, 0.02 + 0.06 * round as f32);
            world.spawn((Fluid, Position(place)));
        }
        run(&mut simulation, 4);
        let tables = tables(simulation.world_mut());
        assert_eq!(tables.len(), 1);
        assert_eq!(tables[0].len(), DAM_PARTICLES + 20 * (round + 1));
        assert!(along_the_z_curve(&tables[0]), "round {round}");
    }
}

#[test]
fn every_table_is_sorted_by_itself() {
    let scene = sesph_dam(4);
    let mut simulation = simulation(&scene);
    for (k, entity) in entities(&mut simulation).into_iter().enumerate() {
        tag(simulation.world_mut(), entity, k % 4);
    }
    for _ in 0..3 {
        run(&mut simulation, 4);
        let tables = tables(simulation.world_mut());
        assert_eq!(tables.len(), 4);
        assert!(tables.iter().all(|keys| along_the_z_curve(keys)));
    }
}

#[test]
fn a_world_without_fluid_steps_on_and_fills_again() {
    for pressure in methods() {
        for neighbours in [Neighbours::Stored, Neighbours::Recomputed] {
            let scene = Scene {
                pressure,
                neighbours,
                reorder_interval: 2,
                ..dam()
            };
            let mut simulation = simulation(&scene);
            run(&mut simulation, 1);
            for entity in entities(&mut simulation) {
                simulation.world_mut().despawn(entity);
            }
            for _ in 0..3 {
                let report = simulation.step().expect("an empty step");
                assert_eq!(report.particles, 0);
                assert!(report.dt.is_finite() && report.kinetic_energy == 0.0);
                assert!(report.mean_density_error == 0.0 && report.mean_neighbours == 0.0);
            }
            let place = Vec3::new(0.1, 0.3, 0.1);
            let drop = simulation.world_mut().spawn((Fluid, Position(place))).id();
            for _ in 0..3 {
                assert_eq!(simulation.step().expect("a drop").particles, 1);
            }
            assert!(simulation.world().get::<Position>(drop).expect("it").0.y < place.y);
        }
    }
}
