//! Measured figures and their known values.

use crate::measure::Curve;

/// Source of a known value.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Source {
    /// An exact solution of the equations solved here: errors vanish with the spacing.
    Exact,
    /// An experiment, or a bound: the error at infinite resolution is not necessarily zero.
    Experiment,
}

/// A measured figure with a known value.
#[derive(Debug, Clone, PartialEq)]
pub struct Figure {
    /// Its name, with its unit in brackets.
    pub quantity: String,
    /// The measured value; NaN if the run had nothing to measure.
    pub measured: f64,
    /// The known value.
    pub known: f64,
    /// The value to which errors are relative.
    pub scale: f64,
    /// Source of the known value.
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

    /// A quantity that should be zero, relative to a scale.
    pub fn residual(quantity: impl Into<String>, measured: f64) -> Self {
        Self {
            scale: 1.0,
            ..Self::exact(quantity, measured, 0.0)
        }
    }

    /// The same figure with a value from an experiment.
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

/// A measured curve and the known one, in SI units.
#[derive(Debug, Clone, PartialEq)]
pub struct Comparison {
    /// Name of its chart within the case: letters, digits and `_`.
    pub name: &'static str,
    /// Quantity and unit along the horizontal axis.
    pub x: &'static str,
    /// Quantity and unit along the vertical axis.
    pub y: &'static str,
    /// The measured points.
    pub measured: Vec<(f64, f64)>,
    /// The known points.
    pub known: Curve,
}

/// Results of a case.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Findings {
    /// Figures, in an order that does not depend on the method.
    pub figures: Vec<Figure>,
    /// Curves.
    pub comparisons: Vec<Comparison>,
}

/// A curve of points from a formula.
pub(super) fn exact_curve(note: &str, points: impl IntoIterator<Item = (f64, f64)>) -> Curve {
    Curve {
        points: points.into_iter().collect(),
        notes: vec![note.to_owned()],
    }
}

/// Linear interpolation between points with ascending abscissae, extrapolated by the last two; NaN with fewer than two.
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
