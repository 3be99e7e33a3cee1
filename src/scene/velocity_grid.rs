//! Velocities at the start from a file: figures at the points of a grid, linear in between.

use std::path::Path;

use glam::DVec3;

use crate::measure::{Column, Columns, CurveError, malformed};

/// Velocities at the points of a rectilinear grid.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct VelocityGrid {
    /// Coordinates of its planes along each axis, ascending \[m]. One plane: the field does not change along the axis.
    axes: [Vec<f64>; 3],
    /// By point, along x first, then y, then z \[m/s].
    velocities: Vec<DVec3>,
    /// The plane of a file whose column `z` has one value \[m].
    only_z: Option<f64>,
}

/// Names of the columns: a point \[m], and the velocity there \[m/s].
const COLUMNS: [&str; 6] = ["x", "y", "z", "vx", "vy", "vz"];

impl VelocityGrid {
    /// Reads a CSV file with the columns `x`, `y`, `vx`, `vy` and, if the field has them, `z` and `vz`: a row for every
    /// point of a grid, in any order.
    ///
    /// # Errors
    /// When it cannot be read, holds what is no number, or its points do not make a grid, each once.
    pub fn load(file: &Path) -> Result<Self, CurveError> {
        let wanted = COLUMNS.map(|name| match name {
            "z" | "vz" => Column::optional(name),
            _ => Column::named(name),
        });
        let columns = Columns::load(file, wanted)?;
        let axes = [0, 1, 2].map(|axis| {
            let mut planes: Vec<f64> = columns.rows.iter().map(|row| row.1[axis]).collect();
            planes.sort_by(f64::total_cmp);
            planes.dedup();
            planes
        });
        let mut grid = Self {
            velocities: Vec::new(),
            only_z: match axes[2].as_slice() {
                [z] if columns.present[2] => Some(*z),
                _ => None,
            },
            axes,
        };
        let counts = grid.axes.each_ref().map(Vec::len);
        let size = counts.iter().try_fold(1_usize, |n, m| n.checked_mul(*m));
        let found = columns.rows.len();
        let size = size.filter(|size| *size <= found).ok_or_else(|| {
            let [x, y, z] = counts;
            let message = format!(
                "{found} rows are not one for every point of a grid: they have {x} values of x, {y} of y and {z} of z; \
                 write a row for each of their combinations"
            );
            malformed(file, 1, message)
        })?;
        let mut velocities = vec![None; size];
        for (line, [x, y, z, vx, vy, vz]) in columns.rows {
            let slot = &mut velocities[grid.number([x, y, z])];
            if slot.is_some() {
                let message = format!("the point ({x}, {y}, {z}) is given twice");
                return Err(malformed(file, line, message));
            }
            *slot = Some(DVec3::new(vx, vy, vz));
        }
        // As many rows as points, none twice: none is missing.
        grid.velocities = velocities.into_iter().flatten().collect();
        for (planes, name) in grid.axes.iter().zip(COLUMNS).take(2) {
            if let [only] = planes.as_slice() {
                let message = format!(
                    "the grid has one plane, {name} = {only} m; write planes at both ends of the body, with the same \
                     velocities if the field does not change along {name}"
                );
                return Err(malformed(file, 1, message));
            }
        }
        Ok(grid)
    }

    /// Number of the point with these coordinates.
    fn number(&self, place: [f64; 3]) -> usize {
        let [x, y, z] = [0, 1, 2].map(|axis| {
            let planes = &self.axes[axis];
            planes.partition_point(|plane| *plane < place[axis])
        });
        x + self.axes[0].len() * (y + self.axes[1].len() * z)
    }

    /// Its corners \[m]; infinite along an axis with one plane.
    pub(crate) fn corners(&self) -> [DVec3; 2] {
        let end = |axis: usize, last: bool| match self.axes[axis].as_slice() {
            [first, .., end] => [*first, *end][usize::from(last)],
            _ => [f64::NEG_INFINITY, f64::INFINITY][usize::from(last)],
        };
        [false, true].map(|last| DVec3::new(end(0, last), end(1, last), end(2, last)))
    }

    /// Velocity at a point \[m/s], linear along each axis; beyond the border that of the border.
    pub fn at(&self, point: DVec3) -> DVec3 {
        let parts = [0, 1, 2].map(|axis| {
            let planes = &self.axes[axis];
            let after = planes.partition_point(|plane| *plane <= point[axis]);
            let lower = after.saturating_sub(1);
            let upper = after.min(planes.len().saturating_sub(1));
            let (a, b) = match (planes.get(lower), planes.get(upper)) {
                (Some(a), Some(b)) => (*a, *b),
                _ => (0.0, 0.0),
            };
            let part = if b > a {
                (point[axis] - a) / (b - a)
            } else {
                0.0
            };
            [(lower, 1.0 - part), (upper, part)]
        });
        let mut sum = DVec3::ZERO;
        for (z, part_z) in parts[2] {
            for (y, part_y) in parts[1] {
                for (x, part_x) in parts[0] {
                    let number = x + self.axes[0].len() * (y + self.axes[1].len() * z);
                    let velocity = self.velocities.get(number).copied().unwrap_or_default();
                    sum += part_x * part_y * part_z * velocity;
                }
            }
        }
        sum
    }

