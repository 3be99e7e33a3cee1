//! Columns of all fluid particles, indexed by row: what the systems of a step work on.
//!
//! Tables of the ECS hold the particles as they were spawned, in one table or in several. The columns of the state are
//! copied into rows at the start of a step and back at its end; in between every column is one slice. Why they are
//! packed copies of four floats stands in `docs/decisions/columns.md`.
//!
//! Coordinates are `f32` from the scene's origin: 10⁴ spacings away they are exact to 8e-4 of a spacing. Loops work
//! with differences of neighbours, cells are found in `f64`, sums over all particles are in `f64`. A column that
//! collapses there has the energy of one at the origin within 1 %, with every method; slow motion is lost where dt v is
//! less than half of that.

use std::ops::Range;

use bevy_ecs::prelude::*;
use glam::{Vec3, Vec4};
use rayon::prelude::*;

use super::{
    column::Column,
    execution::{CHUNK, Execution},
    particle::{Density, MeanPressure, Position, Pressure, Velocity},
    state_column::{GatheredColumn, StateColumn},
};

/// Position of the entry behind the last row: so far away that every kernel is zero there. Lanes of a neighbour loop
/// that have no neighbour read it.
pub const SENTINEL: Vec4 = Vec4::new(1e18, 1e18, 1e18, 0.0);

/// Coordinates \[m] and components of velocities \[m/s] from which a step refuses a particle: squares overflow at 1e19,
/// and
/// [`SENTINEL`] must be further away than any particle.
pub(crate) const TOO_LARGE: f32 = 1e17;

/// Positions \[m]; the fourth entry is the pressure term `p/ρ²` of the pressure force. A host reads them as a slice and
/// cannot write them:
///
/// ```compile_fail
/// # use bevy_ecs::prelude::*;
/// # use overfall::step::Positions;
/// fn move_particles(mut positions: ResMut<Positions>) {
///     positions[0].x += 1.0;
/// }
/// ```
#[derive(Resource, Debug)]
pub struct Positions(pub(crate) Vec<Vec4>);

/// Velocities \[m/s]; the fourth entry is the density \[kg/m³] where viscosity wants it. A sentinel of zero
/// ends them.
#[derive(Resource, Debug)]
pub struct Velocities(pub(crate) Vec<Vec4>);

/// Densities \[kg/m³; kg/m² in 2-D].
#[derive(Resource, Debug)]
pub struct Densities(pub(crate) Vec<f32>);

/// Pressures \[Pa].
#[derive(Resource, Debug)]
pub struct Pressures(pub(crate) Vec<f32>);

/// Accelerations by all forces but pressure \[m/s²].
#[derive(Resource, Debug)]
pub struct Accelerations(pub(crate) Vec<Vec3>);

/// Accelerations by pressure \[m/s²].
#[derive(Resource, Debug)]
pub struct PressureAccelerations(pub(crate) Vec<Vec3>);

/// Displacements of the step beside those by velocities \[m]. With methods that shift particles.
#[derive(Resource, Debug)]
pub struct Displacements(pub(crate) Vec<Vec3>);

/// Positions at the end of the step \[m], while it is not certain that the step is good. A sentinel ends them.
#[derive(Resource, Debug)]
pub struct PredictedPositions(pub(crate) Vec<Vec4>);

impl Positions {
    /// The positions without the sentinel.
    pub fn points(&self) -> &[Vec4] {
        &self.0[..self.rows()]
    }

    /// Number of fluid particles.
    pub fn rows(&self) -> usize {
        self.0.len().saturating_sub(1)
    }
}

/// Means of the pressures over the steps before \[Pa]. In scenes whose steps start from them.
#[derive(Resource, Debug)]
pub struct MeanPressures {
    /// Weight 1/n of a step.
    pub(crate) weight: f32,
    /// By row.
    pub(crate) means: Vec<f32>,
}

/// Columns that every scene has.
pub const COLUMNS: &[Column] = &[
    Column::lasting::<Position>("position", "m", "where a particle is", 16).gathered::<Position>(),
    Column::lasting::<Velocity>("velocity", "m/s", "how fast it moves", 16).gathered::<Velocity>(),
    Column::lasting::<Density>("density", "kg/m^3", "paper eq. 1; kg/m^2 in 2-D", 4),
    Column::lasting::<Pressure>("pressure", "Pa", "of the last step", 4).gathered::<Pressure>(),
    Column::derived("predicted position", "m", "at the end of the step", 16),
    Column::derived("acceleration", "m/s^2", "by all forces but pressure", 12),
    Column::derived("pressure acceleration", "m/s^2", "by pressure", 12),
];

/// Copies vectors into packed rows, and finds the first that is not below [`TOO_LARGE`]; true if it is finite.
fn pack(
    packed: &mut [Vec4],
    values: &[Vec3],
    first: usize,
    on: &Execution,
) -> Option<(usize, bool)> {
    // A value that is not a number is not below either.
    let usable = |value: &Vec3| value.abs().cmplt(Vec3::splat(TOO_LARGE)).all();
    let chunks = packed.par_chunks_mut(CHUNK).zip(values.par_chunks(CHUNK));
    let copied = chunks.enumerate().filter_map(|(chunk, (packed, values))| {
        let mut found = None;
        for (row, (packed, value)) in (first + chunk * CHUNK..).zip(packed.iter_mut().zip(values)) {
            *packed = value.extend(0.0);
            if found.is_none() && !usable(value) {
                found = Some((row, value.is_finite()));
            }
        }
        found
    });
    on.install(|| copied.min_by_key(|found| found.0))
}

