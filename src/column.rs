//! Columns of all fluid particles, indexed by row: what a step works on.
//!
//! A table of the ECS holds a column as it is spawned; the particles may lie in several tables. At the start of a step
//! [`gather_columns`] brings them together, at its end [`scatter_columns`] writes the state back. Between the two every
//! column is one slice, whatever the tables.
//!
//! Option 1: borrow the one table there usually is and copy only when there are several. Option 2: always copy, into
//! entries of four floats with a fourth that a neighbour loop wants beside the first three. We use 2: a neighbour is
//! then one load of 16 bytes that never crosses a cache line, and the copy costs 3 ns a particle; and one code serves
//! any number of tables. Gathers of 27 neighbours, ns a particle on one thread (`cargo bench --bench gathers`), from
//! arrays of `Vec3`, of these entries, and from a column a coordinate: positions alone 23 : 25 : 144, with the fourth,
//! as the pressure force wants it, 39 : 28 : 202; rows in no order 38 : 50 : 148 and 64 : 54 : 200.
//!
//! Coordinates are `f32` from the scene's origin: 10⁴ spacings away they are exact to 8e-4 of a spacing. Loops work
//! with differences of neighbours, cells are found in `f64`, sums over all particles are in `f64`. A column that
//! collapses there has the energy of one at the origin within 1 %, with every method; slow motion is lost where dt v is
//! less than half of that.

use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering::Relaxed};

use bevy_ecs::prelude::*;
use bytemuck::TransparentWrapper;
use glam::{Vec3, Vec4};
use rayon::prelude::*;
use smallvec::SmallVec;

use crate::{
    execution::{CHUNK, Execution},
    pairs::PairSlopes,
    particle::{Density, Fluid, MeanPressure, ParticleId, Position, Pressure, Velocity},
    step::{Failure, FailureCause},
};

/// Position of the entry behind the last row: so far away that every kernel is zero there. Lanes of a neighbour loop
/// that have no neighbour read it.
pub const SENTINEL: Vec4 = Vec4::new(1e18, 1e18, 1e18, 0.0);

/// Coordinates [m] and components of velocities [m/s] from which a step refuses a particle: squares overflow at 1e19,
/// and
/// [`SENTINEL`] must be further away than any particle.
pub(crate) const TOO_LARGE: f32 = 1e17;

/// Who is in which row: the entities, in the order in which [`gather_columns`] met them last.
#[derive(Resource, Debug, Clone, Default)]
pub struct Rows {
    /// The entity of every row.
    pub entities: Vec<Entity>,
    /// Whether rows named other particles before. What earlier steps left behind by row is of no use then.
    pub changed: bool,
}

/// Positions [m]; the fourth entry is the pressure term `p/ρ²` of the pressure force. A sentinel ends them.
#[derive(Resource, Debug, Clone)]
pub struct Positions(pub Vec<Vec4>);

/// Velocities [m/s]; the fourth entry is the density [kg/m³] where viscosity wants it. A sentinel of zero
/// ends them.
#[derive(Resource, Debug, Clone)]
pub struct Velocities(pub Vec<Vec4>);

/// Densities [kg/m³; kg/m² in 2-D].
#[derive(Resource, Debug, Clone, Default)]
pub struct Densities(pub Vec<f32>);

/// Pressures [Pa].
#[derive(Resource, Debug, Clone, Default)]
pub struct Pressures(pub Vec<f32>);

/// Accelerations by all forces but pressure [m/s²].
#[derive(Resource, Debug, Clone, Default)]
pub struct Accelerations(pub Vec<Vec3>);

/// Accelerations by pressure [m/s²].
#[derive(Resource, Debug, Clone, Default)]
pub struct PressureAccelerations(pub Vec<Vec3>);

/// Positions at the end of the step [m], while it is not certain that the step is good. A sentinel ends them.
#[derive(Resource, Debug, Clone)]
pub struct PredictedPositions(pub Vec<Vec4>);

impl Default for PredictedPositions {
    fn default() -> Self {
        Self(vec![SENTINEL])
    }
}

impl Default for Positions {
    fn default() -> Self {
        Self(vec![SENTINEL])
    }
}

impl Positions {
    /// The positions without the sentinel.
    pub fn points(&self) -> &[Vec4] {
        &self.0[..self.0.len() - 1]
    }

    /// Number of fluid particles.
    pub fn rows(&self) -> usize {
        self.0.len() - 1
    }
}

impl Default for Velocities {
    fn default() -> Self {
        Self(vec![Vec4::ZERO])
    }
}

