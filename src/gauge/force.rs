//! Force and torque of the fluid on named boundaries: the reaction to what their samples do to the fluid.
//!
//! Three things act between walls and fluid, and the momentum that the fluid gets from them is what the walls lose.
//! Pressure: a sample b takes `m_i ρ0 t_i V_b ∇W_ib` times the walls' push from particle i, t the pressure terms of all
//! solves of the step together. Beside walls the fluid's own force along the wall is made up for what the wall leaves
//! out of the kernel ([`made_up`](crate::boundary::sums::Walls::made_up)); that comes from the wall, from its samples by
//! their part in the particle's kernel. And contact: what [`contact`](crate::boundary::contact) or direct forcing changed
//! a velocity by comes from the nearest sample. No viscosity acts between walls and fluid.
//!
//! The pressure force on all particles is summed once more for it, with those terms: a pass in every step that is read.

use bevy_ecs::prelude::*;
use glam::{DVec3, Vec3, Vec4};
use rayon::prelude::*;

use super::{Moment, Probe, Quantity, State, mean_of, near::Near};
use crate::{
    boundary::{BoundarySamples, owners::Owners, sums::Walls},
    column::{Positions, Velocities},
    execution::Execution,
    pressure::force::PressureForce,
};

/// Velocities before walls correct them [m/s]. In scenes that measure forces.
#[derive(Resource, Debug, Default)]
pub struct FreeVelocities(Vec<Vec4>);

/// Keeps the velocities that integration gave (phase `Integrate`, before contact).
pub fn keep_velocities(
    mut kept: ResMut<FreeVelocities>,
    velocities: Res<Velocities>,
    positions: Res<Positions>,
    execution: Res<Execution>,
) {
    let rows = positions.rows();
    kept.0.resize(rows, Vec4::ZERO);
    execution.copy(&mut kept.0, &velocities.0[..rows]);
}

/// What walls do to each row in the step.
pub(super) struct Reactions {
    /// Pressure term of all solves, `p/ρ²`.
    terms: Vec<f32>,
    /// Acceleration along the wall that was made up [m/s²].
    added: Vec<Vec3>,
    /// Rows that contact changed.
    touched: Vec<u32>,
}

impl Reactions {
    pub(super) fn new(state: &State) -> Self {
        let rows = state.places_len();
        let positions = &state.pairs.positions().0;
        let terms: Vec<f32> = if state.equation.is_some() {
            // What pressure acts with there is not what it is told as.
            positions[..rows].iter().map(|x| x.w).collect()
        } else {
            let pressures = state.pressures.0.iter().zip(&state.densities.0);
            pressures.map(|(p, rho)| p / (rho * rho)).collect()
        };
        let walls = Walls::of(state.walls.as_deref());
        let mut carried = positions.clone();
        for (x, term) in carried.iter_mut().zip(&terms) {
            x.w = *term;
        }
        let mut added = vec![Vec3::ZERO; rows];
        let pass = PressureForce::new(&state.material, walls);
        state.pairs.sum_at(&carried, &pass, &mut added);
        state.execution.for_each_chunk(&mut added, |first, added| {
            for (row, acceleration) in (first..).zip(added) {
                *acceleration = walls.added(row, *acceleration);
            }
        });
        let free = state.free.as_ref().map_or(&[][..], |free| &free.0);
        let changed = free.iter().zip(&state.velocities.0);
        let touched = (0..)
            .zip(changed)
            .filter(|(_, (before, after))| before.truncate() != after.truncate())
            .map(|(row, _)| row)
            .collect();
        Self {
            terms,
            added,
            touched,
        }
    }
}

/// Force and torque on the boundaries of a name.
pub(super) struct Force {
    /// Their numbers in the scene.
    pub(super) boundaries: Vec<u32>,
    pub(super) about: Vec3,
}

/// Samples that one task works on: fixed, so that sums do not depend on the number of threads.
const CHUNK: usize = 64;