/// Copies packed rows into vectors.
fn unpack(packed: &[Vec4], values: &mut [Vec3], on: &Execution) {
    on.for_each_chunk(values, |first, values| {
        for (value, packed) in values.iter_mut().zip(&packed[first..]) {
            *value = packed.truncate();
        }
    });
}

/// The first value that is not below [`TOO_LARGE`]; true if it is finite. A solve that starts from it would throw the
/// particles around.
fn unusable(values: &[f32], first: usize, on: &Execution) -> Option<(usize, bool)> {
    let usable = |value: &f32| value.abs() < TOO_LARGE;
    let bad = |chunk: &[f32]| chunk.iter().position(|value| !usable(value));
    let chunks = values.par_chunks(CHUNK).enumerate();
    let found = chunks.filter_map(|(chunk, values)| Some(chunk * CHUNK + bad(values)?));
    let row = on.install(|| found.min())?;
    Some((first + row, values[row].is_finite()))
}

impl StateColumn for Position {
    type Value = Vec3;
    type Result = PredictedPositions;
    const COMPONENT: &'static str = "Position";

    fn scatter(result: &PredictedPositions, rows: Range<usize>, out: &mut [Vec3], on: &Execution) {
        unpack(&result.0[rows], out, on);
    }
}

impl GatheredColumn for Position {
    type Start = Positions;
    const QUANTITY: &'static str = "position";

    fn resize(start: &mut Positions, rows: usize) {
        start.0.resize(rows + 1, SENTINEL);
        start.0[rows] = SENTINEL;
    }

    fn gather(
        start: &mut Positions,
        first: usize,
        values: &[Vec3],
        on: &Execution,
    ) -> Option<(usize, bool)> {
        pack(&mut start.0[first..first + values.len()], values, first, on)
    }

    fn share(start: &mut Positions, on: &Execution) {
        on.share(&mut start.0);
    }
}

impl StateColumn for Velocity {
    type Value = Vec3;
    type Result = Velocities;
    const COMPONENT: &'static str = "Velocity";

    fn scatter(result: &Velocities, rows: Range<usize>, out: &mut [Vec3], on: &Execution) {
        unpack(&result.0[rows], out, on);
    }
}

impl GatheredColumn for Velocity {
    type Start = Velocities;
    const QUANTITY: &'static str = "velocity";

    fn resize(start: &mut Velocities, rows: usize) {
        start.0.resize(rows + 1, Vec4::ZERO);
        start.0[rows] = Vec4::ZERO;
    }

    fn gather(
        start: &mut Velocities,
        first: usize,
        values: &[Vec3],
        on: &Execution,
    ) -> Option<(usize, bool)> {
        pack(&mut start.0[first..first + values.len()], values, first, on)
    }

    fn share(start: &mut Velocities, on: &Execution) {
        on.share(&mut start.0);
    }
}

impl StateColumn for Density {
    type Value = f32;
    type Result = Densities;
    const COMPONENT: &'static str = "Density";

    fn scatter(result: &Densities, rows: Range<usize>, out: &mut [f32], on: &Execution) {
        on.copy(out, &result.0[rows]);
    }
}

impl StateColumn for Pressure {
    type Value = f32;
    type Result = Pressures;
    const COMPONENT: &'static str = "Pressure";

    fn scatter(result: &Pressures, rows: Range<usize>, out: &mut [f32], on: &Execution) {
        on.copy(out, &result.0[rows]);
    }
}

impl GatheredColumn for Pressure {
    type Start = Pressures;
    const QUANTITY: &'static str = "pressure";

    fn resize(start: &mut Pressures, rows: usize) {
        start.0.resize(rows, 0.0);
    }

    fn gather(
        start: &mut Pressures,
        first: usize,
        values: &[f32],
        on: &Execution,
    ) -> Option<(usize, bool)> {
        on.copy(&mut start.0[first..first + values.len()], values);
        unusable(values, first, on)
    }

    fn share(start: &mut Pressures, on: &Execution) {
        on.share(&mut start.0);
    }
}

impl StateColumn for MeanPressure {
    type Value = f32;
    type Result = MeanPressures;
    const COMPONENT: &'static str = "MeanPressure";

    fn scatter(result: &MeanPressures, rows: Range<usize>, out: &mut [f32], on: &Execution) {
        on.copy(out, &result.means[rows]);
    }

    fn stand_in(pressures: &[f32]) -> Option<&[f32]> {
        Some(pressures)
    }
}

impl GatheredColumn for MeanPressure {
    type Start = MeanPressures;
    const QUANTITY: &'static str = "mean pressure";

    fn resize(start: &mut MeanPressures, rows: usize) {
        start.means.resize(rows, 0.0);
    }

    fn gather(
        start: &mut MeanPressures,
        first: usize,
        values: &[f32],
        on: &Execution,
    ) -> Option<(usize, bool)> {
        on.copy(&mut start.means[first..first + values.len()], values);
        unusable(values, first, on)
    }

    fn share(start: &mut MeanPressures, on: &Execution) {
        on.share(&mut start.means);
    }
}
