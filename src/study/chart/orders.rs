//! Errors over resolution as SVG: one panel per quantity, logarithmic axes with ticks at 1, 2 and 5 times powers of
//! ten.

use plotters::prelude::*;

use super::axes::{TICK, line, tick, ticks};
use super::canvas::{
    Area, At, COLOURS, ChartError, Drawn, GRID, INK, drawing, on_canvas, text, width_of,
};

/// Height of title and legend \[px].
const HEAD: u32 = 54;
/// Height of a panel \[px].
const HEIGHT: u32 = 300;
/// Panels side by side.
const COLUMNS: usize = 2;

/// Errors of one quantity.
pub struct ErrorPanel {
    /// The quantity.
    pub title: String,
    /// Names and points: resolution and absolute error \[-]. Points with an error of zero are not drawn.
    pub series: Vec<(String, Vec<(f64, f64)>)>,
}

/// Draws panels over the resolution; `across` says what the resolution counts. Series with the same name share a
/// colour. Fails without points.
pub fn draw(title: &str, across: &str, panels: &[ErrorPanel]) -> Result<String, ChartError> {
    let full: Vec<&ErrorPanel> = panels
        .iter()
        .filter(|panel| points(panel).count() > 0)
        .collect();
    if full.is_empty() {
        return Err(ChartError::Empty);
    }
    let mut names: Vec<&str> = Vec::new();
    for (name, _) in full.iter().flat_map(|panel| &panel.series) {
        if !names.contains(&name.as_str()) {
            names.push(name);
        }
    }
    let rows = full.len().div_ceil(COLUMNS);
    on_canvas(title, HEAD + rows as u32 * HEIGHT, |root| {
        legend(root, &names)?;
        let (_, body) = root.split_vertically(HEAD);
        for (area, panel) in body.split_evenly((rows, COLUMNS)).iter().zip(&full) {
            draw_panel(root, area, across, panel, &names)?;
        }
        Ok(())
    })
}

/// The points that have a logarithm.
fn points(panel: &ErrorPanel) -> impl Iterator<Item = (f64, f64)> + use<'_> {
    panel.series.iter().flat_map(|(_, points)| drawn(points))
}

fn drawn(points: &[(f64, f64)]) -> impl Iterator<Item = (f64, f64)> + use<'_> {
    let is_drawn = |point: &&(f64, f64)| point.0 > 0.0 && point.1 > 0.0 && point.1.is_finite();
    points.iter().filter(is_drawn).copied()
}

fn draw_panel(root: &Area, area: &Area, across: &str, panel: &ErrorPanel, names: &[&str]) -> Drawn {
    let range = |of: fn((f64, f64)) -> f64| {
        let logs = points(panel).map(|point| of(point).log10());
        let (low, high) = logs.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), log| {
            (low.min(log), high.max(log))
        });
        (low - 0.15)..(high + 0.15)
    };
    let (x, y) = (range(|point| point.0), range(|point| point.1));
    let inner = area.margin(34, 8, 8, 16);
    let chart = ChartBuilder::on(&inner)
        .x_label_area_size(46)
        .y_label_area_size(76)
        .build_cartesian_2d(x.clone(), y.clone())
        .map_err(drawing)?;
    let plot = chart.plotting_area();
    let (columns, rows) = plot.get_pixel_range();
    for value in ticks(&x) {
        let (at, _) = plot.map_coordinate(&(value.log10(), y.start));
        line(root, (at, rows.start), (at, rows.end), GRID)?;
        let words = tick(value);
        let left = at - width_of(&words, TICK) / 2;
        text(root, &words, (left, rows.end + 12), TICK, At::Left)?;
    }
    for value in ticks(&y) {
        let (_, at) = plot.map_coordinate(&(x.start, value.log10()));
        line(root, (columns.start, at), (columns.end, at), GRID)?;
        text(root, &tick(value), (columns.start - 6, at), TICK, At::Right)?;
    }
    line(
        root,
        (columns.start, rows.start),
        (columns.start, rows.end),
        INK,
    )?;
    line(
        root,
        (columns.start, rows.end),
        (columns.end, rows.end),
        INK,
    )?;
    text(
        root,
        &panel.title,
        (columns.start, rows.start - 14),
        14.0,
        At::Left,
    )?;
    let below = format!("particles over the {across}");
    text(root, &below, (columns.start, rows.end + 32), 13.0, At::Left)?;
    for (name, points) in &panel.series {
        let number = names.iter().position(|known| known == name).unwrap_or(0);
        let colour = COLOURS[number % COLOURS.len()];
        let places: Vec<_> = drawn(points).map(|(x, y)| (x.log10(), y.log10())).collect();
        plot.draw(&PathElement::new(places.clone(), colour.stroke_width(2)))
            .map_err(drawing)?;
        for place in places {
            plot.draw(&Circle::new(place, 4, colour.filled()))
                .map_err(drawing)?;
        }
    }
    Ok(())
}

/// The legend, a line below the title.
fn legend(root: &Area, names: &[&str]) -> Drawn {
    const Y: i32 = 42;
    let mut x = 22;
    for (number, name) in names.iter().enumerate() {
        let colour = COLOURS[number % COLOURS.len()];
        root.draw(&Circle::new((x, Y), 5, colour.filled()))
            .map_err(drawing)?;
        x += 14;
        text(root, name, (x, Y), 14.0, At::Left)?;
        x += width_of(name, 14.0) + 24;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_panel_of_what_has_no_logarithm_is_left_out() {
        let panel = |title: &str, error: f64| ErrorPanel {
            title: title.to_owned(),
            series: vec![("DFSPH".to_owned(), vec![(10.0, error), (20.0, 0.5 * error)])],
        };
        let svg = draw("t", "depth", &[panel("slope", 0.1), panel("zero", 0.0)]).expect("a chart");
        assert!(svg.contains("slope") && !svg.contains("zero"), "{svg}");
        assert!(draw("t", "depth", &[panel("zero", 0.0)]).is_err());
    }
}
