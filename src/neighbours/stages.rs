//! The stages that index particles and list their neighbours.

use bevy_ecs::prelude::*;

use super::{
    find::{BoundaryNeighbours, FluidNeighbours, find_boundary_neighbours, find_fluid_neighbours},
    verlet,
};
use crate::{
    index,
    scene::Scene,
    state::{Phase, Product, Stage},
};

/// The index: rebuilt in every step, or together with lists that are kept.
pub(crate) const INDEX: Stage = Stage {
    install: |world, scene| {
        (index::STAGE.install)(world, scene);
        if scene.skin().is_some() {
            verlet::install(world, scene);
        }
    },
    systems: |scene| match scene.skin() {
        Some(_) => verlet::index_systems(),
        None => (index::STAGE.systems)(scene),
    },
    ..index::STAGE
};

/// Neighbour lists, if the scene stores them.
pub(crate) const STAGE: Stage = Stage {
    needs: &[Product::Columns, Product::Index, Product::Walls],
    makes: &[Product::Neighbours],
    wanted: Scene::stores_neighbours,
    install: |world, scene| {
        world.init_resource::<FluidNeighbours>();
        if !scene.boundaries.is_empty() {
            world.init_resource::<BoundaryNeighbours>();
        }
    },
    bytes: |scene, neighbours| {
        let lists = if scene.boundaries.is_empty() {
            1.0
        } else {
            2.0
        };
        let entries = f64::from(neighbours) * scene.listed_per_neighbour();
        let mut bytes = vec![("neighbour lists", entries * 4.0 * 1.01 + 6.0 * lists)];
        if scene.skin().is_some() {
            bytes.push(("places of the last search", 8.0 + 16.0));
        }
        bytes
    },
    ..Stage::new("find_neighbours", Phase::FindNeighbours, |scene| {
        if scene.skin().is_some() {
            verlet::list_systems(scene)
        } else if scene.boundaries.is_empty() {
            find_fluid_neighbours.into_configs()
        } else {
            (find_fluid_neighbours, find_boundary_neighbours).chain()
        }
    })
};
