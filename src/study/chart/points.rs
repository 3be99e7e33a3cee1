//! One column over another, one point per row, on logarithmic axes.

use plotters::prelude::*;

use super::axes::{self, PlotAxis};
use super::canvas::{Area, At, COLOURS, ChartError, Drawn, drawing, on_canvas, text, width_of};
use crate::study::{Table, stability::Scale};

/// Height of title and legend \[px].
const HEAD: u32 = 54;
/// Height of a panel \[px].
const HEIGHT: u32 = 586;
/// Size of the points' labels \[px].
const LABEL: f64 = 13.0;
/// Radius of a point \[px].
const RADIUS: i32 = 5;

/// Points of one colour, connected in their order.
struct Series {
    name: String,
    points: Vec<(f64, f64, String)>,
}

pub(super) fn draw(table: &Table, x: &str, y: &[String]) -> Result<String, ChartError> {
    let x = table.column(x).ok_or(ChartError::Empty)?;
    let columns = y.iter().filter_map(|y| table.column(y));
    let panels: Vec<_> = columns.map(|y| (y, series(table, x, y))).collect();
    let panels = || {
        let full = |panel: &&(usize, Vec<Series>)| panel.1.iter().any(|s| !s.points.is_empty());
        panels.iter().filter(full)
    };
    let (Some((_, first)), count) = (panels().next(), panels().count()) else {
        return Err(ChartError::Empty);
    };
    on_canvas(&table.title, HEAD + count as u32 * HEIGHT, |root| {
        legend(root, first)?;
        let (_, body) = root.split_vertically(HEAD);
        for (area, (y, series)) in body.split_evenly((count, 1)).iter().zip(panels()) {
            panel(root, &area.margin(30, 8, 8, 16), table, (x, *y), series)?;
        }
        Ok(())
    })
}

/// Draws series into a part of the canvas, with columns `x` and `y` along its axes.
fn panel<'a>(
    root: &Area<'a>,
    plot: &Area<'a>,
    table: &Table,
    (x, y): (usize, usize),
    series: &[Series],
) -> Drawn {
    let points = || series.iter().flat_map(|series| &series.points);
    let range = |of: &dyn Fn(&(f64, f64, String)) -> f64| {
        let logs = points().map(|point| of(point).log10());
        let (low, high) = logs.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), log| {
            (low.min(log), high.max(log))
        });
        // So wide that there are three ticks at least.
        let room = (0.5 * (0.8 - (high - low))).max(0.18);
        (low - room)..(high + room)
    };
    let log = |column, range| PlotAxis {
        label: axis(table, column),
        scale: Scale::Log,
        range,
    };
    let across = log(x, range(&|point| point.0));
    let along = log(y, range(&|point| point.1));
    let area = axes::plot(root, plot, &across, &along)?;
    let mut taken = Vec::new();
    let mut labels = Vec::new();
    for (number, series) in series.iter().enumerate() {
        let colour = COLOURS[number % COLOURS.len()];
        let line: Vec<_> = series
            .points
            .iter()
            .map(|point| (point.0.log10(), point.1.log10()))
            .collect();
        area.draw(&PathElement::new(line.clone(), colour.stroke_width(1)))
            .map_err(drawing)?;
        for (place, label) in line.iter().zip(series.points.iter().map(|point| &point.2)) {
            match number / COLOURS.len() {
                0 => area.draw(&Circle::new(*place, RADIUS, colour.filled())),
                _ => area.draw(&TriangleMarker::new(*place, RADIUS + 2, colour.filled())),
            }
            .map_err(drawing)?;
            let at = area.map_coordinate(place);
            taken.push(Frame::around(at));
            labels.push((at, label.clone()));
        }
    }
    // The range of the canvas, not of the plot: `map_coordinate` counts from the canvas's corner.
    let (columns, rows) = area.get_pixel_range();
    let bounds = Frame::new((columns.start, rows.start), (columns.end, rows.end));
    axes::frame(root, &area)?;
    for (at, label) in labels {
        let frame = free_place(at, &label, &taken, bounds);
        text(root, &label, frame.left_middle(), LABEL, At::Left)?;
        taken.push(frame);
    }
    Ok(())
}

/// Name and unit of a column, for an axis.
fn axis(table: &Table, column: usize) -> String {
    let column = &table.columns[column];
    match column.measure.unit() {
        "" => column.name.clone(),
        unit => format!("{} [{unit}]", column.name),
    }
}

