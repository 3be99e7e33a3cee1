//! What was measured beside what is known.

use crate::measure::Curve;

/// Where a known value comes from.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Source {
    /// A solution of the equations that are solved here: errors fade with the spacing.
    Exact,
    /// An experiment, or a bound: what is left at an infinite resolution is not known to be zero.
    Experiment,
}

/// One thing that was measured and is known.
#[derive(Debug, Clone, PartialEq)]
pub struct Figure {
    /// Its name, with its unit in brackets.
    pub quantity: String,
    /// What the run gave; not a number if the run had nothing to measure.
    pub measured: f64,
    /// What is known.
    pub known: f64,
    /// What errors are relative to.
    pub scale: f64,
    /// Where the known value comes from.
    pub source: Source,
}

impl Figure {
    /// A quantity whose error is relative to its exact value.
    pub fn exact(quantity: impl Into<String>, measured: f64, known: f64) -> Self {
        Self {
            quantity: quantity.into(),
            measured,
            known,
            scale: known.abs(),
            source: Source::Exact,
        }
    }

    /// A quantity that should be zero, in units of what it is measured by.
    pub fn residual(quantity: impl Into<String>, measured: f64) -> Self {
        Self {
            scale: 1.0,
            ..Self::exact(quantity, measured, 0.0)
        }
    }

    /// The same figure, known from an experiment.
    pub fn by_experiment(self) -> Self {
        Self {
            source: Source::Experiment,
            ..self
        }
    }

    /// Signed relative error \[-].
    pub fn error(&self) -> f64 {
        (self.measured - self.known) / self.scale
    }
}

/// A measured curve beside the known one, in SI units.
#[derive(Debug, Clone, PartialEq)]
pub struct Comparison {
    /// Names its chart among the case's: letters, digits and `_`.
    pub name: &'static str,
    /// Quantity and unit along the horizontal axis.
    pub x: &'static str,
    /// Quantity and unit along the vertical axis.
    pub y: &'static str,
    /// What the run gave.
    pub measured: Vec<(f64, f64)>,
    /// What is known.
    pub known: Curve,
}

/// What a case found.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Findings {
    /// Figures, in an order that does not depend on the method.
    pub figures: Vec<Figure>,
    /// Curves.
    pub comparisons: Vec<Comparison>,
}

/// A curve of points that a formula gives.
pub(super) fn exact_curve(note: &str, points: impl IntoIterator<Item = (f64, f64)>) -> Curve {
    Curve {
        points: points.into_iter().collect(),
        notes: vec![note.to_owned()],
    }
}

/// Linear interpolation between points whose abscissae ascend, beyond them the line through the last two; not a number
/// with fewer.
pub(super) fn at(points: &[(f64, f64)], x: f64) -> f64 {
    if points.len() < 2 {
        return f64::NAN;
    }
    let next = points
        .partition_point(|point| point.0 < x)
        .clamp(1, points.len() - 1);
    let ((x0, y0), (x1, y1)) = (points[next - 1], points[next]);
    y0 + (y1 - y0) * (x - x0) / (x1 - x0)
}
