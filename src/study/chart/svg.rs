//! A table as SVG, in the form that its study selects.

use super::canvas::ChartError;
use super::{bars, phases, points, speed_up};
use crate::study::{Chart, Table};

/// The chart as SVG. Fails if no row has the figures it shows.
pub fn draw(table: &Table, chart: &Chart) -> Result<String, ChartError> {
    match chart {
        Chart::Ratios { columns } => bars::draw(table, columns),
        Chart::Points { x, y } => points::draw(table, x, y),
        Chart::SpeedUp { columns } => speed_up::draw(table, columns),
        Chart::Phases => phases::draw(table),
    }
}
