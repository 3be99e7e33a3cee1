//! The types of an order file.

use serde::{Deserialize, Serialize};

use super::{condition::Condition, error::OrderError};
use crate::{
    loading::read,
    scene::{KernelFunction, Place, SceneError},
};

/// An order file.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Order {
    /// The stages, one after the other.
    pub stages: Vec<OrderItem>,
    /// Whether a stage may use products of an earlier step. This is an experiment and not refused.
    #[serde(default)]
    pub allow_stale: bool,
    /// Stages that the scene asks for but that do not run: their effect is missing.
    #[serde(default)]
    pub leave_out: Vec<String>,
}

/// A line of an order file.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub enum OrderItem {
    /// A stage by its name.
    Run(String),
    /// Stages that run in step 0 and in every n-th step after it. They also run in a step whose rows hold other
    /// particles than before, because the host spawned, despawned or tagged some.
    Every(u32, Vec<OrderItem>),
    /// Stages that run this many times in a row.
    Repeat(u32, Vec<OrderItem>),
    /// Stages that run in some steps only.
    Group {
        /// Number of steps between two runs, as in `Every`.
        #[serde(default = "one")]
        every: u32,
        /// The first step in which they are due; in the first step of a run they run in any case.
        #[serde(default)]
        offset: u32,
        /// A condition that must hold, too.
        #[serde(default)]
        when: Option<Condition>,
        /// The stages.
        stages: Vec<OrderItem>,
    },
    /// Forces between particles that are summed with another kernel: viscosity and surface tension.
    WithKernel {
        /// The function; the scene's if absent.
        #[serde(default)]
        kernel: Option<KernelFunction>,
        /// Its support radius in spacings \[-], at most the scene's; the scene's if absent.
        #[serde(default)]
        support: Option<f32>,
        /// The stages.
        stages: Vec<OrderItem>,
    },
    /// Forces that are summed this many times in a step, each time for a part of it: they see velocities that the parts
    /// before have changed. Their mean acts in the step, beside the forces before.
    SubSteps(u32, Vec<OrderItem>),
    /// The stage `pressure`, with forces that are summed anew in each of its iterations. From the second on they see
    /// the velocities that the last iteration predicts. They act beside the forces before.
    InPressure(Vec<OrderItem>),
}

fn one() -> u32 {
    1
}

impl Order {
    /// The order of `assets/orders/default.ron`.
    pub fn standard() -> Self {
        Self::parse(include_str!("../../../assets/orders/default.ron")).unwrap_or(Self {
            stages: Vec::new(),
            allow_stale: false,
            leave_out: Vec::new(),
        })
    }

    /// Reads an order.
    pub fn parse(text: &str) -> Result<Self, OrderError> {
        read(text, "order").map_err(|error| match error {
            SceneError::Syntax {
                place: Place::File { line, column, .. },
                message,
            } => OrderError::Syntax {
                line,
                column,
                message,
            },
            other => OrderError::Syntax {
                line: 1,
                column: 1,
                message: other.to_string(),
            },
        })
    }
}
