//! Force and torque of the fluid on named boundaries: the reaction to the forces of their samples on the fluid.
//!
//! Walls lose the momentum that the fluid gains in up to four ways. Pressure: a sample b receives `m_i ρ0 t_i V_b
//! ∇W_ib` times `push` from particle i, with t the sum of the pressure terms of all solves in the step. Along walls:
//! the fluid's own force is completed for the part of the kernel that the wall cuts off
//! ([`made_up`](crate::boundary::sums::Walls::made_up)), distributed over the samples by their weights. Contact:
//! changes of velocity by [`contact`](crate::boundary::contact) or direct forcing come from the nearest sample. And
//! [`friction`](crate::boundary::friction), at walls that are not free-slip.
//!
//! In every step with a reading this takes one more pass over the pressure forces.

use glam::{DVec3, Vec3, Vec4};
use rayon::prelude::*;

use super::{
    moment::{Moment, Probe},
    near::Near,
    reactions::Reactions,
};
use crate::{
    boundary::{owners::Owners, sums::Walls},
    index::BoundarySamples,
};

/// Force and torque on the boundaries with a name.
pub(super) struct Force {
    /// Numbers of these boundaries in the scene.
    pub(super) boundaries: Vec<u32>,
    pub(super) about: Vec3,
}

/// Samples per task: fixed, so that sums do not depend on the number of threads.
const CHUNK: usize = 64;

impl Probe for Force {
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
                let x = material
                    .period
                    .nearest(fluid.points[row].truncate() - place);
                let share = walls.share(row);
                let part = if share > 0.0 {
                    volume * kernel.value(x.length()) / share
                } else {
                    0.0
                };
                let pressure = material.rest_density * reactions.terms[row] * push * volume;
                let taken = pressure * kernel.gradient(x) - part * reactions.added[row];
                on_sample += taken.as_dvec3();
                if let Some(friction) = &state.friction {
                    let sample = sample as usize;
                    let normal = samples.normals[sample];
                    let taken = friction.acceleration(row, sample, (x, volume, normal), kernel);
                    on_sample -= taken.as_dvec3();
                }
            }
            on_sample *= mass;
            force += on_sample;
            torque += (place - self.about).as_dvec3().cross(on_sample);
        }
        (force, torque)
    }

    /// The reaction of the nearest sample to a change of a particle's velocity.
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
            slack: 0.0,
        };
        let reach = moment.reach(state.material.kernel.support_radius);
        let per_second = f64::from(state.material.particle_mass) / f64::from(state.clock.dt);
        let (mut force, mut torque) = (DVec3::ZERO, DVec3::ZERO);
        let mut near = Vec::new();
        for row in reactions.touched.iter().map(|&row| row as usize) {
            let x = moment.fluid().points[row].truncate();
            walls.rows_in(x - reach, x + reach, &mut near);
            let distance = |sample: &u32| {
                let offset = walls.points[*sample as usize].truncate() - x;
                state.material.period.nearest(offset).length()
            };
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
