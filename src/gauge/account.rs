//! Energy that the steps dissipate.
//!
//! Dissipation is recorded step by step: kinetic and potential energy in the tables before the step, minus those after
//! it, minus the energy taken up by compression. So changes by a host between steps, such as adding, moving or removing
//! particles, are not dissipation. Losses by viscosity, the pressure solve, walls at rest and the time integration are
//! (gains are negative).
//!
//! Gravity and central forces have a potential. Work by moving walls, by emitters on what waits behind their faces, by
//! tables of accelerations and waves, by gravity along a periodic axis, and what a ramp of gravity lacks is external:
//! it is included in the dissipation, as a negative contribution.

use bevy_ecs::prelude::*;
use serde::{Deserialize, Serialize};

use crate::{
    integrate::Motion,
    pressure::{delta_sph::Continuity, sesph::EquationOfState},
    state::{
        BodyForces, Densities, Material, Pressures, Remembers, in_order,
        particle::{Fluid, Position, Velocity},
    },
};

/// Energy dissipated by the steps so far; in scenes that measure energies.
#[derive(Resource, Debug, Default, Clone, Copy)]
pub struct EnergyAccount {
    /// Kinetic and potential energy at the start of the step \[J].
    at_start: f64,
    booked: Booked,
    /// The same before the last step, for a roll-back.
    before: Booked,
}

#[derive(Debug, Default, Clone, Copy, Serialize, Deserialize)]
pub(crate) struct Booked {
    /// Kinetic and potential energy that all steps removed \[J].
    taken: f64,
    /// Energy of compression in the first step \[J], and now.
    compression: Option<(f64, f64)>,
}

impl Remembers for EnergyAccount {
    type State = [Booked; 2];

    fn state(&self, _: &[Entity]) -> [Booked; 2] {
        [self.booked, self.before]
    }

    fn set_state(&mut self, state: [Booked; 2], _: &[Entity]) -> Result<(), &'static str> {
        [self.booked, self.before] = state;
        Ok(())
    }
}

impl EnergyAccount {
    /// Energy of compression \[J].
    pub(super) fn compression(&self) -> f64 {
        self.booked.compression.map_or(0.0, |(_, now)| now)
    }

    /// Energy that steps dissipated \[J].
    pub(super) fn dissipated(&self) -> f64 {
        let stored = self
            .booked
            .compression
            .map_or(0.0, |(first, now)| now - first);
        self.booked.taken - stored
    }

    /// Rolls back the last step.
    pub(super) fn go_back(&mut self) {
        self.booked = self.before;
    }
}

/// Measures the state at the start of the step (before its first phase).
pub(crate) fn note_start(
    mut account: ResMut<EnergyAccount>,
    fluid: Query<(Entity, &Position, &Velocity), With<Fluid>>,
    (material, body_forces): (Res<Material>, Option<Res<BodyForces>>),
) {
    let (mut squares, mut heights) = (0.0, 0.0);
    let gravity = material.gravity_with_potential();
    let tables = fluid.contiguous_iter().into_iter().flatten();
    for (_, x, v) in in_order(tables, |table| table.0) {
        for (x, v) in x.iter().zip(v.iter()) {
            squares += f64::from(v.0.length_squared());
            heights += f64::from(gravity.dot(x.0));
            if let Some(forces) = &body_forces {
                heights -= f64::from(forces.potential(x.0));
            }
        }
    }
    // Before the first phase, where a host's writes are looked for: this is none.
    let account = account.bypass_change_detection();
    account.at_start = f64::from(material.particle_mass) * (0.5 * squares - heights);
}

/// Records the step (phase `Observe`, if it succeeded).
pub(crate) fn book(
    mut account: ResMut<EnergyAccount>,
    motion: Res<Motion>,
    (densities, pressures): (Res<Densities>, Res<Pressures>),
    (equation, continuity): (Option<Res<EquationOfState>>, Option<Res<Continuity>>),
    material: Res<Material>,
) {
    let account = &mut *account;
    account.before = account.booked;
    let at_end = motion.kinetic_energy + motion.potential_energy;
    account.booked.taken += account.at_start - at_end;
    let rest_density = f64::from(material.rest_density);
    let sum: Option<f64> = if let Some(equation) = equation {
        let energy = |rho: &f32| equation.energy((*rho).into(), rest_density);
        Some(densities.0.iter().map(energy).sum())
    } else {
        continuity.map(|continuity| {
            let energy = |p: &f32| continuity.energy((*p).into(), rest_density);
            pressures.0.iter().map(energy).sum()
        })
    };
    if let Some(sum) = sum {
        let now = f64::from(material.particle_mass) * sum;
        let first = account.booked.compression.map_or(now, |(first, _)| first);
        account.booked.compression = Some((first, now));
    }
}
