//! Conditions under which stages of an order run, and when they are due.

use std::fmt;

use bevy_ecs::{prelude::*, system::SystemParam};
use serde::{Deserialize, Serialize};

use crate::{
    integrate::Motion,
    state::{Clock, SolverState},
};

/// When a group of stages runs. Quantities are those of the last step, 0 before the first one, and are compared at the
/// start of a step.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub enum Condition {
    /// Largest speed \[m/s].
    MaxSpeed(Range),
    /// Largest acceleration, pressure included \[m/s²].
    MaxAcceleration(Range),
    /// Largest pressure \[Pa].
    MaxPressure(Range),
    /// Largest density error that the pressure solve left \[-].
    DensityError(Range),
    /// Pressure iterations \[-].
    Iterations(Range),
    /// Length of this step \[s].
    TimeStep(Range),
    /// Simulated time at the start of this step \[s].
    Time(Range),
}

/// Where a quantity has to be; at least one bound is given.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Range {
    /// Lower bound, excluded.
    pub above: Option<f64>,
    /// Upper bound, excluded.
    pub below: Option<f64>,
}

impl Range {
    fn holds(&self, value: f64) -> bool {
        self.above.is_none_or(|bound| value > bound) && self.below.is_none_or(|bound| value < bound)
    }

    /// Whether a value can be in it, and one outside of it.
    fn is_sensible(&self) -> bool {
        let finite = |bound: Option<f64>| bound.is_none_or(f64::is_finite);
        let ordered = match (self.above, self.below) {
            (None, None) => false,
            (Some(above), Some(below)) => above < below,
            _ => true,
        };
        finite(self.above) && finite(self.below) && ordered
    }
}

/// What conditions compare.
#[derive(SystemParam)]
pub(in crate::step) struct Compared<'w> {
    clock: Res<'w, Clock>,
    motion: Option<Res<'w, Motion>>,
    solve: Option<Res<'w, SolverState>>,
}

impl Condition {
    fn parts(&self) -> (&'static str, Range) {
        match *self {
            Self::MaxSpeed(range) => ("MaxSpeed", range),
            Self::MaxAcceleration(range) => ("MaxAcceleration", range),
            Self::MaxPressure(range) => ("MaxPressure", range),
            Self::DensityError(range) => ("DensityError", range),
            Self::Iterations(range) => ("Iterations", range),
            Self::TimeStep(range) => ("TimeStep", range),
            Self::Time(range) => ("Time", range),
        }
    }

    pub(super) fn is_sensible(&self) -> bool {
        self.parts().1.is_sensible()
    }

    pub(in crate::step) fn holds(&self, compared: &Compared) -> bool {
        let motion = |of: fn(&Motion) -> f32| compared.motion.as_deref().map_or(0.0, of).into();
        let solve = compared.solve.as_deref();
        let value = match self {
            Self::MaxSpeed(_) => motion(|motion| motion.max_speed),
            Self::MaxAcceleration(_) => motion(|motion| motion.max_acceleration),
            Self::MaxPressure(_) => motion(|motion| motion.max_pressure),
            Self::DensityError(_) => solve.map_or(0.0, |solve| solve.error.largest.into()),
            Self::Iterations(_) => solve.map_or(0.0, |solve| solve.iterations.into()),
            Self::TimeStep(_) => compared.clock.dt.into(),
            Self::Time(_) => compared.clock.time,
        };
        self.parts().1.holds(value)
    }
}

impl fmt::Display for Condition {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        let (name, range) = self.parts();
        let bounds = [("above", range.above), ("below", range.below)];
        let bounds = bounds.map(|(word, bound)| bound.map(|bound| format!("{word}: {bound}")));
        let bounds: Vec<String> = bounds.into_iter().flatten().collect();
        write!(f, "{name}({})", bounds.join(", "))
    }
}

/// When a stage is due: in every n-th step, counted from one of them, and under a condition.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Due {
    /// Number of steps between two runs.
    pub(crate) every: u64,
    /// The first step in which it is due.
    pub(crate) offset: u64,
    /// Whether a group around it has a condition.
    pub(crate) sometimes: bool,
}

impl Due {
    /// In every step.
    pub(super) const ALWAYS: Self = Self {
        every: 1,
        offset: 0,
        sometimes: false,
    };

    /// Whether the step is one of them. Stages also run in a step whose rows hold other particles than before.
    pub(crate) fn is_now(&self, clock: &Clock, rows_changed: bool) -> bool {
        clock.step % self.every == self.offset || rows_changed
    }
}

/// Whether the conditions of the order's groups hold in this step, by the number of the group.
#[derive(Resource, Debug, Default)]
pub(in crate::step) struct Decisions(pub(in crate::step) Vec<bool>);
