//! What a run writes.

use glam::Vec3;
use serde::{Deserialize, Serialize};

/// What a run writes.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields, default)]
pub struct Output {
    /// Frames per simulated second \[1/s]; 0 writes none but the first and the last.
    pub frames_per_second: f32,
    /// Whether steps are shortened so that frames are at multiples of the interval exactly. Without it, they are at the
    /// ends of the steps nearest to them, and the result does not depend on how many are written.
    pub exact_times: bool,
    /// File formats of the frames.
    pub formats: Vec<FrameFormat>,
    /// Whether a picture of every frame is drawn.
    pub pictures: bool,
    /// Where the picture is seen from; chosen from the scene if absent.
    pub camera: Option<Camera>,
}

/// File format of a frame.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[non_exhaustive]
pub enum FrameFormat {
    /// VTK XML unstructured grid, binary; ParaView opens it.
    Vtu,
    /// Stanford PLY, binary little endian.
    Ply,
}

/// A pinhole camera; y is up.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct Camera {
    /// Where the eye is \[m].
    #[cfg_attr(feature = "schema", schemars(with = "[f32; 3]"))]
    pub position: Vec3,
    /// Where it looks \[m].
    #[cfg_attr(feature = "schema", schemars(with = "[f32; 3]"))]
    pub target: Vec3,
    /// Vertical angle of view \[degrees].
    #[serde(default = "default_field_of_view")]
    pub field_of_view: f32,
}

impl Camera {
    /// Largest coordinate of an eye and of its target: the square of a distance is far from the largest number \[m].
    pub(crate) const FARTHEST: f32 = 1e9;
}

pub(super) fn default_field_of_view() -> f32 {
    40.0
}

impl Default for Output {
    fn default() -> Self {
        Self {
            frames_per_second: 25.0,
            exact_times: false,
            formats: vec![FrameFormat::Vtu],
            pictures: true,
            camera: None,
        }
    }
}