impl Probe for Force {
    fn quantities(&self) -> &'static [Quantity] {
        const {
            &[
                mean_of("force_x_N"),
                mean_of("force_y_N"),
                mean_of("force_z_N"),
                mean_of("torque_x_N_m"),
                mean_of("torque_y_N_m"),
                mean_of("torque_z_N_m"),
            ]
        }
    }

    fn read(&self, moment: &Moment, _: &mut Vec<u32>, values: &mut Vec<Option<f64>>) {
        let state = moment.state;
        let (Some(samples), Some(owners)) = (&state.samples, &state.owners) else {
            values.extend([Some(0.0); 6]);
            return;
        };
        let is_ours = |owner: &u32| self.boundaries.contains(owner);
        let ours: Vec<u32> = (0..)
            .zip(&owners.0)
            .filter(|(_, owner)| is_ours(owner))
            .map(|(sample, _)| sample)
            .collect();
        let reactions = moment.reactions();
        let parts: Vec<(DVec3, DVec3)> = state.execution.install(|| {
            let chunks = ours.par_chunks(CHUNK);
            let sum = |chunk: &[u32]| self.on_samples(chunk, samples, moment, reactions);
            chunks.map(sum).collect()
        });
        let contact = self.by_contact(samples, owners, moment, reactions);
        let (force, torque) = parts
            .into_iter()
            .fold(contact, |sum, part| (sum.0 + part.0, sum.1 + part.1));
        values.extend(force.to_array().map(Some));
        values.extend(torque.to_array().map(Some));
    }
}

impl Force {
    fn on_samples(
        &self,
        chunk: &[u32],
        samples: &BoundarySamples,
        moment: &Moment,
        reactions: &Reactions,
    ) -> (DVec3, DVec3) {
        let state = moment.state;
        let walls = Walls::of(state.walls.as_deref());
        let push = state.walls.as_ref().map_or(1.0, |walls| walls.push());
        let material = &state.material;
        let kernel = &material.kernel;
        let fluid = moment.fluid();
        let reach = moment.reach(kernel.support_radius);
        let mass = f64::from(material.particle_mass);
        let (mut force, mut torque) = (DVec3::ZERO, DVec3::ZERO);
        let mut rows = Vec::new();
        for &sample in chunk {
            let (place, volume) = (
                samples.packed[sample as usize],
                samples.packed[sample as usize].w,
            );
            let place = place.truncate();
            fluid.rows_in(place - reach, place + reach, &mut rows);
            let mut on_sample = DVec3::ZERO;
            for row in rows.iter().map(|&row| row as usize) {
                let x = fluid.points[row].truncate() - place;
                let share = walls.share(row);
                let part = if share > 0.0 {
                    volume * kernel.value(x.length()) / share
                } else {
                    0.0
                };
                let pressure = material.rest_density * reactions.terms[row] * push * volume;
                let taken = pressure * kernel.gradient(x) - part * reactions.added[row];
                on_sample += taken.as_dvec3();
            }
            on_sample *= mass;
            force += on_sample;
            torque += (place - self.about).as_dvec3().cross(on_sample);
        }
        (force, torque)
    }

    /// What the nearest sample takes of a particle whose velocity was changed.
    fn by_contact(
        &self,
        samples: &BoundarySamples,
        owners: &Owners,
        moment: &Moment,
        reactions: &Reactions,
    ) -> (DVec3, DVec3) {
        let state = moment.state;
        let walls = Near {
            index: &*samples.index,
            points: samples.points(),
        };
        let reach = moment.reach(state.material.kernel.support_radius);
        let per_second = f64::from(state.material.particle_mass) / f64::from(state.clock.dt);
        let (mut force, mut torque) = (DVec3::ZERO, DVec3::ZERO);
        let mut near = Vec::new();
        for row in reactions.touched.iter().map(|&row| row as usize) {
            let x = moment.fluid().points[row].truncate();
            walls.rows_in(x - reach, x + reach, &mut near);
            let distance = |sample: &u32| walls.points[*sample as usize].truncate().distance(x);
            let nearest = near
                .iter()
                .min_by(|a, b| distance(a).total_cmp(&distance(b)));
            let owner = nearest.and_then(|&sample| owners.0.get(sample as usize));
            if owner.is_some_and(|owner| self.boundaries.contains(owner)) {
                let free = state.free.as_ref().map_or(Vec4::ZERO, |free| free.0[row]);
                let change = (state.velocities.0[row] - free).truncate().as_dvec3();
                let taken = -per_second * change;
                force += taken;
                torque += (x - self.about).as_dvec3().cross(taken);
            }
        }
        (force, torque)
    }
}
