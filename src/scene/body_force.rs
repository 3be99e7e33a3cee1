//! Forces on all fluid beside gravity: towards a point, from a table over time, or waves.

use std::path::Path;

use glam::{DVec3, Vec3};
use serde::{Deserialize, Serialize};

use super::ForceWave;
use crate::measure::{Column, Columns, CurveError, shortest_half_period};

/// An acceleration of the fluid beside gravity. Several add up.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub enum BodyForce {
    /// Towards a point.
    Central(CentralForce),
    /// The same everywhere, from a table over time.
    Table(AccelerationFile),
    /// A wave in space and time.
    Wave(ForceWave),
}

/// Acceleration towards a point, `−(linear r + constant) e_r` at the distance r.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct CentralForce {
    /// The point \[m].
    #[cfg_attr(feature = "schema", schemars(with = "[f32; 3]"))]
    pub center: Vec3,
    /// Part that grows with the distance \[1/s²]: the square of the angular frequency of a drop as a whole.
    #[serde(default)]
    pub linear: f32,
    /// Part that is the same everywhere \[m/s²].
    #[serde(default)]
    pub constant: f32,
}

/// A CSV file of accelerations over time: a line of names, a column `t` or `time` of ascending times \[s], and any of
/// the columns `ax`, `ay` and `az` \[m/s²], in any order.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct AccelerationFile {
    /// The file, relative to the scene file's folder (after [`load`](super::Scene::load): to the working directory).
    /// Between its times accelerations are linear; before the first and after the last they stay as they are there.
    pub file: String,
}

impl CentralForce {
    /// Acceleration at a point \[m/s²]; zero at the centre.
    #[inline]
    pub fn acceleration(&self, point: Vec3) -> Vec3 {
        let arm = self.center - point;
        self.linear * arm + self.constant * arm.normalize_or_zero()
    }

    /// Potential energy of a mass of 1 at a point, zero at the centre \[m²/s²].
    #[inline]
    pub fn potential(&self, point: Vec3) -> f32 {
        let distance = self.center.distance(point);
        (0.5 * self.linear * distance + self.constant) * distance
    }
}

/// Names of an acceleration's columns.
const COLUMNS: [&str; 3] = ["ax", "ay", "az"];

/// Part of a table's range that is taken for noise of an instrument.
const NOISE: f64 = 0.05;

/// Accelerations over time.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct AccelerationTable {
    /// Times \[s], accelerations \[m/s²], and their integral since the first time \[m/s].
    rows: Vec<(f64, DVec3, DVec3)>,
}

impl AccelerationTable {
    /// Reads a file; a column that it does not have is zero.
    pub fn load(file: &Path) -> Result<Self, CurveError> {
        let [x, y, z] = COLUMNS.map(Column::optional);
        let columns = Columns::load(file, [Column::time(), x, y, z])?.ascending(file)?;
        if columns.present == [true, false, false, false] {
            // None of them: refused for the first.
            Columns::load(file, [Column::time(), Column::named(COLUMNS[0])])?;
        }
        let row = |(_, [t, x, y, z]): (usize, [f64; 4])| (t, DVec3::new(x, y, z), DVec3::ZERO);
        let mut rows: Vec<_> = columns.rows.into_iter().map(row).collect();
        for k in 1..rows.len() {
            let (before, now) = (rows[k - 1], rows[k]);
            rows[k].2 = before.2 + 0.5 * (now.0 - before.0) * (before.1 + now.1);
        }
        Ok(Self { rows })
    }

    /// Its integral from the first time on \[m/s].
    fn integral(&self, time: f64) -> DVec3 {
        let after = self.rows.partition_point(|row| row.0 <= time);
        let (Some(&first), Some(&last)) = (self.rows.first(), self.rows.last()) else {
            return DVec3::ZERO;
        };
        let Some(&before) = after.checked_sub(1).and_then(|k| self.rows.get(k)) else {
            return (time - first.0) * first.1;
        };
        let Some(&next) = self.rows.get(after) else {
            return last.2 + (time - last.0) * last.1;
        };
        let dt = time - before.0;
        let slope = (next.1 - before.1) / (next.0 - before.0);
        before.2 + dt * before.1 + 0.5 * dt * dt * slope
    }

    /// Mean acceleration from a time on over a step \[s]: what it changes velocities by does not depend on the steps.
    pub fn mean(&self, time: f64, dt: f64) -> DVec3 {
        (self.integral(time + dt) - self.integral(time)) / dt
    }

    /// Shortest time between two rows \[s]; infinite with one.
    pub(crate) fn shortest_interval(&self) -> f64 {
        let intervals = self.rows.windows(2).map(|pair| pair[1].0 - pair[0].0);
        intervals.fold(f64::INFINITY, f64::min)
    }