/// Tables in one order for all queries. Bevy goes through new tables in the order of a hash map: a query that saw them
/// in one go (its system skipped a failed step) has another order than one that saw them in two.
pub(crate) fn in_order<T>(
    tables: impl IntoIterator<Item = T>,
    entities: impl Fn(&T) -> &[Entity],
) -> impl Iterator<Item = T> {
    // Room for the tables of most hosts without an allocation.
    let mut tables: SmallVec<[T; 4]> = tables.into_iter().collect();
    tables.sort_unstable_by_key(|table| entities(table).first().copied());
    tables.into_iter()
}

/// State of the fluid as the tables hold it.
type State = (
    Entity,
    &'static mut Position,
    &'static mut Velocity,
    &'static mut Density,
    &'static mut Pressure,
);

/// Whether the particles of a table have what every fluid particle has.
type Present = (
    Entity,
    Has<Position>,
    Has<Velocity>,
    Has<Density>,
    Has<Pressure>,
    Has<ParticleId>,
);

/// Refuses a step of particles that lack a component (phase `RebuildIndex`): they would take no part in it.
pub fn check_components(
    fluid: Query<Present, With<Fluid>>,
    places: Query<&Position>,
    mut failure: ResMut<Failure>,
) {
    let tables = fluid.contiguous_iter().into_iter().flatten();
    for (entities, x, v, rho, p, id) in in_order(tables, |table| table.0) {
        let components = [
            ("Position", x),
            ("Velocity", v),
            ("Density", rho),
            ("Pressure", p),
            ("ParticleId", id),
        ];
        if let Some((component, _)) = components.iter().find(|(_, present)| !present) {
            let at = places.get(entities[0]).map_or(Vec3::NAN, |x| x.0);
            let particles = entities.len();
            failure.record_of(
                FailureCause::LacksComponent {
                    component,
                    particles,
                },
                (entities[0], at),
            );
            return;
        }
    }
}

/// What [`gather_columns`] reads.
type Gathered = (
    Entity,
    &'static Position,
    &'static Velocity,
    &'static Density,
    &'static Pressure,
    Option<&'static MeanPressure>,
);

/// The first row whose particle a host gave a value that is no use, and which one that is.
#[derive(Default)]
struct Unusable {
    /// Rows from 1; 0 if there is none, by quantity.
    rows: [AtomicUsize; 3],
}

const QUANTITIES: [&str; 3] = ["position", "velocity", "pressure"];

impl Unusable {
    fn note(&self, quantity: usize, row: usize) {
        let first = |known: usize| (known == 0 || row < known - 1).then_some(row + 1);
        let _ = self.rows[quantity].fetch_update(Relaxed, Relaxed, first);
    }

    fn first(&self) -> Option<(&'static str, usize)> {
        let rows = QUANTITIES.iter().zip(&self.rows);
        let found = rows.filter_map(|(name, row)| Some((*name, row.load(Relaxed).checked_sub(1)?)));
        found.min_by_key(|found| found.1)
    }
}

