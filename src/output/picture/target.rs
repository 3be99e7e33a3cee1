//! What is drawn, as it is on the picture, and where it is drawn to.

use glam::Vec2;

/// A sphere, projected onto the picture.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Splat {
    pub(super) at: Vec2,
    /// \[samples]; 0 if it is outside the picture.
    pub(super) radius: f32,
    /// Depth of the centre \[m].
    pub(super) depth: f32,
}

/// A band of rows while it is drawn.
pub(super) struct Target<'a> {
    pub(super) first_row: usize,
    pub(super) width: usize,
    pub(super) depth: &'a mut [f32],
    pub(super) surface: &'a mut [u32],
}
