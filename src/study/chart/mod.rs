//! A table as an SVG picture, drawn by plotters. Its texts stay texts, so no font is needed to write it.

mod axes;
mod bars;
mod canvas;
mod contour;
mod frontier;
mod known;
mod map;
mod orders;
mod phases;
mod points;
mod speed_up;
mod svg;

pub use canvas::ChartError;
pub use frontier::{FrontierPanel, FrontierPicture, FrontierPoint, draw as draw_frontier};
pub use known::{draw as draw_beside_known, draw_runs as draw_runs_beside_known};
pub use map::{MapPicture, draw as draw_map};
pub use orders::{ErrorPanel, draw as draw_orders};
pub use svg::draw;
