//! Forces on the fluid as a whole beside gravity: towards a point, from tables over time, and waves.
//!
//! The acceleration of tables and waves is their mean over the step, so velocities change by the integral
//! whatever the steps are.

use bevy_ecs::prelude::*;
use glam::Vec3;

use crate::state::{
    Accelerations, BodyForces, Clock, Execution, PART_OF_PERIOD, Phase, Positions, Product, Stage,
};

/// Forces beside gravity.
pub(crate) const STAGE: Stage = Stage {
    needs: &[Product::Columns, Product::Forces],
    wanted: |scene| !scene.body_forces.is_empty(),
    limits: |scene| {
        let period = scene.shortest_period_of_forces();
        vec![("the period of body forces", PART_OF_PERIOD * period)]
    },
    ..Stage::new("body_forces", Phase::Forces, |_| {
        apply_body_forces.into_configs()
    })
};

/// Adds the forces beside gravity (phase `Forces`).
pub fn apply_body_forces(
    mut accelerations: ResMut<Accelerations>,
    positions: Res<Positions>,
    forces: Res<BodyForces>,
    clock: Res<Clock>,
    execution: Res<Execution>,
) {
    let means = forces
        .tables
        .iter()
        .map(|table| table.mean(clock.time, clock.dt.into()).as_vec3());
    let everywhere: Vec3 = means.sum();
    execution.for_each_chunk(&mut accelerations.0, |first, chunk| {
        for (acceleration, x) in chunk.iter_mut().zip(&positions.0[first..]) {
            let central = forces.central.iter();
            let central: Vec3 = central.map(|force| force.acceleration(x.truncate())).sum();
            let mut all = everywhere + central;
            for wave in &forces.waves {
                all += wave.mean(x.truncate(), clock.time, clock.dt.into());
            }
            *acceleration += all;
        }
    });
}
