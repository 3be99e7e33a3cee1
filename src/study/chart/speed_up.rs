//! Speed-up over the number of threads: points as measured, Amdahl's law fitted to them, and the reference's points.

use plotters::prelude::*;

use super::canvas::{
    Area, At, COLOURS, ChartError, Drawn, FONT, GRID, INK, drawing, on_canvas, text,
};
use crate::study::{Scaling, Table, amdahl};

/// Height of the title \[px].
const HEAD: u32 = 30;
/// Height of a panel \[px].
const HEIGHT: u32 = 420;
const RADIUS: i32 = 5;
/// Points of a curve.
const POINTS: u32 = 200;

pub(super) fn draw(table: &Table, columns: &[String]) -> Result<String, ChartError> {
    let columns = columns.iter().filter_map(|name| table.column(name));
    let panels: Vec<(usize, Vec<Scaling>)> = columns
        .map(|column| (column, table.scalings(column)))
        .filter(|(_, scalings)| !scalings.is_empty())
        .collect();
    if panels.is_empty() {
        return Err(ChartError::Empty);
    }
    on_canvas(&table.title, HEAD + panels.len() as u32 * HEIGHT, |root| {
        let (_, body) = root.split_vertically(HEAD);
        let areas = body.split_evenly((panels.len(), 1));
        for (area, (column, scalings)) in areas.iter().zip(&panels) {
            panel(
                root,
                &area.margin(10, 8, 8, 16),
                &table.columns[*column].name,
                scalings,
            )?;
        }
        Ok(())
    })
}

fn panel(root: &Area, plot: &Area, name: &str, scalings: &[Scaling]) -> Drawn {
    let all = || {
        scalings
            .iter()
            .flat_map(|scaling| scaling.points.iter().chain(&scaling.reference))
    };
    let most = all().map(|point| point.0).fold(2.0, f64::max);
    let fastest = all().map(|point| point.1).fold(1.0, f64::max);
    let fitted = scalings.iter().filter_map(|scaling| scaling.serial_share);
    let fastest = fitted
        .map(|share| amdahl(share, most))
        .fold(fastest, f64::max);
    let mut chart = ChartBuilder::on(plot)
        .x_label_area_size(46)
        .y_label_area_size(64)
        .build_cartesian_2d(1.0..most, 0.0..1.08 * fastest)
        .map_err(drawing)?;
    chart
        .configure_mesh()
        .bold_line_style(GRID)
        .light_line_style(TRANSPARENT)
        .axis_style(INK)
        .label_style((FONT, 13).into_font().color(&INK))
        .axis_desc_style((FONT, 15).into_font().color(&INK))
        .x_desc("threads")
        .y_desc(format!("speed-up, {name} [-]"))
        .x_label_formatter(&|value| format!("{value:.0}"))
        .y_label_formatter(&|value| format!("{value:.1}"))
        .draw()
        .map_err(drawing)?;
    let area = chart.plotting_area();
    let linear = vec![(1.0, 1.0), (most.min(fastest), most.min(fastest))];
    area.draw(&PathElement::new(linear, GRID.stroke_width(2)))
        .map_err(drawing)?;
    let corner = plot.get_pixel_range();
    let (left, mut y) = (corner.0.start + 90, corner.1.start + 16);
    for (number, scaling) in scalings.iter().enumerate() {
        let colour = COLOURS[number % COLOURS.len()];
        let mut words = scaling.series.clone();
        if let Some(share) = scaling.serial_share {
            let threads = |k: u32| 1.0 + (most - 1.0) * f64::from(k) / f64::from(POINTS);
            let curve = (0..=POINTS).map(|k| (threads(k), amdahl(share, threads(k))));
            area.draw(&PathElement::new(
                curve.collect::<Vec<_>>(),
                colour.stroke_width(2),
            ))
            .map_err(drawing)?;
            words += &format!(": {:.1} % serial (Amdahl's law, fitted)", 100.0 * share);
        }
        for point in &scaling.points {
            area.draw(&Circle::new(*point, RADIUS, colour.filled()))
                .map_err(drawing)?;
        }
        for point in &scaling.reference {
            area.draw(&Circle::new(*point, RADIUS, colour.stroke_width(2)))
                .map_err(drawing)?;
        }
        root.draw(&Circle::new((left, y), RADIUS, colour.filled()))
            .map_err(drawing)?;
        text(root, &words, (left + 14, y), 14.0, At::Left)?;
        y += 22;
    }
    if scalings.iter().any(|scaling| !scaling.reference.is_empty()) {
        root.draw(&Circle::new((left, y), RADIUS, INK.stroke_width(2)))
            .map_err(drawing)?;
        text(
            root,
            "open: the reference's; grey: as many times as threads",
            (left + 14, y),
            14.0,
            At::Left,
        )?;
    }
    Ok(())
}
