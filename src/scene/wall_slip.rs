//! How a boundary holds the fluid along its face.

use serde::{Deserialize, Serialize};

/// How a boundary holds the fluid along its face. What is not `Free` needs a laminar viscosity.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub enum WallSlip {
    /// Not at all.
    #[default]
    Free,
    /// The fluid at the face has the velocity of the wall.
    NoSlip,
    /// The fluid at the face slips with the shear rate times a length (Navier).
    Partial {
        /// How far behind the face the velocity would be that of the wall \[m].
        length: f32,
    },
}

impl WallSlip {
    /// The slip length \[m], 0 without slip; none if it is free.
    pub fn length(self) -> Option<f32> {
        match self {
            Self::Free => None,
            Self::NoSlip => Some(0.0),
            Self::Partial { length } => Some(length),
        }
    }
}
