//! The canvas of a chart, and texts on it.

use plotters::prelude::*;

/// Width of a chart \[px].
pub(super) const WIDTH: u32 = 960;
pub(super) const FONT: &str = "sans-serif";
/// Colours that are distinguishable with any colour vision (Okabe & Ito 2008).
pub(super) const COLOURS: [RGBColor; 6] = [
    RGBColor(0, 114, 178),
    RGBColor(213, 94, 0),
    RGBColor(0, 158, 115),
    RGBColor(204, 121, 167),
    RGBColor(230, 159, 0),
    RGBColor(86, 180, 233),
];
pub(super) const INK: RGBColor = RGBColor(40, 40, 40);
pub(super) const GRID: RGBColor = RGBColor(225, 225, 225);

/// Why a chart cannot be drawn.
#[derive(Debug, thiserror::Error)]
pub enum ChartError {
    /// No row has the figures.
    #[error("no row has figures for it")]
    Empty,
    /// The drawing library failed.
    #[error("{0}")]
    Drawing(String),
}

pub(super) type Area<'a> = DrawingArea<SVGBackend<'a>, plotters::coord::Shift>;
pub(super) type Drawn = Result<(), ChartError>;

pub(super) fn drawing(error: impl std::fmt::Display) -> ChartError {
    ChartError::Drawing(error.to_string())
}

/// Draws on a white canvas, with the table's title at the top.
pub(super) fn on_canvas(
    title: &str,
    height: u32,
    paint: impl FnOnce(&Area) -> Drawn,
) -> Result<String, ChartError> {
    let mut svg = String::new();
    {
        let root = SVGBackend::with_string(&mut svg, (WIDTH, height)).into_drawing_area();
        root.fill(&WHITE).map_err(drawing)?;
        text(&root, title, (16, 14), 19.0, At::Left)?;
        paint(&root)?;
        root.present().map_err(drawing)?;
    }
    Ok(svg)
}

/// The part of a text that is at its position.
#[derive(Clone, Copy)]
pub(super) enum At {
    Left,
    Right,
}

/// A text whose middle line is at the height of `place` \[px].
pub(super) fn text(area: &Area, words: &str, place: (i32, i32), size: f64, at: At) -> Drawn {
    use plotters::style::text_anchor::{HPos, Pos, VPos};
    let horizontal = match at {
        At::Left => HPos::Left,
        At::Right => HPos::Right,
    };
    let style = TextStyle::from((FONT, size).into_font())
        .color(&INK)
        .pos(Pos::new(horizontal, VPos::Center));
    area.draw(&Text::new(words.to_owned(), place, style))
        .map_err(drawing)
}

/// Estimated width of a text \[px]: no font is available to measure it.
pub(super) fn width_of(words: &str, size: f64) -> i32 {
    (0.56 * size * words.chars().count() as f64).ceil() as i32
}
