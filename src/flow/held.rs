//! Particles behind the face of an emitter: they move at its speed, whatever acts on them.
//!
//! Their forces count for nothing in the step, in every iteration of the pressure solve, too: so the solve knows that
//! they do not yield, as walls in motion do not. In the step in which one passes the face, forces count for the part of
//! the step after that: a jet falls from the face on, whatever the steps are.

use std::ops::Range;

use bevy_ecs::{prelude::*, system::SystemParam};
use bytemuck::TransparentWrapper;
use glam::Vec3;
use rayon::prelude::*;

use super::sources::{Emitters, has_emitters};
use crate::{
    integrate::Motion,
    scene::Scene,
    state::{
        Accelerations, CHUNK, Clock, Column, Densities, Execution, GatheredColumn, Material,
        Positions, StateColumn, Systems, Velocities, particle::Fluid,
    },
};

/// The emitter that still moves a particle, counted from 1; 0 for free fluid.
#[derive(Component, Debug, Clone, Copy, Default, PartialEq, TransparentWrapper)]
#[repr(transparent)]
pub(crate) struct Held(pub(super) u32);

/// The column of it.
pub(crate) const HELD: Column = Column::lasting::<Held>(
    "emitter",
    "-",
    "that still moves the particle, from 1; 0 for free fluid",
    4,
)
.gathered::<Held>()
.only_if(has_emitters);

/// Lets all fluid have the component, so that fluid of bodies and of emitters is in one table.
pub(crate) fn require_held(world: &mut World, scene: &Scene) {
    if has_emitters(scene) {
        // Fails if a host has spawned fluid already: that lacks it, and is free.
        let _ = world.try_register_required_components::<Fluid, Held>();
    }
}

/// The particles that emitters move in the step at hand.
#[derive(Resource, Debug, Default)]
pub struct HeldRows {
    /// Emitters by row, from 1; 0 for free fluid.
    emitters: Vec<u32>,
    rows: Vec<HeldRow>,
    /// Work per mass that emitters do against the pressure force found last \[m²/s²].
    work: f64,
}

#[derive(Debug, Clone, Copy)]
struct HeldRow {
    row: u32,
    /// Time until it passes the face \[s].
    left: f32,
    velocity: Vec3,
    /// Of the layers where it waits \[-].
    compression: f32,
}

impl HeldRows {
    /// Takes their densities without the compression that they enter with.
    pub(crate) fn ease(&self, densities: &mut [f32], rest_density: f32) {
        for held in &self.rows {
            let density = &mut densities[held.row as usize];
            let without = *density - held.compression * rest_density;
            *density = density.min(without.max(rest_density));
        }
    }
}

impl HeldRow {
    /// The part of a step of `dt` in which it is free.
    fn free(&self, dt: f32) -> f32 {
        (1.0 - self.left / dt).clamp(0.0, 1.0)
    }
}

impl StateColumn for Held {
    type Value = u32;
    type Result = HeldRows;
    const COMPONENT: &'static str = "Held";

    fn scatter(result: &HeldRows, rows: Range<usize>, out: &mut [u32], on: &Execution) {
        on.copy(out, &result.emitters[rows]);
    }
}

impl GatheredColumn for Held {
    type Start = HeldRows;
    const QUANTITY: &'static str = "emitter";

    fn resize(start: &mut HeldRows, rows: usize) {
        // A table that lacks the component holds free fluid.
        start.emitters.clear();
        start.emitters.resize(rows, 0);
    }

    fn gather(
        start: &mut HeldRows,
        first: usize,
        values: &[u32],
        on: &Execution,
    ) -> Option<(usize, bool)> {
        on.copy(&mut start.emitters[first..first + values.len()], values);
        None
    }

    fn share(start: &mut HeldRows, on: &Execution) {
        on.share(&mut start.emitters);
    }
}

