//! The index of the fluid, brought up to date in every step.

use bevy_ecs::prelude::*;

use super::{build::build, structure::SpatialIndex};
use crate::{
    scene::{IndexStructure, Scene},
    state::{Execution, Failure, FailureCause, Phase, Positions, Product, Stage},
};

/// The spatial index.
pub(crate) const STAGE: Stage = Stage {
    needs: &[Product::Columns],
    makes: &[Product::Index],
    install: |world, scene| {
        world.insert_resource(FluidIndex {
            structure: build(scene),
            reordered: true,
        });
    },
    bytes: |scene, _| vec![("spatial index", bytes_per_particle(scene))],
    ..Stage::new("rebuild_index", Phase::RebuildIndex, |_| {
        update_index.into_configs()
    })
};

/// What the scene's spatial index takes, measured with eight particles per cell [bytes per particle]; the dense
/// structures take 4 bytes more for every empty cell of the box, spatial hashing two hash cells of 1.5 times a full
/// cell.
pub(crate) fn bytes_per_particle(scene: &Scene) -> f64 {
    match scene.index.structure {
        IndexStructure::UniformGrid => 25.0,
        IndexStructure::IndexSort => 37.0,
        IndexStructure::ZIndexSort => 33.0,
        IndexStructure::SpatialHashing => 216.0,
        IndexStructure::CompactHashing => 77.0,
        IndexStructure::BruteForce => 16.0,
    }
}

/// Index of the fluid particles.
#[derive(Resource)]
pub struct FluidIndex {
    /// The structure that the scene asks for.
    pub structure: Box<dyn SpatialIndex>,
    /// Whether the rows were reordered since the last update.
    pub reordered: bool,
}

/// Brings the index up to date with the rows (phase `RebuildIndex`).
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
