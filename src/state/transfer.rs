//! State from the tables into columns at the start of a step, and back at its end.
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
    pairs::PairSlopes,
    state::Densities,
    state::Positions,
    state::PredictedPositions,
    state::Pressures,
    state::Rows,
    state::SENTINEL,
    state::TOO_LARGE,
    state::Velocities,
    state::{
        CHUNK, Execution, Failure, FailureCause,
        particle::{Density, Fluid, MeanPressure, ParticleId, Position, Pressure, Velocity},
    },
};

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
