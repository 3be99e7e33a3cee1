//! Measures of a fluid that experiments and analytic solutions give, too: free functions over positions and values.

mod curve;
mod fit;
mod shape;

pub use curve::{Curve, CurveError};
pub use fit::LineFit;
pub use shape::{front, height, semi_axes};
