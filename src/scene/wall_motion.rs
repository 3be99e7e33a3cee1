//! Prescribed motion of a boundary: what the file says, and where that puts the boundary at a time.
//!
//! A boundary is at time 0 where its shape says. What a motion says of a place is the way from there.

use std::{f64::consts::TAU, path::Path};

use glam::{DQuat, DVec3, Vec3};
use serde::{Deserialize, Serialize};

use crate::measure::{Column, Columns, CurveError, shortest_half_period};

/// How a boundary moves.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub enum WallMotion {
    /// At a velocity, from a time to another: a piston, or a gate that opens.
    Velocity {
        /// \[m/s]
        #[cfg_attr(feature = "schema", schemars(with = "[f32; 3]"))]
        velocity: Vec3,
        /// When it sets off \[s].
        #[serde(default)]
        start: f32,
        /// When it stops \[s]; never if absent.
        #[serde(default)]
        end: Option<f32>,
    },
    /// Rotation about an axis, from a time to another.
    Rotation {
        /// A point of the axis \[m].
        #[cfg_attr(feature = "schema", schemars(with = "[f32; 3]"))]
        center: Vec3,
        /// Along the axis \[rad/s]; in 2-D along z.
        #[cfg_attr(feature = "schema", schemars(with = "[f32; 3]"))]
        angular_velocity: Vec3,
        /// When it sets off \[s].
        #[serde(default)]
        start: f32,
        /// When it stops \[s]; never if absent.
        #[serde(default)]
        end: Option<f32>,
    },
    /// There and back, `amplitude (sin(2π frequency t + phase) − sin(phase))`.
    Oscillation {
        /// Half the way from end to end \[m].
        #[cfg_attr(feature = "schema", schemars(with = "[f32; 3]"))]
        amplitude: Vec3,
        /// \[Hz]
        frequency: f32,
        /// \[rad]
        #[serde(default)]
        phase: f32,
    },
    /// Along a direction, from a table over time.
    Table {
        /// A CSV file, relative to the scene file's folder (after [`load`](super::Scene::load): to the working
        /// directory): a line of names, and in any order a column `t` or `time` of ascending times \[s], one `x`
        /// \[m] and, if known, one `v` \[m/s]. Without `v` the wall moves at a constant speed from row to row, with it
        /// along cubics that have these speeds (Hermite). It counts from where the table is at time 0; before its first
        /// and after its last time it rests.
        file: String,
        /// Direction of x; any length but zero.
        #[cfg_attr(feature = "schema", schemars(with = "[f32; 3]"))]
        direction: Vec3,
    },
}

impl WallMotion {
    /// The file of its table.
    pub(crate) fn file_mut(&mut self) -> Option<&mut String> {
        match self {
            Self::Table { file, .. } => Some(file),
            _ => None,
        }
    }
}

/// Where a wall is that started from its shape.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct WallPose {
    rotation: DQuat,
    center: DVec3,
    displacement: DVec3,
}

impl WallPose {
    /// Where a point of the shape is \[m].
    #[inline]
    pub fn place(&self, point: Vec3) -> DVec3 {
        self.center + self.displacement + self.turned(point.as_dvec3() - self.center)
    }

    /// Where a direction of the shape points to.
    pub fn turn(&self, direction: Vec3) -> Vec3 {
        self.turned(direction.as_dvec3()).as_vec3()
    }

    /// Most walls do not turn: to turn every sample by nothing costs as much as to find it.
    fn turned(&self, arm: DVec3) -> DVec3 {
        if self.rotation == DQuat::IDENTITY {
            return arm;
        }
        self.rotation * arm
    }
}

/// The motion of a wall with its table read.
#[derive(Debug, Clone, PartialEq)]
pub struct WallCourse {
    motion: WallMotion,
    table: Option<MotionTable>,
}

impl WallCourse {
    /// Reads the table of a motion, if it has one.
    pub fn new(motion: &WallMotion) -> Result<Self, CurveError> {
        let table = match motion {
            WallMotion::Table { file, .. } => Some(MotionTable::load(Path::new(file))?),
            _ => None,
        };
        let motion = motion.clone();
        Ok(Self { motion, table })
    }

    /// The figures of its table.
    pub(crate) fn figures(&self) -> impl Iterator<Item = f64> {
        self.table.iter().flat_map(MotionTable::figures)
    }

