//! Initial pressures of the iterations: a share of the last step's pressures (Ihmsen et al. 2014), or of their
//! exponential mean over several steps, `p̄ ← p̄ + (p − p̄)/n`.
//!
//! A mean keeps the pressure that carries the fluid and averages out the corrections of single steps. In a dam break
//! of 130 000 particles (DFSPH, mean error 0.01 %) means over 10 to 20 steps need 4.0 to 4.7 iterations per step, a
//! share of 0.8 needs 7.6. They are a choice of the scene and not the default, because still water moves more and
//! pressures lag behind impacts. Stability, figures and rejected variants: `docs/decisions/warm_start.md`.

use std::mem;

use bevy_ecs::prelude::*;
use glam::Vec3;

use super::implicit::Jacobi;
use crate::{
    scene::Scene,
    state::{
        Column, Densities, Execution, MeanPressures, Positions, PressureAccelerations, Pressures,
        SolverState,
        particle::{Fluid, MeanPressure},
    },
};

/// The initial pressures of a step's iterations.
#[derive(Resource, Debug, Clone, Copy, PartialEq)]
pub struct WarmStart {
    /// Share of the earlier pressures \[-].
    pub(crate) share: f32,
    /// Averaging window \[steps]: 1 uses the last step's pressures, n an exponential mean with weight 1/n.
    pub(crate) steps: u32,
}

/// The column of the mean pressures.
pub(crate) const MEAN_PRESSURE: Column =
    Column::lasting::<MeanPressure>("mean pressure", "Pa", "over the steps before", 4)
        .gathered::<MeanPressure>()
        .only_if(starts_from_means);

/// Whether a scene starts its solves from mean pressures.
pub(crate) fn starts_from_means(scene: &Scene) -> bool {
    scene
        .pressure
        .iterations()
        .is_some_and(|iterations| iterations.warm_start.steps > 1)
}

/// Gives fluid that is spawned from now on a mean pressure, if the scene uses means.
pub(crate) fn require_means(world: &mut World, scene: &Scene) {
    if starts_from_means(scene) {
        // Fails if a host has spawned fluid already: such particles use their last pressures.
        let _ = world.try_register_required_components::<Fluid, MeanPressure>();
    }
}

/// Inserts the initial pressures, and the resources for means.
pub fn install(world: &mut World, start: WarmStart) {
    world.insert_resource(start);
    if start.steps > 1 {
        world.insert_resource(MeanPressures {
            weight: 1.0 / start.steps as f32,
            means: Vec::new(),
        });
    }
}

/// Updates the means with the pressures of this step (phase `Pressure`, last).
pub fn average_pressures(
    mut means: ResMut<MeanPressures>,
    pressures: Res<Pressures>,
    execution: Res<Execution>,
) {
    let MeanPressures { weight, means } = &mut *means;
    execution.for_each_chunk(means, |first, means| {
        for (mean, pressure) in means.iter_mut().zip(&pressures.0[first..]) {
            *mean += *weight * (pressure - *mean);
        }
    });
}

/// Writes a share of the earlier pressures beside the positions, as terms. With a share of zero, forces are zero until
/// there are pressures.
///
/// Columns are taken out of their resources and put back: a resource scope would record a removal in the world in
/// every step, and these records are never cleared.
pub(super) fn start(world: &mut World, share: f32) {
    let of_step = &mut *world.resource_mut::<Positions>();
    let mut positions = mem::replace(of_step, Positions(Vec::new()));
    let rows = positions.rows();
    put_terms(
        &mut positions,
        share,
        (world.resource::<Densities>(), world.resource::<Pressures>()),
        world.get_resource::<MeanPressures>(),
        world.resource::<Execution>(),
    );
    *world.resource_mut::<Positions>() = positions;
    if share == 0.0 {
        let mut forces = mem::take(&mut world.resource_mut::<PressureAccelerations>().0);
        forces.resize(rows, Vec3::ZERO);
        let execution = world.resource::<Execution>();
        execution.for_each_chunk(&mut forces, |_, chunk| chunk.fill(Vec3::ZERO));
        world.resource_mut::<PressureAccelerations>().0 = forces;
    }
    let overshoots = world
        .get_resource::<Jacobi>()
        .is_some_and(Jacobi::overshoots);
    world
        .resource_mut::<SolverState>()
        .begin(share > 0.0, overshoots);
}

/// Share of the earlier pressures whose terms viscosity finds beside the positions \[-]: that from which the solve
/// starts, or all if it starts from none.
pub(crate) fn share_of_terms(start: Option<&WarmStart>) -> f32 {
    start.map_or(
        1.0,
        |start| if start.share > 0.0 { start.share } else { 1.0 },
    )
}

/// Writes terms of this share beside the positions.
pub(crate) fn put_terms(
    positions: &mut Positions,
    share: f32,
    (densities, pressures): (&Densities, &Pressures),
    means: Option<&MeanPressures>,
    execution: &Execution,
) {
    let rows = positions.rows();
    execution.for_each_chunk(&mut positions.0[..rows], |first, positions| {
        let columns = pressures.0[first..].iter().zip(&densities.0[first..]);
        let rows = (first..).zip(positions.iter_mut().zip(columns));
        for (row, (position, (pressure, rho))) in rows {
            let pressure = means.map_or(*pressure, |of| of.means[row]);
            position.w = share * pressure / (rho * rho);
        }
    });
}
