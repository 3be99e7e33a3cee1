//! Integration by the semi-implicit Euler scheme, `v += dt a`, `x += dt v`, and the failure guard.
//!
//! Both work on the columns; the tables take the new state only if the guard finds nothing, so they always hold the
//! last good one.

mod budget;
mod chunks;

use bevy_ecs::prelude::*;
use glam::Vec4;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

pub(crate) use budget::EnergyBudget;
use budget::{StepWork, Work};

use crate::{
    boundary::sums::{BoundarySums, Walls},
    scene::{Bounds, Limits},
    state::{
        Accelerations, BodyForces, CHUNK, ChunkResults, Clock, Densities, Displacements, Execution,
        Failure, FailureCause, Material, Positions, PredictedPositions, PressureAccelerations,
        Pressures, Remembers, SolverState, Velocities,
    },
};

/// What the particles did in the last step.
#[derive(Resource, Debug, Default)]
pub struct Motion {
    /// Largest speed \[m/s].
    pub(crate) max_speed: f32,
    /// Largest acceleration, pressure included \[m/s²].
    pub(crate) max_acceleration: f32,
    /// Largest pressure \[Pa].
    pub(crate) max_pressure: f32,
    /// Kinetic energy \[J; J/m in 2-D].
    pub(crate) kinetic_energy: f64,
    /// Potential energy in the scene's gravity, zero at the origin, and in its central forces, zero at their centres
    /// \[J; J/m in 2-D]. Gravity along a periodic axis has none.
    pub(crate) potential_energy: f64,
    /// Work per mass that emitters do in the step, by keeping the speed of their particles \[m²/s²].
    pub(crate) given: f64,
    /// Largest pressure of the step before \[Pa].
    pressure_before: f32,
    budget: EnergyBudget,
    rows: usize,
    chunks: ChunkResults<ChunkMotion>,
    end: ChunkResults<ChunkEnd>,
}

/// The next step's length follows from it, and so do the limits of a step that fails before it moves.
impl Remembers for Motion {
    type State = ([f32; 4], [f64; 2], EnergyBudget);

    fn state(&self, _: &[Entity]) -> Self::State {
        let largest = [
            self.max_speed,
            self.max_acceleration,
            self.max_pressure,
            self.pressure_before,
        ];
        let energies = [self.kinetic_energy, self.potential_energy];
        (largest, energies, self.budget)
    }

    fn set_state(&mut self, state: Self::State, _: &[Entity]) -> Result<(), &'static str> {
        [
            self.max_speed,
            self.max_acceleration,
            self.max_pressure,
            self.pressure_before,
        ] = state.0;
        [self.kinetic_energy, self.potential_energy] = state.1;
        self.budget = state.2;
        Ok(())
    }
}

/// The part of the space that particles may not leave, if the scene has one.
#[derive(Resource, Debug, Clone, Copy)]
pub struct Domain(pub(crate) Bounds);

/// Limits of the failure guard.
#[derive(Resource, Debug, Clone, Copy)]
pub struct GuardLimits(pub(crate) Limits);

/// Motion of one chunk of rows. Squares, and sums in f64: millions of terms lose no digits.
#[derive(Debug, Clone, Copy, Default, Serialize, Deserialize)]
struct ChunkMotion {
    speed_squared: (f32, usize),
    acceleration_squared: f32,
    pressure: f32,
    compression: (f32, usize),
    /// The place in [`QUANTITIES`], and the row.
    not_finite: Option<(u8, usize)>,
    work: Work,
}

/// What has to be finite.
const QUANTITIES: [&str; 3] = ["velocity", "position", "density"];

/// Where one chunk of rows ended up.
#[derive(Debug, Clone, Copy, Default, Serialize, Deserialize)]
struct ChunkEnd {
    speed_squared_sum: f64,
    height_sum: f64,
    /// Lowest and highest potential \[m²/s²], negative.
    heights: Option<(f32, f32)>,
    outside: Option<usize>,
}

