//! Axes with ticks at 1, 2 and 5 times powers of ten.

use std::ops::Range;

use plotters::coord::types::RangedCoordf64;
use plotters::prelude::*;

use super::canvas::{Area, At, Drawn, GRID, INK, drawing, text, width_of};
use crate::study::stability::Scale;

/// Size of the numbers on an axis \[px].
pub(super) const TICK: f64 = 12.0;

/// A part of a canvas on which places of two scales are drawn.
pub(super) type Plot<'a> = DrawingArea<SVGBackend<'a>, Cartesian2d<RangedCoordf64, RangedCoordf64>>;

/// An axis of a plot: its label, its scale and its range of places (logarithms on a logarithmic scale).
pub(super) struct PlotAxis {
    pub(super) label: String,
    pub(super) scale: Scale,
    pub(super) range: Range<f64>,
}

/// Lays out a plot with grid, ticks and labels.
pub(super) fn plot<'a>(
    root: &Area,
    area: &Area<'a>,
    x: &PlotAxis,
    y: &PlotAxis,
) -> Result<Plot<'a>, super::ChartError> {
    let chart = ChartBuilder::on(area)
        .x_label_area_size(46)
        .y_label_area_size(84)
        .build_cartesian_2d(x.range.clone(), y.range.clone())
        .map_err(drawing)?;
    let plot = chart.plotting_area().clone();
    let (columns, rows) = plot.get_pixel_range();
    for value in ticks_of(x) {
        let (at, _) = plot.map_coordinate(&(x.scale.place(value), y.range.start));
        line(root, (at, rows.start), (at, rows.end), GRID)?;
        let words = tick(value);
        let left = at - width_of(&words, TICK) / 2;
        text(root, &words, (left, rows.end + 12), TICK, At::Left)?;
    }
    for value in ticks_of(y) {
        let (_, at) = plot.map_coordinate(&(x.range.start, y.scale.place(value)));
        line(root, (columns.start, at), (columns.end, at), GRID)?;
        text(root, &tick(value), (columns.start - 6, at), TICK, At::Right)?;
    }
    let below = (columns.start, rows.end + 32);
    text(root, &x.label, below, 13.0, At::Left)?;
    text(
        root,
        &y.label,
        (columns.start - 60, rows.start - 12),
        13.0,
        At::Left,
    )?;
    Ok(plot)
}

/// Draws the two lines of the axes, over what is on the plot.
pub(super) fn frame(root: &Area, plot: &Plot) -> Drawn {
    let (columns, rows) = plot.get_pixel_range();
    let corner = (columns.start, rows.end);
    line(root, (columns.start, rows.start), corner, INK)?;
    line(root, corner, (columns.end, rows.end), INK)
}

/// A thin line between two places of the canvas.
pub(super) fn line(root: &Area, from: (i32, i32), to: (i32, i32), colour: RGBColor) -> Drawn {
    root.draw(&PathElement::new(vec![from, to], colour.stroke_width(1)))
        .map_err(drawing)
}

fn ticks_of(axis: &PlotAxis) -> Vec<f64> {
    match axis.scale {
        Scale::Log => ticks(&axis.range),
        Scale::Linear => linear_ticks(&axis.range),
    }
}

/// Ticks at 1, 2 and 5 times powers of ten within a range of logarithms; only at powers if there are more than nine of
/// these, and closer ones if there are fewer than three.
pub(super) fn ticks(logs: &Range<f64>) -> Vec<f64> {
    let value = |(part, power): (f64, i32)| format!("{part}e{power}").parse().unwrap_or(part);
    let all = |parts: &[f64]| -> Vec<(f64, i32)> {
        let powers = logs.start.floor() as i32..=logs.end.ceil() as i32;
        let all = powers.flat_map(|power| parts.iter().map(move |&part| (part, power)));
        all.filter(|&of| logs.contains(&f64::log10(value(of))))
            .collect()
    };
    let within = all(&[1.0, 2.0, 5.0]);
    if within.len() < FEWEST {
        let closer = all(&[1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0, 9.0]);
        return if closer.len() < FEWEST {
            linear_ticks(&(10.0_f64.powf(logs.start)..10.0_f64.powf(logs.end)))
        } else {
            closer.into_iter().map(value).collect()
        };
    }
    let few = within.len() <= 9;
    let kept = within.into_iter().filter(|of| few || of.0 == 1.0);
    kept.map(value).collect()
}

/// Fewer ticks do not tell how long a logarithmic axis is.
const FEWEST: usize = 3;

/// Ticks at multiples of 1, 2 or 5 times a power of ten within a range: three to eight of them.
fn linear_ticks(range: &Range<f64>) -> Vec<f64> {
    let length = range.end - range.start;
    if length <= 0.0 || !length.is_finite() {
        return Vec::new();
    }
    let power = (length / 8.0).log10().floor() as i32;
    let steps = [1.0, 2.0, 5.0, 10.0].map(|part| (part, power));
    let value = |(part, power): (f64, i32)| part * 10.0_f64.powi(power);
    let step = steps
        .into_iter()
        .map(value)
        .find(|step| length / step <= 8.0);
    let step = step.unwrap_or(length);
    let first = (range.start / step).ceil() as i64;
    let last = (range.end / step).floor() as i64;
    // Without the rounding of binary fractions.
    let at = |k: i64| {
        format!("{:.9e}", k as f64 * step)
            .parse()
            .unwrap_or(k as f64 * step)
    };
    (first..=last).map(at).collect()
}

/// A number on an axis.
pub(super) fn tick(value: f64) -> String {
    if value == 0.0 || (1e-4..1e5).contains(&value.abs()) {
        format!("{value}")
    } else {
        format!("{value:e}")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ticks_are_at_1_2_and_5() {
        assert_eq!(ticks(&(-2.1..-0.9)), [0.01, 0.02, 0.05, 0.1]);
        assert_eq!(ticks(&(0.9..1.8)), [10.0, 20.0, 50.0]);
        assert_eq!(ticks(&(-5.5..0.5)), [1e-5, 1e-4, 1e-3, 0.01, 0.1, 1.0]);
        assert_eq!(ticks(&(0.327..0.928)), [3.0, 4.0, 5.0, 6.0, 7.0, 8.0]);
        assert_eq!(
            ticks(&(1.71..1.77)),
            [52.0, 53.0, 54.0, 55.0, 56.0, 57.0, 58.0]
        );
        assert_eq!(linear_ticks(&(0.0..1.0)), [0.0, 0.2, 0.4, 0.6, 0.8, 1.0]);
        assert_eq!(linear_ticks(&(1.4..4.1)), [1.5, 2.0, 2.5, 3.0, 3.5, 4.0]);
        assert_eq!(
            linear_ticks(&(-30.0..40.0)),
            [-30.0, -20.0, -10.0, 0.0, 10.0, 20.0, 30.0, 40.0]
        );
        assert_eq!(
            (tick(0.002), tick(2e-6), tick(0.0)),
            ("0.002".to_owned(), "2e-6".to_owned(), "0".to_owned())
        );
    }
}
