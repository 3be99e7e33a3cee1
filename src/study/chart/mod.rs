//! A table as an SVG picture, drawn by plotters. Its texts stay texts, so no font is needed to write it.

mod bars;
mod canvas;
mod known;
mod orders;
mod phases;
mod points;
mod speed_up;
mod svg;

pub use canvas::ChartError;
pub use known::{draw as draw_beside_known, draw_runs as draw_runs_beside_known};
pub use orders::{ErrorPanel, draw as draw_orders};
pub use svg::draw;