/// Moves every particle (phase `Integrate`).
pub fn integrate(
    mut predicted: ResMut<PredictedPositions>,
    mut velocities: ResMut<Velocities>,
    mut motion: ResMut<Motion>,
    columns: (Res<Positions>, Res<Densities>, Res<Pressures>),
    forces: (Res<Accelerations>, Res<PressureAccelerations>),
    (material, walls): (Res<Material>, Option<Res<BoundarySums>>),
    displacements: Option<Res<Displacements>>,
    clock: Res<Clock>,
    execution: Res<Execution>,
) {
    let (positions, densities, pressures) = columns;
    let walls = Walls::of(walls.as_deref());
    let moving = walls.are_moving();
    let (accelerations, pressure_accelerations) = forces;
    let (dt, rest_density) = (clock.dt, material.rest_density);
    let owned = execution.owned(positions.rows());
    let motion = &mut *motion;
    motion.pressure_before = motion.max_pressure;
    motion.rows = execution.all(positions.rows());
    let chunks = motion.chunks.reset(owned.len());
    let advance = |first: usize, new_x: &mut [Vec4], v: &mut [Vec4]| {
        let first = owned.start + first;
        let mut result = ChunkMotion::default();
        let state = new_x.iter_mut().zip(&positions.0[first..]).zip(v);
        let forces = accelerations.0[first..]
            .iter()
            .zip(&pressure_accelerations.0[first..]);
        for (row, ((((new_x, x), v), (a, a_p)), &rho)) in
            (first..).zip(state.zip(forces).zip(&densities.0[first..]))
        {
            result.pressure = result.pressure.max(pressures.0[row]);
            let acceleration = *a + *a_p;
            let velocity = v.truncate() + dt * acceleration;
            let mut position = x.truncate() + dt * velocity;
            if let Some(displacements) = &displacements {
                position += displacements.0[row];
            }
            let before = v.truncate();
            let change = dt * *a;
            let gain = velocity.length_squared() - before.length_squared();
            let of_forces = change.dot(before + velocity);
            result.work.add(Work {
                speed_squared: f64::from(before.length_squared()),
                pressure: 0.5 * f64::from(gain - of_forces),
                forces: 0.5 * f64::from(of_forces),
                change_squared: f64::from(change.length_squared()),
                // The force on the row, −ρ0 p/ρ² Σ V_b ∇W, by the velocities of the walls.
                walls: if moving {
                    let term = pressures.0[row] / (rho * rho);
                    -f64::from(dt * rest_density * term * walls.flux(row))
                } else {
                    0.0
                },
            });
            *v = velocity.extend(v.w);
            *new_x = position.extend(0.0);
            if result.not_finite.is_none() {
                let finite = [velocity.is_finite(), position.is_finite(), rho.is_finite()];
                let found = finite.iter().position(|finite| !finite);
                result.not_finite = found.map(|quantity| (quantity as u8, row));
            }
            let speed_squared = velocity.length_squared();
            if speed_squared > result.speed_squared.0 {
                result.speed_squared = (speed_squared, row);
            }
            let compression = rho / rest_density - 1.0;
            if compression > result.compression.0 {
                result.compression = (compression, row);
            }
            result.acceleration_squared = result
                .acceleration_squared
                .max(acceleration.length_squared());
        }
        result
    };
    let columns = (
        &mut predicted.0[owned.clone()],
        &mut velocities.0[owned.clone()],
    );
    execution.map_chunks(columns, chunks, advance);
    execution.join(&mut motion.chunks);
    let total = motion.total();
    motion.max_speed = total.speed_squared.0.sqrt();
    motion.max_acceleration = total.acceleration_squared.sqrt();
    motion.max_pressure = total.pressure;
}

/// Measures energies, and who left the domain, after walls have corrected the motion (phase `Integrate`).
pub fn measure(
    predicted: Res<PredictedPositions>,
    velocities: Res<Velocities>,
    mut motion: ResMut<Motion>,
    positions: Res<Positions>,
    domain: Option<Res<Domain>>,
    (material, body_forces): (Res<Material>, Option<Res<BodyForces>>),
    execution: Res<Execution>,
) {
    let bounds = domain.map(|domain| domain.0);
    let gravity = material.gravity_with_potential();
    let owned = execution.owned(positions.rows());
    let columns = (predicted.0[owned.clone()].par_chunks(CHUNK))
        .zip(velocities.0[owned.clone()].par_chunks(CHUNK));
    let chunks = motion
        .end
        .reset(owned.len())
        .par_iter_mut()
        .zip(columns)
        .enumerate();
    execution.install(|| {
        chunks.for_each(|(chunk, (end, (positions, velocities)))| {
            let first = owned.start + chunk * CHUNK;
            for (row, (x, v)) in (first..).zip(positions.iter().zip(velocities)) {
                let position = x.truncate();
                end.speed_squared_sum += f64::from(v.truncate().length_squared());
                let mut height = gravity.dot(position);
                end.height_sum += f64::from(height);
                if let Some(forces) = &body_forces {
                    let potential = forces.potential(position);
                    end.height_sum -= f64::from(potential);
                    height -= potential;
                }
                let (low, high) = end.heights.unwrap_or((height, height));
                end.heights = Some((low.min(height), high.max(height)));
                if let Some(Bounds { min, max }) = bounds
                    && !(position.cmpge(min).all() && position.cmple(max).all())
                {
                    end.outside.get_or_insert(row);
                }
            }
        });
    });
    execution.join(&mut motion.end);
    let end = motion.end();
    let mass = f64::from(material.particle_mass);
    motion.kinetic_energy = 0.5 * mass * end.speed_squared_sum;
    motion.potential_energy = -mass * end.height_sum;
}

