//! Integration by the semi-implicit Euler scheme, `v += dt a`, `x += dt v`, and the failure guard.
//!
//! Both work on the columns; the tables take the new state only if the guard finds nothing, so they always hold the
//! last good one.

use bevy_ecs::prelude::*;
use glam::Vec4;
use rayon::prelude::*;

use crate::{
    boundary::sums::{BoundarySums, Walls},
    scene::{Bounds, Limits},
    state::{
        Accelerations, BodyForces, CHUNK, ChunkResults, Clock, Densities, Displacements, Execution,
        Failure, FailureCause, Material, Positions, PredictedPositions, PressureAccelerations,
        Pressures, Remembers, Velocities,
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
    rows: usize,
    chunks: ChunkResults<ChunkMotion>,
    end: ChunkResults<ChunkEnd>,
}

/// The next step's length follows from it, and so do the limits of a step that fails before it moves.
impl Remembers for Motion {
    type State = ([f32; 4], [f64; 2]);

    fn state(&self, _: &[Entity]) -> Self::State {
        let largest = [
            self.max_speed,
            self.max_acceleration,
            self.max_pressure,
            self.pressure_before,
        ];
        (largest, [self.kinetic_energy, self.potential_energy])
    }

    fn set_state(&mut self, state: Self::State, _: &[Entity]) -> Result<(), &'static str> {
        [
            self.max_speed,
            self.max_acceleration,
            self.max_pressure,
            self.pressure_before,
        ] = state.0;
        [self.kinetic_energy, self.potential_energy] = state.1;
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
#[derive(Debug, Clone, Copy, Default)]
struct ChunkMotion {
    speed_squared: (f32, usize),
    acceleration_squared: f32,
    pressure: f32,
    compression: (f32, usize),
    not_finite: Option<(&'static str, usize)>,
    work: Work,
}

/// Sums over particles, for a mass of 1 each.
#[derive(Debug, Clone, Copy, Default)]
struct Work {
    /// Squares of the speeds at the start \[m²/s²].
    speed_squared: f64,
    /// Gain of half of them, less the work of all forces but pressure: the work of pressure \[m²/s²].
    pressure: f64,
    /// Squares of what those forces change velocities by \[m²/s²].
    change_squared: f64,
    /// Work of the pressure of walls that move \[m²/s²].
    walls: f64,
}

impl Work {
    fn add(&mut self, other: Self) {
        self.speed_squared += other.speed_squared;
        self.pressure += other.pressure;
        self.change_squared += other.change_squared;
        self.walls += other.walls;
    }
}

/// Where one chunk of rows ended up.
#[derive(Debug, Clone, Copy, Default)]
struct ChunkEnd {
    speed_squared_sum: f64,
    height_sum: f64,
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
    let rows = positions.rows();
    let motion = &mut *motion;
    (motion.pressure_before, motion.rows) = (motion.max_pressure, rows);
    let chunks = motion.chunks.reset(rows);
    let advance = |first: usize, new_x: &mut [Vec4], v: &mut [Vec4]| {
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
            result.work.add(Work {
                speed_squared: f64::from(before.length_squared()),
                pressure: 0.5 * f64::from(gain - change.dot(before + velocity)),
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
                let quantities = [
                    ("velocity", velocity.is_finite()),
                    ("position", position.is_finite()),
                    ("density", rho.is_finite()),
                ];
                result.not_finite = quantities
                    .iter()
                    .find(|(_, finite)| !finite)
                    .map(|(name, _)| (*name, row));
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
    let columns = (&mut predicted.0[..rows], &mut velocities.0[..rows]);
    execution.map_chunks(columns, chunks, advance);
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
    let rows = positions.rows();
    let columns =
        (predicted.0[..rows].par_chunks(CHUNK)).zip(velocities.0[..rows].par_chunks(CHUNK));
    let chunks = motion
        .end
        .reset(rows)
        .par_iter_mut()
        .zip(columns)
        .enumerate();
    execution.install(|| {
        chunks.for_each(|(chunk, (end, (positions, velocities)))| {
            for (row, (x, v)) in (chunk * CHUNK..).zip(positions.iter().zip(velocities)) {
                let position = x.truncate();
                end.speed_squared_sum += f64::from(v.truncate().length_squared());
                end.height_sum += f64::from(gravity.dot(position));
                if let Some(forces) = &body_forces {
                    end.height_sum -= f64::from(forces.potential(position));
                }
                if let Some(Bounds { min, max }) = bounds
                    && !(position.cmpge(min).all() && position.cmple(max).all())
                {
                    end.outside.get_or_insert(row);
                }
            }
        });
    });
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
            outside: sum.outside.or(chunk.outside),
        })
    }
}

/// Refuses a step that went wrong (phase `Integrate`).
pub fn guard(
    mut failure: ResMut<Failure>,
    motion: Res<Motion>,
    limits: Res<GuardLimits>,
    material: Res<Material>,
    clock: Res<Clock>,
) {
    let total = motion.total();
    if let Some((quantity, row)) = total.not_finite {
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
    // What pressure may do work with: motion, the pressure of the last step, compression that is pushed out, and what
    // other forces drive together, and the work of walls that move and of emitters. A host that moves particles between
    // steps does none.
    let (compression, row) = total.compression;
    let pushed = f64::from(compression * material.kernel.support_radius / clock.dt);
    let before = f64::from(motion.pressure_before / material.rest_density);
    let rows = motion.rows as f64;
    let available = 0.5
        * (total.work.speed_squared + total.work.change_squared + rows * pushed.powi(2))
        + rows * before;
    // Pressure may pass on all that walls and emitters do: fluid at rest that a wall meets takes half of it at least.
    let passed_on = total.work.walls.max(0.0) + motion.given;
    let limit = f64::from(limits.0.energy) * available + passed_on;
    if total.work.pressure > limit {
        let mass = f64::from(material.particle_mass);
        let cause = FailureCause::EnergyGained {
            work: mass * total.work.pressure,
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
