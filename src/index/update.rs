//! The index of the fluid, updated in every step.

use bevy_ecs::prelude::*;

use super::{
    build::{build, bytes_per_particle},
    structure::SpatialIndex,
};
use crate::state::{Execution, Failure, FailureCause, Phase, Positions, Product, Stage};

/// The spatial index.
pub(crate) const STAGE: Stage = Stage {
    needs: &[Product::Columns],
    makes: &[Product::Index],
    install: |world, scene| {
        world.insert_resource(FluidIndex {
            structure: build(scene),
            reordered: true,
            slack: 0.5 * (scene.search_radius() - scene.support_radius()),
        });
    },
    bytes: |scene, _| vec![("spatial index", bytes_per_particle(scene))],
    ..Stage::new("rebuild_index", Phase::RebuildIndex, |_| {
        update_index.into_configs()
    })
};

/// Index of the fluid particles.
#[derive(Resource)]
pub struct FluidIndex {
    /// The structure that the scene selects.
    pub(crate) structure: Box<dyn SpatialIndex>,
    /// Whether the rows were reordered since the last update.
    pub(crate) reordered: bool,
    /// How far a particle may be from where it was indexed \[m]: 0 unless the scene keeps its lists.
    pub(crate) slack: f32,
}

impl FluidIndex {
    /// The structure that the scene selects.
    pub fn structure(&self) -> &dyn SpatialIndex {
        &*self.structure
    }
}

/// Updates the index for the present rows (phase `RebuildIndex`).
pub fn update_index(
    mut index: ResMut<FluidIndex>,
    mut failure: ResMut<Failure>,
    positions: Res<Positions>,
    execution: Res<Execution>,
) {
    let update = if index.reordered {
        index.structure.rebuild(positions.points(), &execution)
    } else {
        index.structure.update(positions.points(), &execution)
    };
    match update {
        Ok(()) => index.reordered = false,
        Err(error) => failure.record(FailureCause::DomainTooLarge(error), Some(error.row)),
    }
}
