//! A table as SVG, as its study wants it shown.

use super::canvas::ChartError;
use super::{bars, points};
use crate::study::{Chart, Table};

/// The chart as SVG. Fails if no row has the figures it shows.
pub fn draw(table: &Table, chart: &Chart) -> Result<String, ChartError> {
    match chart {
        Chart::Ratios { columns } => bars::draw(table, columns),
        Chart::Points { x, y } => points::draw(table, x, y),
    }
}