    /// Shortest period of an oscillation \[s] that moves the fluid by more than `least` \[m] there and back. Of one
    /// with the amplitude A and half the period τ that is 2 A τ²/π².
    pub(crate) fn shortest_period(&self, least: f64) -> Option<f64> {
        let of_axis = |axis: usize| {
            let figures = || self.rows.iter().map(move |row| (row.0, row.1[axis]));
            let (low, high) = figures()
                .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), (_, a)| {
                    (low.min(a), high.max(a))
                });
            let half = shortest_half_period(figures(), NOISE * (high - low))?;
            let way = (high - low) * (half / std::f64::consts::PI).powi(2);
            (way > least).then_some(2.0 * half)
        };
        (0..3).filter_map(of_axis).reduce(f64::min)
    }

    /// Its times and accelerations, row by row.
    pub(crate) fn figures(&self) -> impl Iterator<Item = f64> {
        let of = |row: &(f64, DVec3, DVec3)| [row.0, row.1.x, row.1.y, row.1.z];
        self.rows.iter().flat_map(of)
    }

    /// Whether it has an acceleration along z.
    pub(crate) fn leaves_the_plane(&self) -> bool {
        self.rows.iter().any(|row| row.1.z != 0.0)
    }

    /// Largest acceleration \[m/s²].
    pub fn greatest(&self) -> f64 {
        let lengths = self.rows.iter().map(|row| row.1.length());
        lengths.fold(0.0, f64::max)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::measure::Curve;

    fn table(text: &str) -> Result<AccelerationTable, CurveError> {
        let folder = tempfile::tempdir().expect("a folder");
        let file = folder.path().join("shake.csv");
        std::fs::write(&file, text).expect("a file");
        AccelerationTable::load(&file)
    }

    /// Against the integral in small steps; steps of any length come to the same velocity.
    #[test]
    fn a_table_changes_velocities_by_its_integral() {
        let table = table("t,ay,ax\n0,0,1\n1,2,0\n3,-2,4\n").expect("a table");
        assert_eq!(table.greatest(), 20_f64.sqrt());
        let at = |time: f64| {
            let x = [(0.0, 1.0), (1.0, 0.0), (3.0, 4.0)];
            let y = [(0.0, 0.0), (1.0, 2.0), (3.0, -2.0)];
            let linear = |points: [(f64, f64); 3]| {
                let points = points.to_vec();
                let curve = Curve {
                    points,
                    notes: Vec::new(),
                };
                curve.at(time.clamp(0.0, 3.0)).expect("a value")
            };
            DVec3::new(linear(x), linear(y), 0.0)
        };
        for (from, to) in [
            (-1.0, 0.5),
            (0.2, 0.9),
            (0.5, 2.5),
            (0.0, 3.0),
            (2.0, 4.0),
            (5.0, 6.0),
        ] {
            let count = 10_000;
            let dt = (to - from) / f64::from(count);
            let fine = (0..count).map(|k| dt * at(from + (f64::from(k) + 0.5) * dt));
            let fine: DVec3 = fine.sum();
            let found = (to - from) * table.mean(from, to - from);
            assert!(
                found.distance(fine) < 1e-6,
                "{from} to {to}: {found}, not {fine}"
            );
        }
    }

    #[test]
    fn columns_may_be_in_any_order() {
        let tables = ["t,ax,ay\n0,1,2\n3,4,5\n", "ay,time,ax\n2,0,1\n5,3,4\n"];
        let [a, b] = tables.map(|text| table(text).expect("a table"));
        assert_eq!(a, b);
    }

    #[test]
    fn a_table_without_accelerations_is_refused() {
        for (text, expected) in [
            ("t\n0\n", "there is no column `ax`; the columns are t"),
            (
                "t,x\n0,1\n",
                "shake.csv:1: unknown column `x` (columns: t, ax (optional), ay (optional), az (optional))",
            ),
            (
                "ax,ay\n0,1\n",
                "there is no column `t`; the columns are ax, ay",
            ),
            (
                "t,ax,AY\n0,1,2\n",
                "unknown column `AY`; did you mean `ay`?",
            ),
            (
                "t,ax,ax\n0,1,2\n",
                "the column `ax` is there twice, as column 2 and 3",
            ),
            (
                "t,ax,time\n0,1,2\n",
                "the column `t` and `time` is there twice",
            ),
            (
                "t,ax\n0,a\n",
                "shake.csv:2: `a` in column `ax` is not a number",
            ),
            ("t,ax\n0,nan\n", "shake.csv:2: `nan`"),
            (
                "t,ax\n0,1\n2,1\n1,1\n",
                "shake.csv:4: the time 1 s comes after 2 s",
            ),
            (
                "t,ax\n0,1\n0,2\n",
                "shake.csv:3: the time 0 s comes after 0 s",
            ),
        ] {
            let error = table(text).expect_err("refused").to_string();
            assert!(error.contains(expected), "{error}");
        }
    }

    #[test]
    fn a_central_force_is_the_gradient_of_its_potential() {
        let force = CentralForce {
            center: Vec3::new(1.0, 0.0, -1.0),
            linear: 3.0,
            constant: 0.5,
        };
        let x = Vec3::new(0.2, 0.7, 0.1);
        for axis in [Vec3::X, Vec3::Y, Vec3::Z] {
            let slope =
                (force.potential(x + 1e-2 * axis) - force.potential(x - 1e-2 * axis)) / 2e-2;
            assert!((slope + force.acceleration(x).dot(axis)).abs() < 1e-3);
        }
        assert_eq!(force.acceleration(force.center), Vec3::ZERO);
    }
}
