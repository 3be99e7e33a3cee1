//! Shapes that are turned about their centre.

use glam::{DMat3, DVec3};

/// Where a turned shape is: what is written of it, turned about a point.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Frame {
    center: DVec3,
    turn: DMat3,
}

impl Frame {
    /// Turned about `center` \[m] by angles about the x, y and z axes, in this order \[°].
    pub(crate) fn new(center: DVec3, rotation: DVec3) -> Self {
        Self {
            center,
            turn: turn(rotation),
        }
    }

    /// Whether it moves anything.
    pub(crate) fn is_turned(&self) -> bool {
        self.turn != DMat3::IDENTITY
    }

    /// From the shape as it is written to the scene \[m].
    pub(crate) fn place(&self, point: DVec3) -> DVec3 {
        self.center + self.turn * (point - self.center)
    }

    /// From the scene to the shape as it is written \[m].
    pub(crate) fn local(&self, point: DVec3) -> DVec3 {
        self.center + self.turn.transpose() * (point - self.center)
    }

    /// A direction of the shape as it is written, in the scene.
    pub(crate) fn direction(&self, vector: DVec3) -> DVec3 {
        self.turn * vector
    }

    /// The corners of a box of the shape as it is written, in the scene \[m]: bit 0 of the index selects x, bit 1 y,
    /// bit 2 z.
    pub(crate) fn corners(&self, low: DVec3, high: DVec3) -> [DVec3; 8] {
        std::array::from_fn(|k| {
            let end = |axis: usize| [low[axis], high[axis]][k >> axis & 1];
            self.place(DVec3::new(end(0), end(1), end(2)))
        })
    }

    /// The box around a box of the shape as it is written \[m].
    pub(crate) fn bounds(&self, low: DVec3, high: DVec3) -> (DVec3, DVec3) {
        if !self.is_turned() {
            return (low, high);
        }
        let empty = (DVec3::INFINITY, DVec3::NEG_INFINITY);
        let corners = self.corners(low, high).into_iter();
        corners.fold(empty, |(low, high), x| (low.min(x), high.max(x)))
    }
}

/// The rotation by angles about the x, y and z axes, in this order \[°]; exact for multiples of a right angle.
pub(crate) fn turn(rotation: DVec3) -> DMat3 {
    let [x, y, z] = rotation.to_array().map(sin_cos);
    let about_x = DMat3::from_cols(
        DVec3::X,
        DVec3::new(0.0, x.1, x.0),
        DVec3::new(0.0, -x.0, x.1),
    );
    let about_y = DMat3::from_cols(
        DVec3::new(y.1, 0.0, -y.0),
        DVec3::Y,
        DVec3::new(y.0, 0.0, y.1),
    );
    let about_z = DMat3::from_cols(
        DVec3::new(z.1, z.0, 0.0),
        DVec3::new(-z.0, z.1, 0.0),
        DVec3::Z,
    );
    about_z * about_y * about_x
}

fn sin_cos(degrees: f64) -> (f64, f64) {
    match degrees.rem_euclid(360.0) {
        0.0 => (0.0, 1.0),
        90.0 => (1.0, 0.0),
        180.0 => (0.0, -1.0),
        270.0 => (-1.0, 0.0),
        angle => angle.to_radians().sin_cos(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn right_angles_are_exact_and_every_turn_is_undone() {
        let frame = Frame::new(DVec3::new(1.0, 2.0, 3.0), DVec3::new(0.0, 0.0, 90.0));
        assert_eq!(
            frame.place(DVec3::new(2.0, 2.0, 3.0)),
            DVec3::new(1.0, 3.0, 3.0)
        );
        assert!(!Frame::new(DVec3::ONE, DVec3::new(360.0, -720.0, 0.0)).is_turned());
        for k in 0..50 {
            let k = f64::from(k);
            let rotation = 400.0 * DVec3::new(k.sin(), (1.3 * k).cos(), (0.7 * k).sin());
            let frame = Frame::new(DVec3::new(k, -k, 1.0), rotation);
            let point = DVec3::new(0.3 * k, 1.0, -2.0);
            assert!(frame.local(frame.place(point)).distance(point) < 1e-12 * (1.0 + k));
            // The same as quaternions say, and as a mesh is placed.
            let angles = rotation.to_array().map(f64::to_radians);
            let quaternion = glam::DQuat::from_rotation_z(angles[2])
                * glam::DQuat::from_rotation_y(angles[1])
                * glam::DQuat::from_rotation_x(angles[0]);
            assert!((quaternion * point).distance(turn(rotation) * point) < 1e-12 * (1.0 + k));
        }
    }
}