/// Brings the columns of all tables together (phase `RebuildIndex`). A value that is not finite, or too large to be
/// squared, fails the step here, where its own particle is known: later its neighbours have it, too.
pub fn gather_columns(
    fluid: Query<Gathered, With<Fluid>>,
    (mut rows_of, mut failure): (ResMut<Rows>, ResMut<Failure>),
    mut positions: ResMut<Positions>,
    mut predicted: ResMut<PredictedPositions>,
    mut velocities: ResMut<Velocities>,
    mut pressures: ResMut<Pressures>,
    slopes: Option<ResMut<PairSlopes>>,
    execution: Res<Execution>,
) {
    if let Some(mut slopes) = slopes {
        slopes.forget();
    }
    let tables = || fluid.contiguous_iter().into_iter().flatten();
    let rows: usize = tables().map(|(entities, ..)| entities.len()).sum();
    let unusable = Unusable::default();
    let rows_of = &mut *rows_of;
    let changed = AtomicBool::new(rows_of.entities.len() != rows);
    rows_of.entities.resize(rows, Entity::PLACEHOLDER);
    positions.0.resize(rows + 1, SENTINEL);
    velocities.0.resize(rows + 1, Vec4::ZERO);
    positions.0[rows] = SENTINEL;
    velocities.0[rows] = Vec4::ZERO;
    predicted.0.resize(rows + 1, SENTINEL);
    predicted.0[rows] = SENTINEL;
    pressures.0.resize(rows, 0.0);
    let mut first = 0;
    for (entities, x, v, _, p, means) in in_order(tables(), |table| table.0) {
        let rows = first..first + x.len();
        let base = first;
        execution.for_each_chunk(&mut rows_of.entities[rows.clone()], |first, rows| {
            let entities = &entities[first..first + rows.len()];
            if rows != entities {
                changed.store(true, Relaxed);
                rows.copy_from_slice(entities);
            }
        });
        let pack = |packed: &mut [Vec4], column: &[Vec3], quantity: usize| {
            execution.for_each_chunk(packed, |first, packed| {
                for (row, (packed, value)) in packed.iter_mut().zip(&column[first..]).enumerate() {
                    *packed = value.extend(0.0);
                    // A value that is not a number is not below either.
                    if !value.abs().cmplt(Vec3::splat(TOO_LARGE)).all() {
                        unusable.note(quantity, base + first + row);
                    }
                }
            });
        };
        pack(&mut positions.0[rows.clone()], Position::peel_slice(x), 0);
        pack(&mut velocities.0[rows.clone()], Velocity::peel_slice(v), 1);
        let finite = |column: &[f32]| {
            let bad = |chunk: &[f32]| chunk.iter().position(|value| !value.is_finite());
            let chunks = column.par_chunks(CHUNK).enumerate();
            let found = chunks.filter_map(|(k, chunk)| Some(k * CHUNK + bad(chunk)?));
            if let Some(row) = execution.install(|| found.min()) {
                unusable.note(2, base + row);
            }
        };
        finite(Pressure::peel_slice(p));
        if let Some(means) = means {
            finite(MeanPressure::peel_slice(means));
        }
        execution.copy(&mut pressures.0[rows.clone()], Pressure::peel_slice(p));
        first = rows.end;
    }
    rows_of.changed = changed.into_inner();
    if let Some((quantity, row)) = unusable.first() {
        let x = [positions.0[row], velocities.0[row]];
        let is_large = quantity != "pressure" && x.iter().all(|x| x.is_finite());
        let cause = if is_large {
            FailureCause::TooLarge { quantity }
        } else {
            FailureCause::NotFinite { quantity }
        };
        failure.record(cause, Some(row));
    }
}

/// Refuses a step in which particles came, went or changed tables since they were gathered (phase `Integrate`): their
/// new state would be written to others.
pub fn check_rows(
    fluid: Query<State, With<Fluid>>,
    rows: Res<Rows>,
    mut failure: ResMut<Failure>,
    execution: Res<Execution>,
) {
    let mut first = 0;
    let mut same = true;
    let tables = fluid.contiguous_iter().into_iter().flatten();
    for (entities, ..) in in_order(tables, |table| table.0) {
        let known = rows.entities.get(first..first + entities.len());
        same &= known.is_some_and(|known| {
            let chunks = known.par_chunks(CHUNK).zip(entities.par_chunks(CHUNK));
            execution.install(|| chunks.all(|(known, present)| known == present))
        });
        first += entities.len();
    }
    if !same || first != rows.entities.len() {
        let (before, now) = (rows.entities.len(), first);
        failure.record(FailureCause::ParticlesChanged { before, now }, None);
    }
}

/// Writes the state of the step into the tables and marks it as changed (phase `Integrate`).
pub fn scatter_columns(
    mut fluid: Query<State, With<Fluid>>,
    positions: Res<PredictedPositions>,
    velocities: Res<Velocities>,
    densities: Res<Densities>,
    pressures: Res<Pressures>,
    execution: Res<Execution>,
) {
    let mut first = 0;
    let tables = fluid.contiguous_iter_mut().into_iter().flatten();
    for (_, mut x, mut v, mut rho, mut p) in in_order(tables, |table| table.0) {
        // One `deref_mut` a column: it marks all its rows.
        let (x, v): (&mut [Position], &mut [Velocity]) = (&mut x, &mut v);
        let rows = first..first + x.len();
        let unpack = |column: &mut [Vec3], packed: &[Vec4]| {
            execution.for_each_chunk(column, |first, column| {
                for (value, packed) in column.iter_mut().zip(&packed[first..]) {
                    *value = packed.truncate();
                }
            });
        };
        unpack(Position::peel_slice_mut(x), &positions.0[rows.clone()]);
        unpack(Velocity::peel_slice_mut(v), &velocities.0[rows.clone()]);
        execution.copy(
            Density::peel_slice_mut(&mut rho),
            &densities.0[rows.clone()],
        );
        execution.copy(Pressure::peel_slice_mut(&mut p), &pressures.0[rows.clone()]);
        first = rows.end;
    }
}
