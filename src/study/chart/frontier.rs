//! Wall time over error: points with the spread of their times, the front that nothing beats, and what failed.

use plotters::prelude::*;

use super::axes::{self, Plot, PlotAxis};
use super::canvas::{
    Area, At, COLOURS, ChartError, Drawn, INK, drawing, on_canvas, text, width_of,
};
use super::points::{Frame, free_place};
use crate::study::stability::{Class, Scale};

/// Height of title and legend \[px].
const HEAD: u32 = 60;
/// Height of a panel \[px].
const HEIGHT: u32 = 520;
/// Height of the lines below the panels \[px].
const FOOT: u32 = 30;
/// Height of the strip above the error axis that holds what failed, as a part of the axis.
const STRIP: f64 = 0.09;
const LABEL: f64 = 12.0;
const FRONT: RGBColor = RGBColor(120, 120, 120);

/// A chart of one or more errors.
pub struct FrontierPicture {
    /// Heading.
    pub title: String,
    /// Names of the series, in the order of their colours.
    pub series: Vec<String>,
    /// A panel for each figure.
    pub panels: Vec<FrontierPanel>,
    /// Machine, date and program, for the line below.
    pub source: String,
}

/// The error of one figure.
pub struct FrontierPanel {
    /// What the error is of.
    pub figure: String,
    /// The points.
    pub points: Vec<FrontierPoint>,
    /// Numbers of the points that nothing beats, the cheapest first.
    pub front: Vec<usize>,
    /// What failed: number of the series, wall time per simulated time if some passed \[s/s], class.
    pub failed: Vec<(usize, Option<f64>, Class)>,
}

/// A point of a panel.
pub struct FrontierPoint {
    /// Number of its series.
    pub series: usize,
    /// Its settings.
    pub label: String,
    /// Wall time per simulated time \[s/s]: median, least and greatest of the repeats.
    pub cost: [f64; 3],
    /// Error \[-].
    pub error: f64,
}

impl FrontierPoint {
    /// Whether it has a place on logarithmic axes.
    fn is_drawn(&self) -> bool {
        let positive = |value: f64| value > 0.0 && value.is_finite();
        positive(self.error) && self.cost.into_iter().all(positive)
    }
}

/// Draws one panel for each figure that has a point. Fails if none has.
pub fn draw(picture: &FrontierPicture) -> Result<String, ChartError> {
    let has_points = |panel: &&FrontierPanel| panel.points.iter().any(FrontierPoint::is_drawn);
    let panels: Vec<&FrontierPanel> = picture.panels.iter().filter(has_points).collect();
    if panels.is_empty() {
        return Err(ChartError::Empty);
    }
    let height = panels.len() as u32 * HEIGHT;
    on_canvas(&picture.title, HEAD + height + FOOT, |root| {
        legend(root, picture)?;
        let (_, body) = root.split_vertically(HEAD);
        let (body, foot) = body.split_vertically(height);
        for (area, panel) in body.split_evenly((panels.len(), 1)).iter().zip(panels) {
            draw_panel(root, area, panel)?;
        }
        text(&foot, &picture.source, (16, 12), 11.0, At::Left)
    })
}

/// Draws the mark of a series, circles first, then squares.
fn mark(area: &Area, series: usize, (x, y): (i32, i32)) -> Drawn {
    let colour = COLOURS[series % COLOURS.len()].filled();
    if series < COLOURS.len() {
        area.draw(&Circle::new((x, y), 5, colour)).map_err(drawing)
    } else {
        area.draw(&Rectangle::new([(x - 4, y - 4), (x + 5, y + 5)], colour))
            .map_err(drawing)
    }
}

fn legend(root: &Area, picture: &FrontierPicture) -> Drawn {
    const Y: i32 = 42;
    let mut x = 22;
    for (number, name) in picture.series.iter().enumerate() {
        mark(root, number, (x, Y))?;
        text(root, name, (x + 14, Y), 13.0, At::Left)?;
        x += 36 + width_of(name, 13.0);
    }
    axes::line(root, (x, Y), (x + 24, Y), FRONT)?;
    text(
        root,
        "nothing is as good for less time",
        (x + 30, Y),
        13.0,
        At::Left,
    )
}

/// The range of some values on a logarithmic axis, with room around them.
fn range(values: impl Iterator<Item = f64>) -> std::ops::Range<f64> {
    let logs = values.filter(|value| *value > 0.0).map(f64::log10);
    let (low, high) = logs.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), log| {
        (low.min(log), high.max(log))
    });
    // So wide that there are three ticks at least.
    let room = (0.5 * (0.8 - (high - low))).max(0.15);
    (low - room)..(high + room)
}

