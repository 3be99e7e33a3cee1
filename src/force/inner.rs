//! Forces that are summed more than once in a step: in sub-steps of it, or in every iteration of the pressure solve.
//!
//! A sub-step of n changes velocities by `dt/n (a0 + a(v))`, where a0 is what acted before. Positions stay, and the
//! mean of the a(v) acts in the step. Within the pressure solve, forces see `v + dt (a + a_p)` of the last iteration: a
//! viscosity that does not change any more is implicit. Both restore the velocities that the step started with.

use bevy_ecs::prelude::*;
use glam::{Vec3, Vec4};

use crate::state::{
    Accelerations, Clock, Execution, Positions, PressureAccelerations, SolverState, Systems,
    Velocities,
};

/// What such forces start from.
#[derive(Resource, Debug, Default)]
pub(crate) struct InnerForces {
    /// Velocities \[m/s].
    velocities: Vec<Vec4>,
    /// Accelerations by the forces before \[m/s²].
    base: Vec<Vec3>,
    /// Sum of the shares of the sub-steps \[m/s²].
    sum: Vec<Vec3>,
}

/// Systems before the first sub-step.
pub(crate) fn begin() -> Systems {
    (keep_base, keep_velocities, clear_sum).chain()
}

/// Before every sub-step.
pub(crate) fn start() -> Systems {
    clear.into_configs()
}

/// After every one of so many sub-steps.
pub(crate) fn advance(times: u32) -> Systems {
    let share = 1.0 / times as f32;
    let advance = move |mut inner: ResMut<InnerForces>,
                        mut velocities: ResMut<Velocities>,
                        accelerations: Res<Accelerations>,
                        clock: Res<Clock>,
                        execution: Res<Execution>| {
        let InnerForces { base, sum, .. } = &mut *inner;
        let rows = sum.len();
        let dt = share * clock.dt;
        let columns = (&mut velocities.0[..rows], &mut sum[..]);
        let mut none = vec![(); rows.div_ceil(crate::state::CHUNK)];
        execution.map_chunks(columns, &mut none, |first, velocities, sum| {
            let forces = accelerations.0[first..].iter().zip(&base[first..]);
            for ((v, sum), (a, base)) in velocities.iter_mut().zip(sum).zip(forces) {
                *sum += share * *a;
                *v += (dt * (*base + *a)).extend(0.0);
            }
        });
    };
    advance.into_configs()
}

/// After the last sub-step.
pub(crate) fn end() -> Systems {
    (take_sum, add_base, restore_velocities).chain()
}

/// Before the pressure solve.
pub(crate) fn before_pressure() -> Systems {
    keep_base.into_configs()
}

/// Before the forces of an iteration.
pub(crate) fn begin_iteration() -> Systems {
    (keep_velocities, predict, clear).chain()
}

/// After them.
pub(crate) fn end_iteration() -> Systems {
    (add_base, restore_velocities).chain()
}

fn keep_base(
    mut inner: ResMut<InnerForces>,
    mut accelerations: ResMut<Accelerations>,
    positions: Res<Positions>,
) {
    // A host's stage may have added forces before any other.
    accelerations.0.resize(positions.rows(), Vec3::ZERO);
    inner.base.clone_from(&accelerations.0);
}

fn keep_velocities(mut inner: ResMut<InnerForces>, velocities: Res<Velocities>) {
    inner.velocities.clone_from(&velocities.0);
}

fn clear_sum(mut inner: ResMut<InnerForces>) {
    let rows = inner.base.len();
    inner.sum.clear();
    inner.sum.resize(rows, Vec3::ZERO);
}

fn clear(mut accelerations: ResMut<Accelerations>, execution: Res<Execution>) {
    execution.for_each_chunk(&mut accelerations.0, |_, chunk| chunk.fill(Vec3::ZERO));
}

fn take_sum(
    inner: Res<InnerForces>,
    mut accelerations: ResMut<Accelerations>,
    execution: Res<Execution>,
) {
    execution.copy(&mut accelerations.0, &inner.sum);
}

fn add_base(
    inner: Res<InnerForces>,
    mut accelerations: ResMut<Accelerations>,
    execution: Res<Execution>,
) {
    execution.for_each_chunk(&mut accelerations.0, |first, accelerations| {
        for (a, base) in accelerations.iter_mut().zip(&inner.base[first..]) {
            *a += *base;
        }
    });
}

fn restore_velocities(inner: Res<InnerForces>, mut velocities: ResMut<Velocities>) {
    velocities.0.clone_from(&inner.velocities);
}

/// Velocities at the end of the step as the last iteration predicts them; none did before the first.
fn predict(
    mut velocities: ResMut<Velocities>,
    accelerations: Res<Accelerations>,
    by_pressure: Res<PressureAccelerations>,
    solve: Res<SolverState>,
    clock: Res<Clock>,
    execution: Res<Execution>,
) {
    let rows = accelerations.0.len();
    if solve.iterations == 0 || by_pressure.0.len() != rows {
        return;
    }
    let dt = clock.dt;
    execution.for_each_chunk(&mut velocities.0[..rows], |first, velocities| {
        let forces = accelerations.0[first..].iter().zip(&by_pressure.0[first..]);
        for (v, (a, a_p)) in velocities.iter_mut().zip(forces) {
            *v += (dt * (*a + *a_p)).extend(0.0);
        }
    });
}
