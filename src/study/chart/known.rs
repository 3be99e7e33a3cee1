//! A gauge beside reference data, as SVG.

use plotters::prelude::*;

use super::canvas::{
    Area, At, COLOURS, ChartError, Drawn, FONT, GRID, INK, drawing, on_canvas, text, width_of,
};
use crate::measure::Curve;

/// Height of title and legend \[px].
const HEAD: u32 = 54;
/// Height of the chart without notes \[px].
const HEIGHT: u32 = 480;
/// Height of a line of notes \[px].
const LINE: u32 = 16;
const NOTE: f64 = 11.0;
/// Largest number of characters in a note.
const LONGEST: usize = 150;

/// Draws figures over time \[s] as a line, beside the points of a reference curve. The curve's notes stand below. Fails
/// without figures.
pub fn draw(
    title: &str,
    column: &str,
    measured: &[(f64, f64)],
    known: &Curve,
) -> Result<String, ChartError> {
    draw_runs(title, ["t [s]", column], &[("measured", measured)], known)
}

/// Draws the figures of several named runs as lines over axes with these names, beside the points of a reference curve.
/// The curve's notes stand below. Fails without figures.
pub fn draw_runs(
    title: &str,
    axes: [&str; 2],
    runs: &[(&str, &[(f64, f64)])],
    known: &Curve,
) -> Result<String, ChartError> {
    if runs.iter().all(|run| run.1.is_empty()) {
        return Err(ChartError::Empty);
    }
    let notes = known.notes.len() as u32 * LINE;
    on_canvas(title, HEAD + HEIGHT + notes, |root| {
        legend(root, runs)?;
        let (_, body) = root.split_vertically(HEAD);
        let (plot, below) = body.split_vertically(HEIGHT);
        curves(&plot.margin(6, 8, 8, 16), axes, runs, known)?;
        for (k, note) in known.notes.iter().enumerate() {
            let note: String = note.chars().take(LONGEST).collect();
            let middle = k as u32 * LINE + LINE / 2;
            text(&below, &note, (16, middle as i32), NOTE, At::Left)?;
        }
        Ok(())
    })
}

fn curves(plot: &Area, [x, y]: [&str; 2], runs: &[(&str, &[(f64, f64)])], known: &Curve) -> Drawn {
    let measured = || runs.iter().flat_map(|run| run.1);
    // Reference data outside the measured times are not shown.
    let end = measured().fold(0.0, |end: f64, point| end.max(point.0));
    let start = measured().fold(0.0, |start: f64, point| start.min(point.0));
    let points: Vec<_> = known.points.iter().filter(|point| point.0 <= end).collect();
    let values = (measured().chain(points.iter().copied())).map(|point| point.1);
    let (low, high) = values.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), value| {
        (low.min(value), high.max(value))
    });
    let room = if high > low {
        0.05 * (high - low)
    } else {
        high.abs().max(1.0) * 0.05
    };
    let mut chart = ChartBuilder::on(plot)
        .x_label_area_size(52)
        .y_label_area_size(84)
        .build_cartesian_2d(start..end.max(start + 1e-9), low - room..high + room)
        .map_err(drawing)?;
    chart
        .configure_mesh()
        .bold_line_style(GRID)
        .light_line_style(TRANSPARENT)
        .axis_style(INK)
        .label_style((FONT, 13).into_font().color(&INK))
        .axis_desc_style((FONT, 15).into_font().color(&INK))
        .x_desc(x)
        .y_desc(y)
        .draw()
        .map_err(drawing)?;
    let area = chart.plotting_area();
    for (number, (_, points)) in runs.iter().enumerate() {
        let colour = COLOURS[number % COLOURS.len()];
        // One point per pixel: a run has thousands of steps.
        let mut last = None;
        let seen = points.iter().filter(|point| {
            let pixel = area.map_coordinate(point);
            last.replace(pixel) != Some(pixel)
        });
        let line: Vec<_> = seen.copied().collect();
        area.draw(&PathElement::new(line, colour.stroke_width(2)))
            .map_err(drawing)?;
    }
    for &&point in &points {
        area.draw(&Circle::new(point, 4, INK.filled()))
            .map_err(drawing)?;
    }
    Ok(())
}

/// The legend, a line below the title.
fn legend(root: &Area, runs: &[(&str, &[(f64, f64)])]) -> Drawn {
    const Y: i32 = 42;
    let mut x = 16;
    for (number, (name, _)) in runs.iter().enumerate() {
        let colour = COLOURS[number % COLOURS.len()];
        let line = PathElement::new(vec![(x, Y), (x + 16, Y)], colour.stroke_width(2));
        root.draw(&line).map_err(drawing)?;
        text(root, name, (x + 22, Y), 14.0, At::Left)?;
        x += 22 + width_of(name, 14.0) + 24;
    }
    root.draw(&Circle::new((x, Y), 4, INK.filled()))
        .map_err(drawing)?;
    text(root, "reference", (x + 12, Y), 14.0, At::Left)
}
