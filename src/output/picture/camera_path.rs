//! A camera that moves while pictures are drawn.

use std::path::Path;

use glam::Vec3;

use crate::measure::{Column, Columns, CurveError};
use crate::scene::Camera;

/// Where the camera is over the time of the frames.
#[derive(Debug, Clone, PartialEq)]
pub struct CameraPath(Vec<(f64, Camera)>);

/// Least distance of the eye from its target between two rows, of the larger of both rows: nearer the view jumps round.
const LEAST_PART: f64 = 1e-3;

/// The time at which an eye on its straight way from one row to the next meets its target \[s].
fn meets(from: &(f64, Camera), to: &(f64, Camera)) -> Option<f64> {
    let away = |camera: &Camera| camera.position.as_dvec3() - camera.target.as_dvec3();
    let (start, end) = (away(&from.1), away(&to.1));
    let way = end - start;
    let part = (-start.dot(way) / way.length_squared()).clamp(0.0, 1.0);
    // A way of no length has no nearest point.
    let is_met = part.is_finite()
        && (start + part * way).length() < LEAST_PART * start.length().max(end.length());
    is_met.then_some(from.0 + part * (to.0 - from.0))
}

/// Angle of view of a path that names none \[degrees].
const FIELD_OF_VIEW: f64 = 40.0;

impl CameraPath {
    /// Reads a CSV file: a line of names, a column `t` or `time` of ascending times \[s], the columns `x`, `y`, `z` of
    /// the eye and `target_x`, `target_y`, `target_z` of what it looks at \[m], and if wanted `field_of_view`
    /// \[degrees], in any order.
    ///
    /// # Errors
    /// When the file cannot be read, lacks a column, has an unknown one, or an eye that is where it looks.
    pub fn load(file: &Path) -> Result<Self, CurveError> {
        let named = Column::named;
        let columns = [
            Column::time(),
            named("x"),
            named("y"),
            named("z"),
            named("target_x"),
            named("target_y"),
            named("target_z"),
            Column::optional("field_of_view"),
        ];
        let table = Columns::load(file, columns)?.ascending(file)?;
        let has_angle = table.present[7];
        let vector = |x: f64, y: f64, z: f64| Vec3::new(x as f32, y as f32, z as f32);
        let of_row = |(line, row): &(usize, [f64; 8])| {
            let [time, x, y, z, tx, ty, tz, angle] = *row;
            let camera = Camera {
                position: vector(x, y, z),
                target: vector(tx, ty, tz),
                field_of_view: if has_angle { angle } else { FIELD_OF_VIEW } as f32,
            };
            let far = camera.position.abs().max(camera.target.abs());
            let message = if far.max_element() > Camera::FARTHEST {
                "the eye or what it looks at is farther than 1e9 m from the origin"
            } else if camera.position == camera.target {
                "the eye is where it looks; move one of them"
            } else if !(1.0..=150.0).contains(&camera.field_of_view) {
                "`field_of_view` must be from 1 to 150 degrees"
            } else {
                return Ok((time, camera));
            };
            Err(CurveError::Malformed {
                file: file.to_owned(),
                line: *line,
                message: message.to_owned(),
            })
        };
        let rows: Result<Vec<_>, _> = table.rows.iter().map(of_row).collect();
        let path = Self(rows?);
        for (pair, rows) in path.0.windows(2).zip(table.rows.windows(2)) {
            if let Some(time) = meets(&pair[0], &pair[1]) {
                return Err(CurveError::Malformed {
                    file: file.to_owned(),
                    line: rows[1].0,
                    message: format!(
                        "on the way from the row before the eye meets what it looks at, at {time:.4} s; put a row \
                         between that leads past it"
                    ),
                });
            }
        }
        Ok(path)
    }

    /// The camera at a time \[s]: straight from one row to the next, and still before the first and after the last.
    pub fn at(&self, time: f64) -> Option<Camera> {
        let after = self.0.partition_point(|row| row.0 <= time);
        let later = self.0.get(after).or(self.0.last())?;
        let Some(earlier) = after.checked_sub(1).and_then(|before| self.0.get(before)) else {
            return Some(later.1);
        };
        let length = later.0 - earlier.0;
        if length <= 0.0 {
            return Some(earlier.1);
        }
        let part = ((time - earlier.0) / length) as f32;
        let (from, to) = (earlier.1, later.1);
        Some(Camera {
            position: from.position.lerp(to.position, part),
            target: from.target.lerp(to.target, part),
            field_of_view: from.field_of_view + part * (to.field_of_view - from.field_of_view),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn path(text: &str) -> Result<CameraPath, String> {
        let folder = tempfile::tempdir().expect("a folder");
        let file = folder.path().join("path.csv");
        std::fs::write(&file, text).expect("a file");
        CameraPath::load(&file).map_err(|error| error.to_string())
    }

    #[test]
    fn a_camera_goes_straight_from_row_to_row() {
        let path = path(
            "t,target_x,target_y,target_z,x,y,z,field_of_view\n1,0,0,0,1,2,4,20\n3,0,0,2,3,2,4,40\n",
        )
        .expect("a path");
        let x = |time| path.at(time).map(|camera| camera.position.x);
        assert_eq!(
            [0.0, 1.0, 1.5, 3.0, 9.0].map(x),
            [1.0, 1.0, 1.5, 3.0, 3.0].map(Some)
        );
        let middle = path.at(2.0).expect("a camera");
        assert_eq!((middle.target.z, middle.field_of_view), (1.0, 30.0));
    }

    #[test]
    fn what_is_no_path_is_refused() {
        let head = "t,x,y,z,target_x,target_y,target_z";
        for (text, words) in [
            ("t,x,y\n0,1,1\n".to_owned(), "`z`"),
            (format!("{head}\n0,1,1,1,1,1,1\n"), "where it looks"),
            (format!("{head}\n1,1,1,1,0,0,0\n0,1,1,1,0,0,0\n"), "ascend"),
            (format!("{head}\n0,1e300,1,1,0,0,0\n"), "farther than 1e9 m"),
            (format!("{head}\n0,1,1,1,0,0,-2e9\n"), "farther than 1e9 m"),
            (
                format!("{head}\n0,2,0,0,0,0,0\n4,-6,0,0,0,0,0\n"),
                "at 1.0000 s",
            ),
            (
                format!("{head}\n0,2,1,0,0,1,0\n1,1,1,0,2,1,0\n"),
                "at 0.6667 s",
            ),
            (
                format!("{head},field_of_view\n0,1,1,1,0,0,0,0\n"),
                "degrees",
            ),
            (format!("{head}\n0,1,x,1,0,0,0\n"), "not a number"),
            (format!("{head}\n"), "no row"),
        ] {
            let error = path(&text).expect_err(&text);
            assert!(error.contains(words), "{error}");
        }
    }
}