/// The rows whose figures are both above zero, by series, in the order of the study. A series without such a row is
/// kept, so that each series has the same colour in all panels.
fn series(table: &Table, x: usize, y: usize) -> Vec<Series> {
    let mut all: Vec<Series> = Vec::new();
    for (k, row) in table.rows.iter().enumerate() {
        let name = row.series.clone().unwrap_or_else(|| row.variant.clone());
        let place = all.iter().position(|series| series.name == name);
        let place = place.unwrap_or_else(|| {
            all.push(Series {
                name: name.clone(),
                points: Vec::new(),
            });
            all.len() - 1
        });
        let (Some(x), Some(y)) = (table.figure(k, x), table.figure(k, y)) else {
            continue;
        };
        if row.failure.is_some() || x.value <= 0.0 || y.value <= 0.0 {
            continue;
        }
        // The legend already names the series, so the labels of its points need not.
        let label = row.label();
        let label = match label.strip_prefix(&name).map(str::trim) {
            Some("") | None => label,
            Some(rest) => rest.trim_start_matches([',', ' ']).to_owned(),
        };
        all[place].points.push((x.value, y.value, label));
    }
    all
}

/// A rectangle on the canvas \[px].
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Frame {
    left: i32,
    top: i32,
    right: i32,
    bottom: i32,
}

impl Frame {
    /// From its upper left and its lower right corner.
    pub(super) fn new((left, top): (i32, i32), (right, bottom): (i32, i32)) -> Self {
        Self {
            left,
            top,
            right,
            bottom,
        }
    }

    /// The place of a text in it.
    pub(super) fn left_middle(&self) -> (i32, i32) {
        (self.left, (self.top + self.bottom) / 2)
    }

    pub(super) fn around((x, y): (i32, i32)) -> Self {
        Self {
            left: x - RADIUS,
            top: y - RADIUS,
            right: x + RADIUS,
            bottom: y + RADIUS,
        }
    }

    fn meets(&self, other: &Self) -> bool {
        self.left < other.right
            && other.left < self.right
            && self.top < other.bottom
            && other.top < self.bottom
    }

    fn lies_in(&self, other: &Self) -> bool {
        self.left >= other.left
            && self.right <= other.right
            && self.top >= other.top
            && self.bottom <= other.bottom
    }
}

/// A free position for a label beside its point, away from other points and labels, if there is one.
pub(super) fn free_place((x, y): (i32, i32), label: &str, taken: &[Frame], bounds: Frame) -> Frame {
    let (width, height) = (width_of(label, LABEL), LABEL as i32 + 2);
    let gap = RADIUS + 4;
    let at = |left: i32, middle: i32| Frame {
        left,
        top: middle - height / 2,
        right: left + width,
        bottom: middle + height / 2,
    };
    let places = [1, 2, 3].into_iter().flat_map(|far| {
        let up = far * (height / 2 + RADIUS);
        [
            at(x + gap, y - (far - 1) * height),
            at(x - gap - width, y - (far - 1) * height),
            at(x + gap, y - up),
            at(x - width / 2, y - up - 2),
            at(x - gap - width, y - up),
            at(x + gap, y + up),
            at(x - width / 2, y + up + 2),
            at(x - gap - width, y + up),
        ]
    });
    let is_free =
        |frame: &Frame| frame.lies_in(&bounds) && taken.iter().all(|other| !other.meets(frame));
    let mut places = places.peekable();
    let first = places.peek().copied().unwrap_or(bounds);
    places.find(is_free).unwrap_or(first)
}

/// The legend, a line below the title.
fn legend(root: &Area, series: &[Series]) -> Drawn {
    const Y: i32 = 42;
    let mut x = 22;
    for (number, series) in series.iter().enumerate() {
        let colour = COLOURS[number % COLOURS.len()];
        let mark: Result<(), _> = match number / COLOURS.len() {
            0 => root.draw(&Circle::new((x, Y), RADIUS, colour.filled())),
            _ => root.draw(&TriangleMarker::new((x, Y), RADIUS + 2, colour.filled())),
        };
        mark.map_err(drawing)?;
        x += 14;
        text(root, &series.name, (x, Y), 14.0, At::Left)?;
        x += width_of(&series.name, 14.0) + 24;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn labels_keep_away_from_each_other_and_from_the_edge() {
        let bounds = Frame {
            left: 0,
            top: 0,
            right: 400,
            bottom: 300,
        };
        let points = [(390, 150), (380, 150), (384, 158)];
        let mut taken: Vec<Frame> = points.iter().map(|&at| Frame::around(at)).collect();
        for at in points {
            let frame = free_place(at, "a label", &taken, bounds);
            assert!(frame.lies_in(&bounds), "{frame:?}");
            assert!(taken.iter().all(|other| !other.meets(&frame)), "{frame:?}");
            taken.push(frame);
        }
    }
}
