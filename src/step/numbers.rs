//! Numbers in texts of warnings.

/// A number with four digits that count, as people write it.
pub(super) fn short(number: f64) -> f64 {
    format!("{number:.3e}").parse().unwrap_or(number)
}