    /// Largest speed \[m/s].
    pub fn greatest_speed(&self) -> f64 {
        let speeds = self.velocities.iter().map(|v| v.length());
        speeds.fold(0.0, f64::max)
    }

    /// The plane of a file whose column `z` has one value \[m].
    pub(crate) fn only_z(&self) -> Option<f64> {
        self.only_z
    }

    /// Whether it has a velocity anywhere.
    pub(crate) fn moves(&self) -> bool {
        self.velocities.iter().any(|v| *v != DVec3::ZERO)
    }

    /// Whether it has a velocity along z.
    pub(crate) fn leaves_the_plane(&self) -> bool {
        self.velocities.iter().any(|v| v.z != 0.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn grid(text: &str) -> Result<VelocityGrid, CurveError> {
        let folder = tempfile::tempdir().expect("a folder");
        let file = folder.path().join("field.csv");
        std::fs::write(&file, text).expect("a file");
        VelocityGrid::load(&file)
    }

    /// A field that is linear along each axis is held to rounding, on uneven planes, whatever the order of the rows.
    #[test]
    fn a_grid_holds_a_trilinear_field() {
        let field = |x: DVec3| DVec3::new(x.x * x.y, 1.0 - x.y * x.z, x.x * x.y * x.z + x.z);
        let mut rows = Vec::new();
        for x in [-1.0, 0.0, 0.25, 2.0] {
            for y in [0.5, 1.0, 3.0] {
                for z in [-0.5, 0.5] {
                    let v = field(DVec3::new(x, y, z));
                    rows.push(format!("{},{},{},{x},{y},{z}\n", v.x, v.y, v.z));
                }
            }
        }
        rows.reverse();
        let grid = grid(&format!("vx,vy,vz,x,y,z\n{}", rows.concat())).expect("a grid");
        for k in 0..200 {
            let k = f64::from(k);
            let part = DVec3::new(k.sin(), (1.7 * k).cos(), (0.6 * k).sin()) * 0.5 + 0.5;
            let [low, high] = grid.corners();
            let x = low + part * (high - low);
            assert!(grid.at(x).distance(field(x)) < 1e-12, "{x}");
        }
        assert!(grid.greatest_speed() > 0.0);
    }

    #[test]
    fn a_field_in_the_plane_needs_no_z() {
        let grid = grid("x,y,vx,vy\n0,0,1,0\n1,0,3,0\n0,1,1,2\n1,1,3,2\n").expect("a grid");
        let v = grid.at(DVec3::new(0.25, 0.5, 7.0));
        assert_eq!(v, DVec3::new(1.5, 1.0, 0.0));
        assert!(!grid.leaves_the_plane());
        // Beyond the border it is that of the border.
        assert_eq!(grid.at(DVec3::new(-3.0, 0.0, 0.0)), DVec3::X);
    }

    #[test]
    fn what_is_no_grid_is_refused_with_its_line() {
        for (text, expected) in [
            ("x,y,vx\n0,0,1\n", "no column `vy`"),
            ("x,y,vx,vy\n0,0,1,inf\n", "field.csv:2: `inf`"),
            ("x,y,vx,vy\n0,0,1,0\n", "one plane, x = 0 m"),
            ("x,y,vx,vy\n0,3,1,0\n1,3,1,0\n", "one plane, y = 3 m"),
            (
                "x,y,vx,vy,VZ\n0,0,1,0,1\n",
                "unknown column `VZ`; did you mean `vz`?",
            ),
            ("x,y,vx,vy,p\n0,0,1,0,1\n", "unknown column `p`"),
            ("x,y,vx,vy,vy\n0,0,1,0,1\n", "`vy` is there twice"),
            (
                "x,y,vx,vy\n0,0,1,0\n1,1,1,0\n",
                "2 rows are not one for every point",
            ),
            (
                "x,y,vx,vy\n0,0,1,0\n0,0,1,0\n",
                "field.csv:3: the point (0, 0, 0) is given twice",
            ),
        ] {
            let error = grid(text).expect_err(text).to_string();
            assert!(error.contains(expected), "{error}");
        }
    }
}
