//! Ratios to the baseline as bars, ours above the reference's, one panel per column.

use plotters::prelude::*;

use super::canvas::{
    Area, At, COLOURS, ChartError, Drawn, GRID, WIDTH, drawing, on_canvas, text, width_of,
};
use crate::study::text::short;
use crate::study::{Order, Table};

/// Height of a row \[px].
const ROW: i32 = 38;
/// Height of one bar \[px].
const BAR: i32 = 14;
/// Space for a panel's heading, above its rows \[px].
const HEADING: i32 = 34;
/// Space for a panel's axis, below its rows \[px].
const AXIS: i32 = 34;
/// Space for title and legend, above the panels \[px].
const TOP: i32 = 62;
/// Space for the figures, right of the longest bar \[px].
const FIGURES: i32 = 170;
const HERE: RGBColor = COLOURS[0];
const REFERENCE: RGBColor = COLOURS[4];

struct Panel {
    column: usize,
    rows: Vec<usize>,
}

pub(super) fn draw(table: &Table, columns: &[String]) -> Result<String, ChartError> {
    let panels: Vec<Panel> = (columns.iter())
        .filter_map(|name| table.column(name))
        .map(|column| Panel {
            column,
            rows: (0..table.rows.len())
                .filter(|&row| table.ratio(row, column).is_some())
                .collect(),
        })
        .filter(|panel| !panel.rows.is_empty())
        .collect();
    if panels.is_empty() {
        return Err(ChartError::Empty);
    }
    let rows: usize = panels.iter().map(|panel| panel.rows.len()).sum();
    let height = TOP + rows as i32 * ROW + panels.len() as i32 * (HEADING + AXIS);
    on_canvas(&table.title, height as u32, |root| {
        legend(root, table)?;
        let mut top = TOP;
        for panel in &panels {
            draw_panel(root, table, panel, top)?;
            top += HEADING + AXIS + panel.rows.len() as i32 * ROW;
        }
        Ok(())
    })
}

fn legend(root: &Area, table: &Table) -> Drawn {
    let mut entries = vec![(HERE, "here, with the spread of the blocks")];
    if (0..table.columns.len()).any(|column| table.has_reference(column)) {
        entries.push((REFERENCE, "reference"));
    }
    let mut x = 16;
    for (colour, words) in entries {
        rectangle(root, (x, 36), (x + 14, 50), colour)?;
        text(root, words, (x + 20, 43), 14.0, At::Left)?;
        x += 40 + width_of(words, 14.0);
    }
    text(
        root,
        "≠ the order of the rows is not the reference's",
        (x, 43),
        14.0,
        At::Left,
    )
}

fn draw_panel(root: &Area, table: &Table, panel: &Panel, top: i32) -> Drawn {
    let column = panel.column;
    let labels: Vec<String> = (panel.rows.iter())
        .map(|&row| {
            let mark = match table.order(row, column) {
                Some(Order::Differs) => "≠ ",
                _ => "",
            };
            format!("{mark}{}", table.rows[row].label())
        })
        .collect();
    let widest = labels
        .iter()
        .map(|label| width_of(label, 14.0))
        .max()
        .unwrap_or(0);
    let left = (widest + 24).min(WIDTH as i32 / 2);
    let right = WIDTH as i32 - FIGURES;
    let reach = |row: usize| {
        let (ratio, figure) = (table.ratio(row, column)?, table.figure(row, column)?);
        Some(figure.high * ratio / figure.value)
    };
    let greatest = (panel.rows.iter())
        .flat_map(|&row| [reach(row), table.reference_ratio(row, column)])
        .flatten()
        .fold(1.0, f64::max);
    let at = |ratio: f64| left + (ratio / greatest * f64::from(right - left)).round() as i32;

    let heading = format!(
        "{}, ratio to {} [-]",
        table.columns[column].name,
        table.baseline()
    );
    text(root, &heading, (left, top + HEADING / 2), 15.0, At::Left)?;
    let (first, last) = (top + HEADING, top + HEADING + panel.rows.len() as i32 * ROW);
    for tick in ticks(greatest) {
        let x = at(tick);
        line(root, (x, first), (x, last), GRID)?;
        text(
            root,
            &short_tick(tick),
            (x - width_of(&short_tick(tick), 13.0) / 2, last + 12),
            13.0,
            At::Left,
        )?;
    }
    for (k, (&row, label)) in panel.rows.iter().zip(&labels).enumerate() {
        let y = first + k as i32 * ROW + 4;
        text(root, label, (left - 8, y + BAR), 14.0, At::Right)?;
        let unit = table.columns[column].measure.unit();
        // The figures are right of the bar and of its error bar, which ends at `end`.
        let bar = |y: i32, ratio: f64, end: i32, value: f64, colour: RGBColor| -> Drawn {
            rectangle(root, (left, y), (at(ratio), y + BAR), colour)?;
            let words = match unit {
                "" => format!("{ratio:.2} ({})", short(value)),
                unit => format!("{ratio:.2} ({} {unit})", short(value)),
            };
            let place = (end.max(at(ratio)) + 8, y + BAR / 2);
            text(root, &words, place, 12.0, At::Left)
        };
        if let Some((ratio, figure)) = table.ratio(row, column).zip(table.figure(row, column)) {
            let scale = ratio / figure.value;
            let (low, high) = (at(figure.low * scale), at(figure.high * scale));
            bar(y, ratio, high, figure.value, HERE)?;
            let middle = y + BAR / 2;
            line(root, (low, middle), (high, middle), BLACK)?;
            for end in [low, high] {
                line(root, (end, middle - 3), (end, middle + 3), BLACK)?;
            }
        }
        let reference = table
            .reference_ratio(row, column)
            .zip(table.reference(row, column));
        if let Some((ratio, value)) = reference {
            bar(y + BAR, ratio, 0, value, REFERENCE)?;
        }
    }
    line(root, (left, first), (left, last), BLACK)
}

/// About five round numbers from 0 to `greatest`.
fn ticks(greatest: f64) -> impl Iterator<Item = f64> {
    let raw = greatest / 5.0;
    let power = 10_f64.powf(raw.log10().floor());
    let step = [1.0, 2.0, 5.0, 10.0]
        .into_iter()
        .map(|factor| factor * power)
        .find(|&step| step >= raw)
        .unwrap_or(raw);
    (0..)
        .map(move |k| f64::from(k) * step)
        .take_while(move |&tick| tick <= greatest)
}

fn short_tick(tick: f64) -> String {
    let text = format!("{tick:.2}");
    text.trim_end_matches('0').trim_end_matches('.').to_owned()
}

fn rectangle(root: &Area, from: (i32, i32), to: (i32, i32), colour: RGBColor) -> Drawn {
    root.draw(&Rectangle::new([from, to], colour.filled()))
        .map_err(drawing)
}

fn line(root: &Area, from: (i32, i32), to: (i32, i32), colour: RGBColor) -> Drawn {
    root.draw(&PathElement::new(vec![from, to], colour))
        .map_err(drawing)
}

#[cfg(test)]
mod tests {
    use super::{short_tick, ticks};

    #[test]
    fn ticks_are_round_and_few() {
        assert_eq!(
            ticks(1.0).map(short_tick).collect::<Vec<_>>(),
            ["0", "0.2", "0.4", "0.6", "0.8", "1"]
        );
        assert_eq!(ticks(7.3).collect::<Vec<_>>(), [0.0, 2.0, 4.0, 6.0]);
        assert_eq!(ticks(120.0).count(), 3);
    }
}
