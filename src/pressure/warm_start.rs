//! What the iterations of a step start from: a share of the last step's pressures (Ihmsen et al. 2014), or of their
//! mean over the steps before.
//!
//! A pressure has two parts. One carries the fluid and lasts; the other takes back what the density of this step has
//! too much, and is another one in the next. All of the last step's pressures are too much of the second, a half too
//! little of the first, and what is missing is a long wave, which an iteration hardly touches. A mean keeps the first
//! and forgets the second: `p̄ ← p̄ + (p − p̄)/n`.
//!
//! How large a share may be. Of a wave of which the iterations leave the part R of an error, a share w leaves after a
//! step `e ← R (2 e − e' + w (e − 2 e' + e''))`, primes for the steps before. It does not grow for R from −1/(3 + 4 w)
//! on, and up to 1 if w is at most ½; with 0.6 it grows for R from 0.84 to 0.97, by at most 1.4 % a step, with 0.7 from
//! 0.72 on, by 4 %. So more than ½ is for steps that leave little of any wave: for a limit that takes many iterations.
//!
//! The corner dam break of 130 000 particles, 0.5 s in steps of 1 ms, DFSPH at a mean error of 0.01 %, iterations a
//! step and mean error: from 0.6 of the last pressures 9.1 and 0.0097 %, from 0.8 of them 7.6 and 0.0076 %, from means
//! over 10, 15, 20 steps 4.7, 4.0, 4.3 and 0.006 to 0.0075 %. Momentum that is ahead from the first iteration on saves
//! a fifth of them (4.9 to 4.0); without means still water would move more for it (see [`dfsph`](super::dfsph)), with
//! them it moves less. IISPH with three iterations leaves 0.05 % from means over 4 to 30 steps and 0.12 % from half of
//! the last pressures.
//!
//! It is a choice and no default, since water that stands moves more: from means over 15 steps in the plane with 0.20 %
//! of sqrt(g H) (root mean square; 0.05 % by default) with DFSPH, and with 2.1 % with IISPH, which iterates twice
//! there. The elliptic drop and the dam breaks in the plane do not change. Where the pressures of the last step jump,
//! as in an impact, means lag: with two iterations at 1 % and no momentum ahead single particles are compressed by 30
//! to 45 % (15 % by default), with momentum ahead at once by 13 %, with three by 5 % either way.
//!
//! Tried and dropped: means and 0.15 to 0.5 of what the last pressure is off them (4.0 to 4.6 iterations), or of a mean
//! of that (5.5 to 6.6 where means alone took 4.9); means counted no more than two or four times a particle's last
//! pressure, for spray that comes off a wall: no difference. Instead of means, conjugate gradients from 0.6 of the last
//! pressures: 8.1 iterations and one force more; with means 6.1 where momentum took 6.4.

use std::mem;

use bevy_ecs::prelude::*;
use glam::Vec3;

use super::implicit::Jacobi;
use crate::{
    scene::Scene,
    state::{
        Column, Densities, Execution, MeanPressures, Positions, PressureAccelerations,
        PressureSolve, Pressures,
        particle::{Fluid, MeanPressure},
    },
};

/// Which pressures the iterations of a step start from.
#[derive(Resource, Debug, Clone, Copy, PartialEq)]
pub struct WarmStart {
    /// Share of the pressures before [-].
    pub share: f32,
    /// Steps whose mean these are.
    pub steps: u32,
}

/// The column of the means.
pub(crate) const MEAN_PRESSURE: Column =
    Column::lasting::<MeanPressure>("mean pressure", "Pa", "over the steps before", 4)
        .gathered::<MeanPressure>()
        .only_if(starts_from_means);

/// Whether the steps of a scene start from means.
pub(crate) fn starts_from_means(scene: &Scene) -> bool {
    scene
        .pressure
        .iterations()
        .is_some_and(|iterations| iterations.warm_start.steps > 1)
}

/// Gives fluid that is spawned from now on a mean, if the steps of the scene start from means.
pub(crate) fn require_means(world: &mut World, scene: &Scene) {
    if starts_from_means(scene) {
        // Fails where a host has fluid already: of such particles the last pressures count.
        let _ = world.try_register_required_components::<Fluid, MeanPressure>();
    }
}

/// Inserts what iterations start from, and what means over several steps need.
pub fn install(world: &mut World, start: WarmStart) {
    world.insert_resource(start);
    if start.steps > 1 {
        world.insert_resource(MeanPressures {
            weight: 1.0 / start.steps as f32,
            means: Vec::new(),
        });
    }
}

/// Counts the pressures of this step in (phase `Pressure`, last).
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

/// Puts a share of those pressures beside the positions, as terms. With none the forces are zero until there are
/// pressures.
///
/// Columns are taken out of their resources and put back: a resource scope would leave a note of a removal in every
/// step, for which a world has no end.
pub(super) fn start(world: &mut World, share: f32) {
    let mut positions = mem::take(&mut *world.resource_mut::<Positions>());
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
        .resource_mut::<PressureSolve>()
        .begin(share > 0.0, overshoots);
}

/// Puts terms of this share beside the positions.
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