    /// Where the wall is at a time \[s].
    pub fn pose(&self, time: f64) -> WallPose {
        // A wall that stood until now, or stands from now on, is where it was then.
        let moved = |start: f32, end: Option<f32>| {
            let start = f64::from(start);
            let end = end.map_or(f64::INFINITY, f64::from);
            time.min(end).max(start) - start
        };
        let shifted = |displacement: DVec3| WallPose {
            rotation: DQuat::IDENTITY,
            center: DVec3::ZERO,
            displacement,
        };
        match self.motion {
            WallMotion::Velocity {
                velocity,
                start,
                end,
            } => shifted(moved(start, end) * velocity.as_dvec3()),
            WallMotion::Rotation {
                center,
                angular_velocity,
                start,
                end,
            } => WallPose {
                rotation: DQuat::from_scaled_axis(moved(start, end) * angular_velocity.as_dvec3()),
                center: center.as_dvec3(),
                displacement: DVec3::ZERO,
            },
            WallMotion::Oscillation {
                amplitude,
                frequency,
                phase,
            } => {
                let phase = f64::from(phase);
                let now = (TAU * f64::from(frequency) * time + phase).sin();
                shifted((now - phase.sin()) * amplitude.as_dvec3())
            }
            WallMotion::Table { direction, .. } => {
                let way = self.table.as_ref().map_or(0.0, |table| table.way(time));
                shifted(way * direction.as_dvec3().normalize_or_zero())
            }
        }
    }
}

/// Points of a cubic between two rows at which its reversals are looked for.
const PARTS: u32 = 8;

/// Where a wall is along a line, and how fast, over time.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct MotionTable {
    /// Times \[s], places \[m] and speeds \[m/s].
    rows: Vec<[f64; 3]>,
    /// Whether speeds are known.
    has_speeds: bool,
}

impl MotionTable {
    /// Reads a file with the columns `x` and, perhaps, `v`.
    pub fn load(file: &Path) -> Result<Self, CurveError> {
        let columns = [Column::time(), Column::named("x"), Column::optional("v")];
        let columns = Columns::load(file, columns)?.ascending(file)?;
        Ok(Self {
            has_speeds: columns.present[2],
            rows: columns.rows.into_iter().map(|(_, row)| row).collect(),
        })
    }

    /// Place at a time \[m].
    fn at(&self, time: f64) -> f64 {
        let after = self.rows.partition_point(|row| row[0] <= time);
        let before = after.checked_sub(1).and_then(|k| self.rows.get(k));
        match (before, self.rows.get(after)) {
            (None, None) => 0.0,
            (Some(row), None) | (None, Some(row)) => row[1],
            (Some(&[t0, x0, v0]), Some(&[t1, x1, v1])) => {
                let length = t1 - t0;
                let s = (time - t0) / length;
                if !self.has_speeds {
                    return x0 + s * (x1 - x0);
                }
                let (rest, turn) = (1.0 - s, s * (1.0 - s));
                let places = x0 * rest * rest * (1.0 + 2.0 * s) + x1 * s * s * (3.0 - 2.0 * s);
                places + length * turn * (v0 * rest - v1 * s)
            }
        }
    }

    /// Way since time 0 \[m].
    pub fn way(&self, time: f64) -> f64 {
        self.at(time) - self.at(0.0)
    }

    /// Times of its rows \[s].
    pub(crate) fn times(&self) -> impl Iterator<Item = f64> {
        self.rows.iter().map(|row| row[0])
    }

    /// Whether its place changes.
    pub(crate) fn moves(&self) -> bool {
        let is_other = |row: &[f64; 3]| row[1] != self.rows[0][1] || row[2] != 0.0;
        self.rows.len() > 1 && self.rows.iter().any(is_other)
    }

    /// Shortest time between two rows \[s]; infinite with one.
    pub(crate) fn shortest_interval(&self) -> f64 {
        let intervals = self.rows.windows(2).map(|pair| pair[1][0] - pair[0][0]);
        intervals.fold(f64::INFINITY, f64::min)
    }

    /// Shortest period of its back and forth by more than `least` \[m]: twice the time between two reversals \[s].
    pub(crate) fn shortest_period(&self, least: f64) -> Option<f64> {
        // Cubics may turn between their ends.
        let parts = if self.has_speeds { PARTS } else { 1 };
        let between = self.rows.windows(2).flat_map(|pair| {
            let (start, length) = (pair[0][0], pair[1][0] - pair[0][0]);
            (0..parts).map(move |k| start + length * f64::from(k) / f64::from(parts))
        });
        let times = between.chain(self.rows.last().map(|row| row[0]));
        let points = times.map(|time| (time, self.at(time)));
        shortest_half_period(points, least).map(|half| 2.0 * half)
    }

    /// Times, places and speeds, row by row.
    pub(crate) fn figures(&self) -> impl Iterator<Item = f64> {
        self.rows.iter().flatten().copied()
    }

    /// Largest speed \[m/s].
    pub fn greatest_speed(&self) -> f64 {
        let of_pair = |pair: &[[f64; 3]]| {
            let ([t0, x0, v0], [t1, x1, v1]) = (pair[0], pair[1]);
            let mean = (x1 - x0) / (t1 - t0);
            if !self.has_speeds {
                return mean.abs();
            }
            // The speed is a parabola a s² + b s + v0.
            let (a, b) = (
                3.0 * (v0 + v1) - 6.0 * mean,
                6.0 * mean - 4.0 * v0 - 2.0 * v1,
            );
            let top = -b / (2.0 * a);
            let at_top = if (0.0..1.0).contains(&top) {
                v0 + 0.5 * b * top
            } else {
                0.0
            };
            v0.abs().max(v1.abs()).max(at_top.abs())
        };
        self.rows.windows(2).map(of_pair).fold(0.0, f64::max)
    }

