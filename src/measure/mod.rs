//! Measures of a fluid that experiments and analytic solutions give, too: free functions over positions and values.

mod columns;
mod curve;
mod curve_error;
mod distance;
mod fit;
mod reversals;
mod shape;

pub use columns::{Column, Columns, Others};
pub use curve::Curve;
pub use curve_error::CurveError;
pub(crate) use curve_error::malformed;
pub use distance::{distance, range};
pub use fit::LineFit;
pub use reversals::shortest_half_period;
pub use shape::{front, height, semi_axes};
