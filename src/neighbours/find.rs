//! The neighbour lists of the fluid, computed in every step.

use bevy_ecs::prelude::*;

use super::{
    lists::NeighbourLists,
    search::{Search, search},
    verlet,
};
use crate::{
    index::{self, BoundarySamples, FluidIndex},
    scene::Scene,
    state::{Execution, Failure, FailureCause, ListsTooLong, Phase, Positions, Product, Stage},
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

/// Lists of the fluid particles (absent when neighbours are recomputed).
#[derive(Resource, Default)]
pub struct FluidNeighbours {
    /// The lists.
    pub lists: NeighbourLists,
    /// Number of searches so far.
    pub(crate) generation: u64,
}

/// Lists of the boundary particles around every fluid particle.
#[derive(Resource, Default)]
pub struct BoundaryNeighbours(pub NeighbourLists);

/// Finds the neighbours among the fluid (phase `FindNeighbours`).
pub fn find_fluid_neighbours(
    mut lists: ResMut<FluidNeighbours>,
    mut failure: ResMut<Failure>,
    index: Res<FluidIndex>,
    positions: Res<Positions>,
    execution: Res<Execution>,
) {
    lists.generation += 1;
    let task = Search::among_themselves(&*index.structure, positions.points());
    note(search(&task, &mut lists.lists, &execution), &mut failure);
}

/// Finds the neighbours among the boundary (phase `FindNeighbours`).
pub fn find_boundary_neighbours(
    mut lists: ResMut<BoundaryNeighbours>,
    mut failure: ResMut<Failure>,
    index: Res<FluidIndex>,
    boundary: Res<BoundarySamples>,
    positions: Res<Positions>,
    execution: Res<Execution>,
) {
    let task = Search {
        of: &*index.structure,
        points: positions.points(),
        among: &*boundary.index,
        among_points: boundary.points(),
        same: false,
    };
    note(search(&task, &mut lists.0, &execution), &mut failure);
}

/// Records lists that are too long as the step's failure.
fn note(result: Result<(), ListsTooLong>, failure: &mut Failure) {
    if let Err(error) = result {
        let row = match error {
            ListsTooLong::OfRow { row, .. } => Some(row),
            ListsTooLong::Together { .. } => None,
        };
        failure.record(FailureCause::ListsTooLong(error), row);
    }
}
