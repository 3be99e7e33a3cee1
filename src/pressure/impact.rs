//! Impacts: steps in which fluid meets a wall or other fluid, so that pressure stops it within the step.
//!
//! Such a pressure is an impulse: it grows with 1/dt, and lasts for the step alone. Two things that hold for pressures
//! that last do not hold for it. Both were found on blocks that fall flat onto a floor (`docs/decisions/impacts.md`).
//!
//! 1. [Stabilisation](super::stabilisation) leaves a density error of the order of κ dt² Δp/ρ. Of an impulse that is a
//!    share of the impact in a step of any length, and it pushes rows into each other: the solve is repeated without.
//! 2. Densities that are predicted by their rates miss the compression of particles that come near each other within
//!    the step: the step is halved.

use std::mem;

use bevy_ecs::prelude::*;
use rayon::prelude::*;

use super::{
    implicit::{ImpactLimit, Iterates, predict_positions},
    stabilisation::Stabilisation,
};
use crate::{
    density::DensitySum,
    flow::HeldRows,
    pairs::Pairs,
    state::{Clock, Densities, Execution, Material, PredictedPositions, SolverState},
};

/// Largest compression \[-] beyond that at the start of a step that its end may have.
const MOST_UNFORESEEN: f32 = 0.1;

/// Whether the density solve of this step found an impact.
pub(super) fn is_met(world: &World) -> bool {
    let dt = world.resource::<Clock>().dt;
    let execution = world.resource::<Execution>();
    let iterates = &world.resource::<Iterates>().0;
    let own = iterates[execution.owned(iterates.len())].par_iter();
    let terms = own.map(|term| term.acted);
    let largest = execution.install(|| terms.reduce(|| 0.0, f32::max));
    let density = world.resource::<Material>().rest_density;
    density * dt * dt * execution.largest(largest) > world.resource::<ImpactLimit>().0
}

/// Whether the system is stabilised.
pub(super) fn is_stabilised(world: &World) -> bool {
    *world.resource::<Stabilisation>() != Stabilisation::NONE
}

/// Solves again, without stabilisation, and counts the iterations of both.
pub(super) fn without_stabilisation<T>(
    world: &mut World,
    solve: impl FnOnce(&mut World) -> T,
) -> T {
    let mut stabilisation = world.resource_mut::<Stabilisation>();
    let share = mem::replace(&mut *stabilisation, Stabilisation::NONE);
    let before = world.resource::<SolverState>().iterations;
    let result = solve(world);
    world.resource_mut::<SolverState>().iterations += before;
    *world.resource_mut::<Stabilisation>() = share;
    result
}

/// Whether the end of the step has compression that its solve did not foresee.
pub(super) fn compresses(world: &mut World) -> bool {
    // Systems that read and write plain columns cannot fail.
    let _ = world.run_system_cached(predict_positions);
    (world.run_system_cached(largest_unforeseen)).is_ok_and(|largest| largest > MOST_UNFORESEEN)
}

/// The largest compression at the predicted positions, less the one at the start of the step \[-].
fn largest_unforeseen(
    predicted: Res<PredictedPositions>,
    found: Res<Densities>,
    held: Option<Res<HeldRows>>,
    pairs: Pairs,
    material: Res<Material>,
) -> f32 {
    let rest_density = material.rest_density;
    let mut densities = vec![0.0; pairs.positions().rows()];
    pairs.sum_ahead(
        &predicted.0,
        &DensitySum::anywhere(&material),
        &mut densities,
    );
    if let Some(held) = held {
        held.ease(&mut densities, rest_density);
    }
    let own = pairs.execution.owned(densities.len());
    let columns = densities[own.clone()].iter().zip(&found.0[own]);
    let largest = columns.fold(0.0_f32, |largest, (ahead, found)| {
        largest.max((ahead - found.max(rest_density)) / rest_density)
    });
    pairs.execution.largest(largest)
}