/// Finds the particles that emitters move, and gives them their speed (phase `RebuildIndex`, after the columns were
/// gathered).
pub(crate) fn find_held(
    mut held: ResMut<HeldRows>,
    mut velocities: ResMut<Velocities>,
    positions: Res<Positions>,
    emitters: Res<Emitters>,
    execution: Res<Execution>,
) {
    let HeldRows {
        emitters: of,
        rows,
        work,
    } = &mut *held;
    *work = 0.0;
    rows.clear();
    let of_chunk = |(chunk, of): (usize, &[u32])| {
        let numbered = (chunk * CHUNK..).zip(of);
        let is_held = numbered.filter(|(_, emitter)| **emitter > 0);
        let found = is_held.filter_map(|(row, emitter)| {
            let place = positions.0[row].truncate();
            let (left, velocity, compression) = emitters.left(*emitter, place)?;
            Some(HeldRow {
                row: row as u32,
                left,
                velocity,
                compression,
            })
        });
        found.collect::<Vec<_>>()
    };
    let chunks = of.par_chunks(CHUNK).enumerate();
    rows.extend(execution.install(|| chunks.flat_map_iter(of_chunk).collect::<Vec<_>>()));
    for held in &*rows {
        let velocity = &mut velocities.0[held.row as usize];
        *velocity = held.velocity.extend(velocity.w);
    }
}

/// The accelerations of particles that emitters move, in scenes with emitters.
#[derive(SystemParam)]
pub struct Hold<'w> {
    held: Option<ResMut<'w, HeldRows>>,
    clock: Res<'w, Clock>,
}

impl Hold<'_> {
    /// Reduces accelerations by pressure to the part of the step in which particles are free.
    pub fn reduce(&mut self, accelerations: &mut [Vec3]) {
        let dt = self.clock.dt;
        let Some(held) = &mut self.held else { return };
        let mut work = 0.0;
        for held in &held.rows {
            let acceleration = &mut accelerations[held.row as usize];
            let free = held.free(dt);
            // What an emitter does not let act on its particles, it does work against.
            work -= f64::from(dt * (1.0 - free) * acceleration.dot(held.velocity));
            *acceleration *= free;
        }
        held.work = work;
    }
}

/// Takes densities behind a face without the compression that the layers enter with (phase `Density`): particles that
/// do not yield could not be freed of that of a jitter, and no solve would converge. What is more is by other fluid,
/// which flows into the layers if nothing presses against it.
fn ease(mut densities: ResMut<Densities>, held: Res<HeldRows>, material: Res<Material>) {
    held.ease(&mut densities.0, material.rest_density);
}

/// The densities of a scene, with what emitters change of them.
pub(crate) fn after_density(scene: &Scene, density: Systems) -> Systems {
    if has_emitters(scene) {
        (density, ease).chain()
    } else {
        density
    }
}

/// Reduces accelerations by other forces (phase `Pressure`, before the solve).
fn hold_forces(mut accelerations: ResMut<Accelerations>, held: Res<HeldRows>, clock: Res<Clock>) {
    for held in &held.rows {
        accelerations.0[held.row as usize] *= held.free(clock.dt);
    }
}

/// Lets particles go that pass the face within the step, and notes the work of emitters (phase `Pressure`, after the
/// solve, which may have shortened the step).
fn release(mut held: ResMut<HeldRows>, mut motion: ResMut<Motion>, clock: Res<Clock>) {
    let HeldRows {
        emitters,
        rows,
        work,
    } = &mut *held;
    for row in rows.iter().filter(|row| row.left <= clock.dt) {
        emitters[row.row as usize] = 0;
    }
    motion.given = work.max(0.0);
}

/// The pressure solve of a scene, with what emitters do around it.
pub(crate) fn around_solve(scene: &Scene, solve: Systems) -> Systems {
    if has_emitters(scene) {
        (hold_forces, solve, release).chain()
    } else {
        solve
    }
}
