//! A stability map: the classes of all points over two axes, with lines of equal cost and of theory.

use plotters::prelude::*;

use super::axes::{self, Plot, PlotAxis, tick};
use super::canvas::{Area, At, ChartError, Drawn, INK, WIDTH, drawing, on_canvas, text, width_of};
use super::contour::{Piece, pieces};
use crate::study::stability::{
    Axis, Class, PlannedMap, PointOf, Reading, Scale, StabilityPlan, Values, shares_of_limits,
};

/// Height of title and legend \[px].
const HEAD: u32 = 92;
/// Height of a panel \[px].
const HEIGHT: u32 = 400;
/// Height of the lines below the panels \[px].
const FOOT: u32 = 30;
/// Most lines of equal cost.
const MOST_LINES: usize = 7;
const COST: RGBColor = RGBColor(70, 70, 70);
/// Colours of the lines of theory.
const LINES: [RGBColor; 4] = [
    RGBColor(0, 0, 0),
    RGBColor(0, 60, 140),
    RGBColor(120, 0, 120),
    RGBColor(120, 60, 0),
];

/// What a map shows.
pub struct MapPicture<'a> {
    /// The study.
    pub plan: &'a StabilityPlan,
    /// The variant.
    pub map: &'a PlannedMap,
    /// Readings of the study.
    pub readings: &'a [Reading],
    /// Machine, date and program, for the line below.
    pub source: String,
}

/// A line of theory, or of equal cost, in places of the axes.
struct Line {
    name: String,
    pieces: Vec<Piece>,
}

/// Draws one panel for each of the study's numbers of steps. Fails if no point is finished.
pub fn draw(picture: &MapPicture) -> Result<String, ChartError> {
    let MapPicture { plan, map, .. } = picture;
    let readings: Vec<&Reading> = (picture.readings.iter())
        .filter(|of| of.variant == map.name)
        .collect();
    if readings.is_empty() {
        return Err(ChartError::Empty);
    }
    let theory = theory(plan, map);
    let after = &plan.study.after;
    let title = format!("{}: {}", plan.study.title(), map.name);
    on_canvas(&title, HEAD + after.len() as u32 * HEIGHT + FOOT, |root| {
        legend(root, plan, &readings, &theory)?;
        let (_, body) = root.split_vertically(HEAD);
        let (body, foot) = body.split_vertically(after.len() as u32 * HEIGHT);
        for (area, &steps) in body.split_evenly((after.len(), 1)).iter().zip(after) {
            let of_steps: Vec<&Reading> = readings
                .iter()
                .copied()
                .filter(|of| of.after == steps)
                .collect();
            panel(root, area, picture, steps, &of_steps, &theory)?;
        }
        text(&foot, &picture.source, (16, 12), 11.0, At::Left)
    })
}

fn colour(class: Class) -> RGBColor {
    match class {
        Class::Stable => RGBColor(120, 200, 170),
        Class::Drifting => RGBColor(240, 228, 66),
        Class::Compressed => RGBColor(86, 180, 233),
        Class::NotConverged => RGBColor(230, 159, 0),
        Class::Leaking => RGBColor(204, 121, 167),
        Class::Exploded => RGBColor(213, 94, 0),
        Class::Refused => RGBColor(190, 190, 190),
        Class::OutOfTime => RGBColor(90, 90, 90),
    }
}

/// Classes that occur, and the lines.
fn legend(root: &Area, plan: &StabilityPlan, readings: &[&Reading], theory: &[Line]) -> Drawn {
    const Y: i32 = 42;
    let mut x = 16;
    for class in Class::ALL {
        if !readings.iter().any(|reading| reading.class == class) {
            continue;
        }
        let square = Rectangle::new([(x, Y - 6), (x + 14, Y + 7)], colour(class).filled());
        root.draw(&square).map_err(drawing)?;
        text(root, class.name(), (x + 20, Y), 13.0, At::Left)?;
        x += 32 + width_of(class.name(), 13.0);
    }
    let seeds = plan.seeds().len();
    if seeds > 1 {
        let words = format!("a cell is shared by its {seeds} seeds");
        text(root, &words, (x, Y), 13.0, At::Left)?;
    }
    let mut x = 16;
    let cost = "wall time per simulated time [s/s]".to_owned();
    let lines = [(cost, COST)].into_iter();
    let lines = lines.chain(
        theory
            .iter()
            .enumerate()
            .map(|(k, line)| (format!("limit by {}", line.name), LINES[k % LINES.len()])),
    );
    for (k, (name, colour)) in lines.enumerate() {
        let width = if k == 0 { 1 } else { 3 };
        let mark = vec![(x, Y + 22), (x + 22, Y + 22)];
        root.draw(&PathElement::new(mark, colour.stroke_width(width)))
            .map_err(drawing)?;
        text(root, &name, (x + 28, Y + 22), 13.0, At::Left)?;
        x += 42 + width_of(&name, 13.0);
    }
    Ok(())
}