    /// Largest acceleration \[m/s²]. A table without speeds changes its speed over half of the times beside a row.
    pub fn greatest_acceleration(&self) -> f64 {
        let mean = |from: &[f64; 3], to: &[f64; 3]| (to[1] - from[1]) / (to[0] - from[0]);
        let largest = |accelerations: &mut dyn Iterator<Item = f64>| {
            accelerations.fold(0.0, |most: f64, a| most.max(a.abs()))
        };
        if self.has_speeds {
            // That of a cubic is linear in time.
            let ends = self.rows.windows(2).flat_map(|pair| {
                let (length, mean) = (pair[1][0] - pair[0][0], mean(&pair[0], &pair[1]));
                let (v0, v1) = (pair[0][2], pair[1][2]);
                [
                    6.0 * mean - 4.0 * v0 - 2.0 * v1,
                    2.0 * v0 + 4.0 * v1 - 6.0 * mean,
                ]
                .map(|change| change / length)
            });
            return largest(&mut { ends });
        }
        let kinks = self.rows.windows(3).map(|rows| {
            let change = mean(&rows[1], &rows[2]) - mean(&rows[0], &rows[1]);
            change / (0.5 * (rows[2][0] - rows[0][0]))
        });
        largest(&mut { kinks })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn course(text: &str) -> WallCourse {
        let motion: WallMotion = ron::Options::default()
            .with_default_extension(ron::extensions::Extensions::IMPLICIT_SOME)
            .from_str(text)
            .unwrap_or_else(|error| panic!("{error}: {text}"));
        WallCourse::new(&motion).unwrap_or_else(|error| panic!("{error}"))
    }

    fn table(text: &str) -> MotionTable {
        let folder = tempfile::tempdir().expect("a folder");
        let file = folder.path().join("piston.csv");
        std::fs::write(&file, text).expect("a file");
        MotionTable::load(&file).unwrap_or_else(|error| panic!("{error}"))
    }

    #[test]
    fn a_wall_starts_from_its_shape_and_is_where_its_motion_says() {
        let x = Vec3::new(0.3, 0.1, 0.0);
        for (text, time, expected) in [
            (
                "Velocity(velocity: (2, 0, 0), start: 1, end: 2)",
                0.5,
                [0.3, 0.1, 0.0],
            ),
            (
                "Velocity(velocity: (2, 0, 0), start: 1, end: 2)",
                1.5,
                [1.3, 0.1, 0.0],
            ),
            (
                "Velocity(velocity: (2, 0, 0), start: 1, end: 2)",
                9.0,
                [2.3, 0.1, 0.0],
            ),
            ("Velocity(velocity: (0, 1, 0))", 2.0, [0.3, 2.1, 0.0]),
            (
                "Rotation(center: (0.3, 0, 0), angular_velocity: (0, 0, 1.5707964))",
                1.0,
                [0.2, 0.0, 0.0],
            ),
            (
                "Oscillation(amplitude: (0, 0, 0.5), frequency: 0.25)",
                1.0,
                [0.3, 0.1, 0.5],
            ),
            (
                "Oscillation(amplitude: (0.5, 0, 0), frequency: 0.5, phase: 1.5707964)",
                1.0,
                [-0.7, 0.1, 0.0],
            ),
        ] {
            let course = course(text);
            let start = course.pose(0.0).place(x);
            assert!(start.distance(x.as_dvec3()) < 1e-12, "{text}");
            let found = course.pose(time).place(x);
            let away = found.distance(DVec3::from_array(expected));
            assert!(away < 1e-6, "{text}: {found}");
        }
    }

    /// Cubics of Hermite hold any cubic to rounding, and their speeds are those of small steps.
    #[test]
    fn a_table_of_places_and_speeds_holds_a_cubic() {
        let (x, v) = (|t: f64| t * t * t - t, |t: f64| 3.0 * t * t - 1.0);
        let row = |k: i32| {
            let t = -1.0 + 0.5 * f64::from(k);
            format!("{t},{},{}\n", x(t), v(t))
        };
        let rows: String = (0..=6).map(row).collect();
        let cubic = table(&format!("t,x,v\n{rows}"));
        let straight = table("t,x\n0,1\n2,5\n");
        for k in 0..=100 {
            let t = -1.0 + 0.03 * f64::from(k);
            assert!((cubic.way(t) - x(t)).abs() < 1e-12, "{t}");
            assert!(
                (straight.way(t) - (2.0 * t).clamp(0.0, 4.0)).abs() < 1e-12,
                "{t}"
            );
        }
        assert!((cubic.greatest_speed() - 11.0).abs() < 1e-9);
        assert_eq!(straight.greatest_speed(), 2.0);
        let hump = table("t,x,v\n0,0,0\n1,1,0\n");
        assert!((hump.greatest_speed() - 1.5).abs() < 1e-12);
    }
}
