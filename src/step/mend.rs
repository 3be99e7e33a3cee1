//! What a host wrote to resources of the engine ([`seal`](crate::state::seal)): what every step makes anew is mended,
//! the rest refused until the host puts it back.

use bevy_ecs::{component::ComponentId, prelude::*};

use super::installed::Installed;
use crate::{
    boundary::{friction::WallFriction, owners::Owners, refresh_boundary, sums::BoundarySums},
    index::{BoundarySamples, FluidIndex},
    neighbours::{self, BoundaryNeighbours, FluidNeighbours},
    pairs::KernelGradients,
    pressure::{
        density_rate::{DensityRates, PredictedVelocities},
        dfsph::DivergenceTerms,
        diagonal::InverseDiagonals,
        implicit::Iterates,
        initial::StartingRates,
        neighbour_count::NeighbourCounts,
        pcisph::PredictedDensities,
    },
    state::{
        Accelerations, Clock, Densities, Displacements, Failure, Positions, PredictedPositions,
        PressureAccelerations, Pressures, Rows, Velocities, seal::Seal,
    },
};

/// Ids of resource types in a world.
macro_rules! ids {
    ($world:expr, $($resource:ty),* $(,)?) => {
        [$($world.component_id::<$resource>()),*]
    };
}

/// Resources by row that a step fills before it reads them.
fn by_row(world: &World) -> [Option<ComponentId>; 21] {
    ids!(
        world,
        Accelerations,
        BoundaryNeighbours,
        Densities,
        DensityRates,
        Displacements,
        DivergenceTerms,
        FluidIndex,
        FluidNeighbours,
        InverseDiagonals,
        Iterates,
        KernelGradients,
        NeighbourCounts,
        Positions,
        PredictedDensities,
        PredictedPositions,
        PredictedVelocities,
        PressureAccelerations,
        Pressures,
        Rows,
        StartingRates,
        Velocities,
    )
}

/// Mends what was written since the last step, or fails this one for it (before the first stage).
pub(super) fn mend(world: &mut World) {
    let Some(mut seal) = world.remove_resource::<Seal>() else {
        return;
    };
    let step = world.resource::<Clock>().step;
    seal.begin(world, step);
    seal.written.retain(|written| !is_mended(world, written.id));
    if let Some(written) = seal.written.first() {
        let cause = written.cause();
        world.resource_mut::<Failure>().record(cause, None);
    }
    let now = world.increment_change_tick();
    seal.take(world, now);
    world.insert_resource(seal);
}

/// Makes a resource anew. False for one that remembers earlier steps.
fn is_mended(world: &mut World, id: ComponentId) -> bool {
    let id = Some(id);
    let Some(installed) = world.get_resource::<Installed>() else {
        return false;
    };
    let scene = installed.scene.clone();
    if by_row(world).contains(&id) {
        // Nothing that is left from an earlier step is of use for these rows.
        world.resource_mut::<Rows>().entities.clear();
        (neighbours::INDEX.install)(world, &scene);
        return true;
    }
    let of_walls = ids!(world, BoundarySamples, BoundarySums, Owners, WallFriction);
    if !of_walls.contains(&id) {
        return false;
    }
    let sums = BoundarySums::new(scene.pressure.solver().beside_wall(&scene));
    world.insert_resource(sums);
    if world.contains_resource::<WallFriction>() {
        world.insert_resource(WallFriction::new(&scene, Vec::new()));
    }
    refresh_boundary(world, &scene).is_ok()
}