fn draw_panel<'a>(root: &Area<'a>, area: &Area<'a>, panel: &FrontierPanel) -> Drawn {
    let points: Vec<&FrontierPoint> = panel
        .points
        .iter()
        .filter(|point| point.is_drawn())
        .collect();
    let costs = points.iter().flat_map(|point| point.cost);
    let x = range(costs.chain(panel.failed.iter().filter_map(|failed| failed.1)));
    let y = range(points.iter().map(|point| point.error));
    let strip = STRIP * (y.end - y.start);
    let log = |label: String, range| PlotAxis {
        label,
        scale: Scale::Log,
        range,
    };
    let across = log("wall time per simulated time [s/s]".into(), x.clone());
    let along = log(
        format!("error of {}", panel.figure),
        y.start..(y.end + strip),
    );
    let plot = axes::plot(root, &area.margin(30, 4, 8, 16), &across, &along)?;
    let at = |cost: f64, error: f64| plot.map_coordinate(&(cost.log10(), error.log10()));
    let corners: Vec<(i32, i32)> = (panel.front.iter())
        .filter_map(|&k| panel.points.get(k))
        .filter(|point| point.is_drawn())
        .map(|point| at(point.cost[0], point.error))
        .collect();
    // What costs more than a point and has its error is on no better side of it: the front goes in steps.
    for pair in corners.windows(2) {
        let corner = (pair[1].0, pair[0].1);
        axes::line(root, pair[0], corner, FRONT)?;
        axes::line(root, corner, pair[1], FRONT)?;
    }
    for point in &points {
        let colour = COLOURS[point.series % COLOURS.len()];
        let [low, high] = [point.cost[1], point.cost[2]].map(|cost| at(cost, point.error));
        axes::line(root, low, high, colour)?;
        for end in [low, high] {
            axes::line(root, (end.0, end.1 - 3), (end.0, end.1 + 3), colour)?;
        }
        mark(root, point.series, at(point.cost[0], point.error))?;
    }
    labels(root, &plot, panel, &at)?;
    failures(root, &plot, panel, (x.start, y.end + 0.5 * strip))?;
    axes::frame(root, &plot)
}

/// Writes the settings of the points that nothing beats.
fn labels(
    root: &Area,
    plot: &Plot,
    panel: &FrontierPanel,
    at: &dyn Fn(f64, f64) -> (i32, i32),
) -> Drawn {
    let drawn = panel.points.iter().filter(|point| point.is_drawn());
    let mut taken: Vec<Frame> = drawn
        .map(|point| Frame::around(at(point.cost[0], point.error)))
        .collect();
    let (columns, rows) = plot.get_pixel_range();
    let bounds = Frame::new((columns.start, rows.start), (columns.end, rows.end));
    for point in panel
        .front
        .iter()
        .filter_map(|&k| panel.points.get(k))
        .filter(|point| point.is_drawn())
    {
        let frame = free_place(at(point.cost[0], point.error), &point.label, &taken, bounds);
        text(root, &point.label, frame.left_middle(), LABEL, At::Left)?;
        taken.push(frame);
    }
    Ok(())
}

/// Crosses in the strip above the errors, at the cost until then, with their class.
fn failures(root: &Area, plot: &Plot, panel: &FrontierPanel, (least, height): (f64, f64)) -> Drawn {
    let mut taken = i32::MIN;
    let mut failed: Vec<_> = panel.failed.iter().collect();
    failed.sort_by(|a, b| a.1.unwrap_or(0.0).total_cmp(&b.1.unwrap_or(0.0)));
    for (series, cost, class) in failed {
        let place = cost.filter(|cost| *cost > 0.0).map_or(least, f64::log10);
        let (x, y) = plot.map_coordinate(&(place, height));
        let colour = COLOURS[series % COLOURS.len()];
        for (dx, dy) in [(5, 5), (5, -5)] {
            axes::line(root, (x - dx, y - dy), (x + dx, y + dy), colour)?;
        }
        // Names that would lie on each other are left out: the table has them all.
        if x > taken {
            text(root, class.name(), (x + 8, y), 11.0, At::Left)?;
            taken = x + 12 + width_of(class.name(), 11.0);
        }
    }
    let bottom = plot.map_coordinate(&(least, height)).1 + 14;
    let columns = plot.get_pixel_range().0;
    if !panel.failed.is_empty() {
        axes::line(root, (columns.start, bottom), (columns.end, bottom), INK)?;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn picture(
        points: Vec<FrontierPoint>,
        failed: Vec<(usize, Option<f64>, Class)>,
    ) -> FrontierPicture {
        FrontierPicture {
            title: "T".into(),
            series: vec!["DFSPH".into(), "SESPH".into()],
            panels: vec![FrontierPanel {
                figure: "front".into(),
                front: (0..points.len()).collect(),
                points,
                failed,
            }],
            source: "a machine".into(),
        }
    }

    fn point(cost: f64, error: f64) -> FrontierPoint {
        FrontierPoint {
            series: 0,
            label: format!("at {cost}"),
            cost: [cost, 0.9 * cost, 1.1 * cost],
            error,
        }
    }

    #[test]
    fn a_chart_has_ticks_labels_failures_and_its_source() {
        let svg = draw(&picture(
            vec![point(10.0, 0.01), point(11.0, 0.009)],
            vec![(1, None, Class::Exploded)],
        ));
        let svg = svg.expect("a chart");
        let words: Vec<&str> = svg.lines().map(str::trim).collect();
        for part in [
            "at 10",
            "at 11",
            "exploded",
            "error of front",
            "a machine",
            "SESPH",
            "20",
            "10",
            "5",
            "0.01",
        ] {
            assert!(words.contains(&part), "{part} is not in {svg}");
        }
        assert!(draw(&picture(vec![point(0.0, 1.0), point(1.0, 0.0)], Vec::new())).is_err());
    }
}
