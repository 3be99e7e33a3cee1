//! The start of a step: the particles' state in rows.

use bevy_ecs::prelude::*;

use super::columns::lasting;
use crate::{
    flow,
    pairs::KernelGradients,
    scene::Scene,
    state::{
        Accelerations, Densities, Phase, Positions, PredictedPositions, PressureAccelerations,
        Pressures, Product, Rows, Stage, Systems, Velocities, chain, of_step::OfStep, transfer,
        wrap,
    },
};

/// Columns of the state, gathered from the tables. They are never older than their step.
pub(super) const STAGE: Stage = Stage {
    makes: &[Product::Columns],
    install,
    bytes: |scene, neighbours| {
        // Entities by row, those of the table and the archetype, places by entity, the permanent numbers, and the mark.
        let entities = 8.0 + 8.0 + 12.0 + 24.0 + 12.0 + 8.0;
        let mut bytes = vec![("entities and numbers", entities)];
        if scene.stores_neighbours() {
            // Lists are padded to whole vectors, by half a vector on average.
            let entries = f64::from(neighbours) * scene.listed_per_neighbour();
            let gradients = (entries + 4.0) * 4.0 * 33.0 / 32.0;
            bytes.push(("gradients of the kernel", gradients));
        }
        bytes
    },
    ..Stage::new("gather", Phase::RebuildIndex, systems)
};

fn install(world: &mut World, scene: &Scene) {
    flow::install(world, scene);
    world.init_resource::<Rows>();
    world.init_resource::<OfStep>();
    world.insert_resource(Positions::empty());
    world.insert_resource(PredictedPositions::empty());
    world.insert_resource(Velocities::empty());
    world.insert_resource(Densities::empty());
    world.insert_resource(Pressures::empty());
    world.insert_resource(Accelerations::empty());
    world.insert_resource(PressureAccelerations::empty());
    if scene.stores_neighbours() {
        world.init_resource::<KernelGradients>();
    }
}

fn systems(scene: &Scene) -> Systems {
    let lasting = lasting(scene);
    let checks = lasting.iter().filter_map(|column| column.check);
    let gathers = lasting.iter().filter_map(|column| column.gather);
    let mut systems: Vec<Systems> = checks.map(|check| check()).collect();
    systems.push(transfer::check_ids.into_configs());
    systems.push(transfer::check_numbers.into_configs());
    systems.push(transfer::gather_rows.into_configs());
    systems.extend(gathers.map(|gather| gather()));
    if flow::has_emitters(scene) {
        systems.push(flow::find_held.into_configs());
    }
    if scene.period().is_any() {
        systems.push(wrap::wrap_start.into_configs());
    }
    chain(systems)
}
