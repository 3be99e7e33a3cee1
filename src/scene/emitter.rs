//! Sources and sinks of fluid: emitters, and particles that leave.

use glam::Vec3;
use serde::{Deserialize, Serialize};

use super::Jitter;

/// A source of fluid: a face through which it enters along the normal, at rest density and at a constant speed.
///
/// The volume that enters per second is exactly `area × speed` (per metre of depth in 2-D). The last few layers before
/// the face, about a support radius, are particles of the scene already: they move with the speed of the emitter
/// whatever acts on them, as fluid in a pipe does, and are free from the face on. So there must be room for them behind
/// the face.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct Emitter {
    /// The face.
    pub shape: EmitterShape,
    /// Speed along the normal \[m/s].
    pub speed: f32,
    /// When the fluid reaches the face \[s].
    #[serde(default)]
    pub start: f32,
    /// When the last of it passes the face \[s]; never if absent.
    #[serde(default)]
    pub end: Option<f32>,
    /// Most particles that enter; any number if absent.
    #[serde(default)]
    pub limit: Option<u32>,
    /// Random displacement of the particles, different in every layer; none if absent.
    #[serde(default)]
    pub jitter: Option<Jitter>,
}

/// The face of an emitter. In 2-D it is a segment in the plane z = 0.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
#[non_exhaustive]
pub enum EmitterShape {
    /// A disc; in 2-D a segment as long as its diameter.
    Disc {
        /// Centre \[m].
        #[cfg_attr(feature = "schema", schemars(with = "[f32; 3]"))]
        center: Vec3,
        /// Direction in which the fluid enters; any length but zero.
        #[cfg_attr(feature = "schema", schemars(with = "[f32; 3]"))]
        normal: Vec3,
        /// Radius \[m].
        radius: f32,
    },
    /// A rectangle; in 2-D a segment.
    Rectangle {
        /// Centre \[m].
        #[cfg_attr(feature = "schema", schemars(with = "[f32; 3]"))]
        center: Vec3,
        /// Direction in which the fluid enters; any length but zero.
        #[cfg_attr(feature = "schema", schemars(with = "[f32; 3]"))]
        normal: Vec3,
        /// Extent across `up` \[m]; in 2-D the length of the segment.
        width: f32,
        /// Extent along `up` \[m]; in 3-D only.
        #[serde(default)]
        height: Option<f32>,
        /// Direction of the height, of which the part across the normal counts; in 3-D only. If absent +y, or +z where
        /// the normal is along y.
        #[serde(default)]
        #[cfg_attr(feature = "schema", schemars(with = "Option<[f32; 3]>"))]
        up: Option<Vec3>,
    },
}

/// What happens to a particle outside `domain`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub enum Outside {
    /// The step fails, and the run stops.
    #[default]
    Stop,
    /// The particle is removed and counted.
    Remove,
}

impl EmitterShape {
    /// A [`Disc`](Self::Disc) \[m].
    pub fn disc(center: impl Into<Vec3>, normal: impl Into<Vec3>, radius: f32) -> Self {
        let (center, normal) = (center.into(), normal.into());
        Self::Disc {
            center,
            normal,
            radius,
        }
    }

    /// A [`Rectangle`](Self::Rectangle) of a width, and in 3-D a height \[m].
    pub fn rectangle(
        center: impl Into<Vec3>,
        normal: impl Into<Vec3>,
        width: f32,
        height: Option<f32>,
    ) -> Self {
        Self::Rectangle {
            center: center.into(),
            normal: normal.into(),
            width,
            height,
            up: None,
        }
    }

    /// Centre of the face \[m].
    pub fn center(&self) -> Vec3 {
        match *self {
            Self::Disc { center, .. } | Self::Rectangle { center, .. } => center,
        }
    }

    /// Direction in which the fluid enters, as it is written.
    pub fn normal(&self) -> Vec3 {
        match *self {
            Self::Disc { normal, .. } | Self::Rectangle { normal, .. } => normal,
        }
    }
}

impl Emitter {
    /// An emitter that runs from the start on, without an end.
    pub fn new(shape: EmitterShape, speed: f32) -> Self {
        Self {
            shape,
            speed,
            start: 0.0,
            end: None,
            limit: None,
            jitter: None,
        }
    }
}
