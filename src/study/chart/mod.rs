//! A table as a picture: SVG by plotters, whose texts are texts, so that no font is needed to write it.

mod bars;
mod canvas;
mod points;
mod svg;

pub use canvas::ChartError;
pub use svg::draw;
