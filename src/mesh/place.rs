//! Where a surface is put.

use glam::{DMat3, DQuat, DVec3, EulerRot};

/// A linear map and a translation \[m].
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Place {
    map: DMat3,
    translation: DVec3,
}

impl Place {
    /// Scales first, then turns by angles about x, y and z in this order \[°], then translates \[m].
    pub(crate) fn of_mesh(scale: f64, rotation: DVec3, translation: DVec3) -> Self {
        let turn = rotation * (std::f64::consts::PI / 180.0);
        let turn = DQuat::from_euler(EulerRot::ZYX, turn.z, turn.y, turn.x);
        let scale = DMat3::from_diagonal(DVec3::splat(scale));
        Self {
            map: DMat3::from_quat(turn) * scale,
            translation,
        }
    }

    /// Turns, then translates \[m].
    pub(crate) fn turned(turn: DMat3, translation: DVec3) -> Self {
        Self {
            map: turn,
            translation,
        }
    }

    pub(super) fn put(&self, vertices: &mut [DVec3]) {
        for vertex in vertices {
            *vertex = self.point(*vertex);
        }
    }

    pub(crate) fn point(&self, point: DVec3) -> DVec3 {
        self.map * point + self.translation
    }

    /// A direction; the map must be a rotation.
    pub(crate) fn direction(&self, vector: DVec3) -> DVec3 {
        self.map * vector
    }

    /// Where a point came from; the map must be a rotation.
    pub(crate) fn local(&self, point: DVec3) -> DVec3 {
        self.map.transpose() * (point - self.translation)
    }
}