impl Motion {
    /// Largest speed \[m/s].
    pub fn max_speed(&self) -> f32 {
        self.max_speed
    }

    /// Largest acceleration, pressure included \[m/s²].
    pub fn max_acceleration(&self) -> f32 {
        self.max_acceleration
    }

    /// Kinetic energy \[J; J/m in 2-D].
    pub fn kinetic_energy(&self) -> f64 {
        self.kinetic_energy
    }

    /// Row of the fastest particle.
    pub fn fastest_row(&self) -> usize {
        self.total().speed_squared.1
    }

    /// The budget after the step.
    ///
    /// Fails with the work of pressure and its limit, for a mass of 1 each.
    fn spend(
        &self,
        material: &Material,
        clock: &Clock,
        limits: Limits,
        solve: &SolverState,
    ) -> Result<EnergyBudget, (f64, f64)> {
        let (total, end) = (self.total(), self.end());
        let step = StepWork {
            work: total.work,
            // Fluid at rest that a wall meets takes half of what the wall does at least.
            passed_on: total.work.walls.max(0.0) + self.given,
            kinetic: 0.5 * end.speed_squared_sum,
            is_elastic: solve.iterations() == 0,
            rows: self.rows as f64,
            dt: clock.dt,
            pressure: self.pressure_before,
            rest_density: material.rest_density,
            compression: total.compression.0,
            distance: material.kernel.support_radius,
            heights: end.heights.map_or(0.0, |(low, high)| f64::from(high - low)),
        };
        self.budget.after(&step, limits.energy.into())
    }

    /// All chunks, folded in their order.
    fn total(&self) -> ChunkMotion {
        let larger = |a: (f32, usize), b: (f32, usize)| if b.0 > a.0 { b } else { a };
        let add = |mut sum: Work, other: Work| {
            sum.add(other);
            sum
        };
        self.chunks
            .iter()
            .fold(ChunkMotion::default(), |sum, chunk| ChunkMotion {
                work: add(sum.work, chunk.work),
                speed_squared: larger(sum.speed_squared, chunk.speed_squared),
                acceleration_squared: sum.acceleration_squared.max(chunk.acceleration_squared),
                pressure: sum.pressure.max(chunk.pressure),
                compression: larger(sum.compression, chunk.compression),
                not_finite: sum.not_finite.or(chunk.not_finite),
            })
    }

    /// Likewise.
    fn end(&self) -> ChunkEnd {
        let chunks = self.end.iter();
        chunks.fold(ChunkEnd::default(), |sum, chunk| ChunkEnd {
            speed_squared_sum: sum.speed_squared_sum + chunk.speed_squared_sum,
            height_sum: sum.height_sum + chunk.height_sum,
            heights: match (sum.heights, chunk.heights) {
                (Some(a), Some(b)) => Some((a.0.min(b.0), a.1.max(b.1))),
                (a, b) => a.or(b),
            },
            outside: sum.outside.or(chunk.outside),
        })
    }
}

/// Keeps account of the energy that pressure gave (phase `Integrate`, if the step succeeded).
pub fn keep_account(
    mut motion: ResMut<Motion>,
    limits: Res<GuardLimits>,
    material: Res<Material>,
    clock: Res<Clock>,
    solve: Res<SolverState>,
) {
    if let Ok(budget) = motion.spend(&material, &clock, limits.0, &solve) {
        motion.budget = budget;
    }
}

/// Refuses a step that went wrong (phase `Integrate`).
pub fn guard(
    mut failure: ResMut<Failure>,
    motion: Res<Motion>,
    limits: Res<GuardLimits>,
    material: Res<Material>,
    clock: Res<Clock>,
    solve: Res<SolverState>,
) {
    let total = motion.total();
    if let Some((quantity, row)) = total.not_finite {
        let quantity = QUANTITIES[usize::from(quantity)];
        return failure.record(FailureCause::NotFinite { quantity }, Some(row));
    }
    // The paper's bound (4.3.2).
    let limit = 0.5 * material.kernel.support_radius;
    let displacement = clock.dt * motion.max_speed;
    if displacement > limit {
        return failure.record(
            FailureCause::TooFast {
                displacement,
                limit,
            },
            Some(total.speed_squared.1),
        );
    }
    let (compression, row) = total.compression;
    if let Err((work, limit)) = motion.spend(&material, &clock, limits.0, &solve) {
        let mass = f64::from(material.particle_mass);
        let cause = FailureCause::EnergyGained {
            work: mass * work,
            limit: mass * limit,
        };
        return failure.record(cause, Some(total.speed_squared.1));
    }
    let limit = limits.0.compression;
    if compression > limit {
        return failure.record(
            FailureCause::OverCompressed { compression, limit },
            Some(row),
        );
    }
    if let Some(row) = motion.end().outside {
        failure.record(FailureCause::LeftDomain, Some(row));
    }
}
