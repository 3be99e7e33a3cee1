//! PCISPH (paper 5.2, Algorithm 2; Solenthaler & Pajarola 2009): pressures are corrected until the predicted density is
//! near the rest density.
//!
//! Each iteration is one run of [`PressureIteration`]: predict velocity and position with the forces so far; density at
//! the predicted positions, over the step's neighbour lists with updated distances; `p += δ (ρ* − ρ0)`, not below zero;
//! pressure force at the positions of the step. It ends when the density error is below η and three iterations are
//! done. `δ = 1/(β (|Σ_j ∇W_ij|² + Σ_j |∇W_ij|²))`, `β = 2 (m dt/ρ0)²`, for a particle of a full lattice.

use bevy_ecs::{prelude::*, schedule::ScheduleLabel};
use glam::Vec3;

use super::PressureSolve;
use crate::{
    column::{
        Accelerations, Positions, PredictedPositions, PressureAccelerations, Pressures, Velocities,
    },
    density::DensitySum,
    execution::Execution,
    material::Material,
    pairs::Pairs,
    scene::{Criterion, NotConverged, Pcisph},
    step::{Clock, Failure, FailureCause},
};

/// One iteration of the pressure loop. A chain of systems without anything to overlap: it runs on one thread, whose
/// overhead is 0.3 µs a run, and the loops inside are parallel.
#[derive(ScheduleLabel, Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct PressureIteration;

/// The scene's parameters, and `δ dt²` of its lattice.
#[derive(Resource, Debug, Clone, Copy)]
pub struct PressureCorrection {
    /// Parameters.
    pub parameters: Pcisph,
    /// `δ dt²` [Pa s²·m³/kg]: only dt changes δ.
    delta_dt_squared: f32,
}

impl PressureCorrection {
    /// The correction for a lattice of this material.
    pub fn new(parameters: Pcisph, material: &Material) -> Self {
        let gradients = || {
            let lattice = material
                .kernel
                .lattice(material.dimension, material.spacing);
            lattice.map(|x| material.kernel.gradient(x).as_dvec3())
        };
        let sum: glam::DVec3 = gradients().sum();
        let squares: f64 = gradients().map(|gradient| gradient.length_squared()).sum();
        let beta =
            2.0 * (f64::from(material.particle_mass) / f64::from(material.rest_density)).powi(2);
        Self {
            parameters,
            delta_dt_squared: (1.0 / (beta * (sum.length_squared() + squares))) as f32,
        }
    }
}

/// Densities at the predicted positions ρ* [kg/m³].
#[derive(Resource, Debug, Default)]
pub struct PredictedDensities(Vec<f32>);

/// The systems of [`PressureIteration`], in their order.
pub fn iteration() -> bevy_ecs::schedule::ScheduleConfigs<bevy_ecs::system::ScheduleSystem> {
    (
        predict_positions,
        predict_density,
        update_pressure,
        super::pressure_force,
    )
        .chain()
}

/// Inserts what the method needs.
pub fn install(world: &mut World, parameters: Pcisph, material: &Material) {
    world.insert_resource(PressureCorrection::new(parameters, material));
    world.init_resource::<PredictedDensities>();
}

/// Iterates until the density error is small enough (phase `Pressure`).
pub fn solve_pressure(world: &mut World) {
    start(world);
    let parameters = world.resource::<PressureCorrection>().parameters;
    let missed = world.schedule_scope(PressureIteration, |world, iteration| {
        loop {
            iteration.run(world);
            let mut solve = world.resource_mut::<PressureSolve>();
            solve.iterations += 1;
            let error = match parameters.criterion {
                Criterion::Largest => solve.error.largest,
                Criterion::Mean => solve.error.mean,
            };
            if error <= parameters.max_density_error
                && solve.iterations >= parameters.min_iterations
            {
                return None;
            }
            if solve.iterations >= parameters.max_iterations {
                return Some((error, solve.iterations, solve.error.row));
            }
        }
    });
    if let (Some((error, iterations, row)), NotConverged::Stop) = (missed, parameters.not_converged)
    {
        let limit = parameters.max_density_error;
        let cause = FailureCause::NotConverged {
            iterations,
            error,
            limit,
        };
        world.resource_mut::<Failure>().record(cause, Some(row));
    }
}

/// Pressures and their forces start at zero.
fn start(world: &mut World) {
    world.resource_mut::<PressureSolve>().iterations = 0;
    world.resource_mut::<Pressures>().0.fill(0.0);
    let rows = world.resource::<Positions>().rows();
    let mut forces = world.resource_mut::<PressureAccelerations>();
    forces.0.clear();
    forces.0.resize(rows, Vec3::ZERO);
}

fn predict_positions(
    mut predicted: ResMut<PredictedPositions>,
    positions: Res<Positions>,
    velocities: Res<Velocities>,
    accelerations: Res<Accelerations>,
    pressure_accelerations: Res<PressureAccelerations>,
    clock: Res<Clock>,
    execution: Res<Execution>,
) {
    let dt = clock.dt;
    let rows = positions.rows();
    execution.for_each_chunk(&mut predicted.0[..rows], |first, predicted| {
        let state = positions.0[first..].iter().zip(&velocities.0[first..]);
        let forces = accelerations.0[first..]
            .iter()
            .zip(&pressure_accelerations.0[first..]);
        for ((predicted, (x, v)), (a, a_p)) in predicted.iter_mut().zip(state).zip(forces) {
            let velocity = v.truncate() + dt * (*a + *a_p);
            *predicted = (x.truncate() + dt * velocity).extend(0.0);
        }
    });
}

fn predict_density(
    mut densities: ResMut<PredictedDensities>,
    predicted: Res<PredictedPositions>,
    pairs: Pairs,
    material: Res<Material>,
) {
    densities.0.resize(pairs.positions().rows(), 0.0);
    pairs.sum(
        &DensitySum::new(&material, &predicted.0, pairs.boundary_samples()),
        &mut densities.0,
    );
}

fn update_pressure(
    mut pressures: ResMut<Pressures>,
    mut positions: ResMut<Positions>,
    mut solve: ResMut<PressureSolve>,
    predicted: Res<PredictedDensities>,
    correction: Res<PressureCorrection>,
    material: Res<Material>,
    clock: Res<Clock>,
    execution: Res<Execution>,
) {
    let rest_density = material.rest_density;
    let delta = correction.delta_dt_squared / (clock.dt * clock.dt);
    let inverse = 1.0 / (rest_density * rest_density);
    solve.update(
        &predicted.0,
        &mut pressures,
        &mut positions,
        rest_density,
        &execution,
        |rho, pressure| {
            let pressure = (pressure + delta * (rho - rest_density)).max(0.0);
            (pressure, pressure * inverse)
        },
    );
}