/// Borders of the cells around ascending values, in places of the axis.
fn borders(axis: &Axis, values: &[f64]) -> Vec<f64> {
    let places: Vec<f64> = values
        .iter()
        .map(|&value| axis.scale.place(value))
        .collect();
    let half = |a: f64, b: f64| 0.5 * (a + b);
    let (Some(&first), Some(&last)) = (places.first(), places.last()) else {
        return Vec::new();
    };
    let alone = match axis.scale {
        Scale::Log => 0.15,
        Scale::Linear => 0.5,
    };
    let before = places.get(1).map_or(alone, |next| half(*next, -first));
    let behind = match places.len() {
        0 | 1 => alone,
        n => half(last, -places[n - 2]),
    };
    let inner = places.windows(2).map(|pair| half(pair[0], pair[1]));
    [first - before]
        .into_iter()
        .chain(inner)
        .chain([last + behind])
        .collect()
}

fn panel<'a>(
    root: &Area<'a>,
    area: &Area<'a>,
    picture: &MapPicture,
    steps: u64,
    readings: &[&Reading],
    theory: &[Line],
) -> Drawn {
    let map = picture.map;
    let xs = map.x.known_values();
    let mut ys: Vec<f64> = map.y.known_values();
    if matches!(map.y.values, Values::Edge { .. }) {
        ys.extend(readings.iter().map(|reading| reading.y));
        ys.sort_by(f64::total_cmp);
        ys.dedup();
    }
    let (columns, rows) = (borders(&map.x, &xs), borders(&map.y, &ys));
    let axis = |of: &Axis, borders: &[f64]| PlotAxis {
        label: of.label(),
        scale: of.scale,
        range: borders[0]..borders[borders.len() - 1],
    };
    let inner = area.margin(34, 4, 8, 16);
    let plot = axes::plot(root, &inner, &axis(&map.x, &columns), &axis(&map.y, &rows))?;
    let heading = format!("after {steps} steps");
    text(
        root,
        &heading,
        (WIDTH as i32 / 2, plot.get_pixel_range().1.start - 12),
        14.0,
        At::Left,
    )?;
    if matches!(map.y.values, Values::Edge { .. }) {
        search(&plot, map, &columns, &xs, readings)?;
    } else {
        cells(root, &plot, (&columns, &rows), (&xs, &ys), readings)?;
        for line in cost(map, &xs, &ys, readings) {
            curve(root, &plot, &line, COST, 1, true)?;
        }
    }
    for (k, line) in theory.iter().enumerate() {
        curve(root, &plot, line, LINES[k % LINES.len()], 3, false)?;
    }
    axes::frame(root, &plot)
}

/// Fills every cell with the colours of its runs, side by side, and says how many of them are stable if not all agree.
fn cells(
    root: &Area,
    plot: &Plot,
    (columns, rows): (&[f64], &[f64]),
    (xs, ys): (&[f64], &[f64]),
    readings: &[&Reading],
) -> Drawn {
    for (i, &x) in xs.iter().enumerate() {
        for (j, &y) in ys.iter().enumerate() {
            let runs = readings
                .iter()
                .filter(|reading| reading.x == x && reading.y == y);
            let mut classes: Vec<Class> = runs.map(|reading| reading.class).collect();
            let place = |class: &Class| Class::ALL.iter().position(|other| other == class);
            classes.sort_by_key(place);
            let (left, right) = (columns[i], columns[i + 1]);
            let part = (right - left) / classes.len().max(1) as f64;
            for (k, &class) in classes.iter().enumerate() {
                let low = left + k as f64 * part;
                let corners = [(low, rows[j]), (low + part, rows[j + 1])];
                plot.draw(&Rectangle::new(corners, colour(class).filled()))
                    .map_err(drawing)?;
            }
            let stable = classes
                .iter()
                .filter(|class| **class == Class::Stable)
                .count();
            if stable > 0 && stable < classes.len() {
                let words = format!("{stable}/{}", classes.len());
                let (at_x, at_y) =
                    plot.map_coordinate(&(0.5 * (left + right), 0.5 * (rows[j] + rows[j + 1])));
                let left = at_x - width_of(&words, 11.0) / 2;
                text(root, &words, (left, at_y), 11.0, At::Left)?;
            }
        }
    }
    Ok(())
}

/// The runs of an edge's search as points, the seeds of an x side by side.
fn search(
    plot: &Plot,
    map: &PlannedMap,
    columns: &[f64],
    xs: &[f64],
    readings: &[&Reading],
) -> Drawn {
    let mut seeds: Vec<Option<u32>> = readings.iter().map(|reading| reading.seed).collect();
    seeds.sort_unstable();
    seeds.dedup();
    for reading in readings {
        let Some(i) = xs.iter().position(|x| *x == reading.x) else {
            continue;
        };
        let number = seeds
            .iter()
            .position(|seed| *seed == reading.seed)
            .unwrap_or(0);
        let part = (number as f64 + 0.5) / seeds.len() as f64;
        let x = columns[i] + (0.2 + 0.6 * part) * (columns[i + 1] - columns[i]);
        let place = (x, map.y.scale.place(reading.y));
        plot.draw(&Circle::new(place, 5, colour(reading.class).filled()))
            .map_err(drawing)?;
        plot.draw(&Circle::new(place, 5, INK.stroke_width(1)))
            .map_err(drawing)?;
    }
    Ok(())
}

/// Draws a line, with its name at its right end.
fn curve(
    root: &Area,
    plot: &Plot,
    line: &Line,
    colour: RGBColor,
    width: u32,
    named: bool,
) -> Drawn {
    for piece in &line.pieces {
        plot.draw(&PathElement::new(
            piece.to_vec(),
            colour.stroke_width(width),
        ))
        .map_err(drawing)?;
    }
    let end = line
        .pieces
        .iter()
        .flatten()
        .max_by(|a, b| a.0.total_cmp(&b.0));
    if let Some(end) = end.filter(|_| named) {
        let (x, y) = plot.map_coordinate(end);
        text(root, &line.name, (x + 4, y), 11.0, At::Left)?;
    }
    Ok(())
}

/// Lines of equal cost between the points whose runs were finished.
fn cost(map: &PlannedMap, xs: &[f64], ys: &[f64], readings: &[&Reading]) -> Vec<Line> {
    let at = |i: usize, j: usize| {
        let runs = readings.iter().filter(|of| of.x == xs[i] && of.y == ys[j]);
        let finished = runs.filter(|of| of.reason.is_empty() && of.steps >= of.after);
        let mut costs: Vec<f64> = finished
            .filter_map(|of| of.cost)
            .filter(|cost| *cost > 0.0)
            .collect();
        costs.sort_by(f64::total_cmp);
        costs.get(costs.len() / 2).map(|cost| cost.log10())
    };
    let all: Vec<f64> = (0..xs.len())
        .flat_map(|i| (0..ys.len()).map(move |j| (i, j)))
        .filter_map(|(i, j)| at(i, j))
        .collect();
    let range = all
        .iter()
        .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), &value| {
            (low.min(value), high.max(value))
        });
    if all.is_empty() {
        return Vec::new();
    }
    let mut levels = axes::ticks(&(range.0..range.1));
    while levels.len() > MOST_LINES {
        levels = levels.into_iter().step_by(2).collect();
    }
    let (px, py) = places(map, xs, ys);
    levels
        .into_iter()
        .map(|level| Line {
            name: tick(level),
            pieces: pieces(&px, &py, &at, level.log10()),
        })
        .filter(|line| !line.pieces.is_empty())
        .collect()
}

fn places(map: &PlannedMap, xs: &[f64], ys: &[f64]) -> (Vec<f64>, Vec<f64>) {
    let x = xs.iter().map(|&x| map.x.scale.place(x)).collect();
    (x, ys.iter().map(|&y| map.y.scale.place(y)).collect())
}

/// Where the time step is at each of its limits.
fn theory(plan: &StabilityPlan, map: &PlannedMap) -> Vec<Line> {
    let (xs, ys) = (map.x.known_values(), map.y.known_values());
    let seed = plan.seeds()[0];
    let shares: Vec<Vec<Vec<(&str, f64)>>> = xs
        .iter()
        .map(|&x| {
            let at = |&y: &f64| plan.scene(PointOf { map, x, y, seed });
            let shares = ys
                .iter()
                .map(|y| at(y).map(|scene| shares_of_limits(&scene)));
            shares.map(Result::unwrap_or_default).collect()
        })
        .collect();
    let mut names: Vec<&str> = shares
        .iter()
        .flatten()
        .flatten()
        .map(|share| share.0)
        .collect();
    names.sort_unstable();
    names.dedup();
    let (px, py) = places(map, &xs, &ys);
    let line = |name: &str| {
        let at = |i: usize, j: usize| {
            let share = shares[i][j].iter().find(|share| share.0 == name);
            share.map(|share| share.1.log10())
        };
        Line {
            name: name.to_owned(),
            pieces: pieces(&px, &py, &at, 0.0),
        }
    };
    names
        .into_iter()
        .map(line)
        .filter(|line| !line.pieces.is_empty())
        .collect()
}
