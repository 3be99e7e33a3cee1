//! The wall time of a step by phase, as stacked bars of the same length.

use plotters::prelude::*;

use super::canvas::{
    Area, At, COLOURS, ChartError, Drawn, INK, WIDTH, drawing, on_canvas, text, width_of,
};
use crate::{
    state::Phase,
    study::{Block, Table},
};

/// Height of a row \[px].
const ROW: i32 = 34;
/// Height of a bar \[px].
const BAR: i32 = 22;
/// Space for title and legend \[px].
const TOP: i32 = 84;
/// Space for the time of a step, right of the bars \[px].
const TOTAL: i32 = 130;
/// Narrowest part of a bar whose share is written in it \[px].
const WRITTEN: i32 = 34;

fn colour(phase: usize) -> RGBColor {
    let greys = [RGBColor(150, 150, 150), RGBColor(90, 90, 90)];
    *COLOURS.get(phase).unwrap_or(&greys[phase % greys.len()])
}

/// The name of a phase as study files write it.
fn name(phase: Phase) -> String {
    let debug = format!("{phase:?}");
    let mut words = String::new();
    for letter in debug.chars() {
        if letter.is_uppercase() && !words.is_empty() {
            words.push(' ');
        }
        words.extend(letter.to_lowercase());
    }
    words
}

pub(super) fn draw(table: &Table) -> Result<String, ChartError> {
    let rows: Vec<(String, Block)> = (table.rows.iter())
        .filter(|row| !row.blocks.is_empty())
        .map(|row| (row.label(), Block::together(&row.blocks)))
        .filter(|(_, block)| block.steps > 0 && block.phase_seconds.iter().sum::<f64>() > 0.0)
        .collect();
    if rows.is_empty() {
        return Err(ChartError::Empty);
    }
    let height = TOP + rows.len() as i32 * ROW + 12;
    let widest = rows.iter().map(|(label, _)| width_of(label, 14.0)).max();
    let left = (widest.unwrap_or(0) + 24).min(WIDTH as i32 / 2);
    on_canvas(&table.title, height as u32, |root| {
        legend(root)?;
        for (k, (label, block)) in rows.iter().enumerate() {
            let top = TOP + k as i32 * ROW;
            text(root, label, (left - 8, top + BAR / 2), 14.0, At::Right)?;
            bar(root, block, (left, top))?;
        }
        Ok(())
    })
}

fn legend(root: &Area) -> Drawn {
    let (mut x, mut y) = (16, 36);
    for (k, phase) in Phase::ALL.into_iter().enumerate() {
        let words = name(phase);
        let width = 36 + width_of(&words, 14.0);
        if x + width > WIDTH as i32 {
            (x, y) = (16, y + 22);
        }
        rectangle(root, (x, y), (x + 14, y + 14), colour(k))?;
        text(root, &words, (x + 20, y + 7), 14.0, At::Left)?;
        x += width;
    }
    Ok(())
}

fn bar(root: &Area, block: &Block, (left, top): (i32, i32)) -> Drawn {
    let whole: f64 = block.phase_seconds.iter().sum();
    let width = f64::from(WIDTH as i32 - TOTAL - left);
    let mut before = 0.0;
    for (k, seconds) in block.phase_seconds.iter().enumerate() {
        let at = |seconds: f64| left + (seconds / whole * width).round() as i32;
        let (from, to) = (at(before), at(before + seconds));
        before += seconds;
        if to <= from {
            continue;
        }
        rectangle(root, (from, top), (to, top + BAR), colour(k))?;
        if to - from >= WRITTEN {
            let words = format!("{:.0} %", 100.0 * seconds / whole);
            let style = TextStyle::from((super::canvas::FONT, 12.0).into_font()).color(&WHITE);
            let place = (from + 5, top + 6);
            root.draw(&Text::new(words, place, style))
                .map_err(drawing)?;
        }
    }
    let step = 1e3 * whole / block.steps as f64;
    let words = format!("{} ms a step", crate::study::text::short(step));
    let place = (WIDTH as i32 - TOTAL + 10, top + BAR / 2);
    text(root, &words, place, 13.0, At::Left)?;
    let frame = [(left, top), (left + width as i32, top + BAR)];
    root.draw(&Rectangle::new(frame, INK.stroke_width(1)))
        .map_err(drawing)
}

fn rectangle(root: &Area, from: (i32, i32), to: (i32, i32), colour: RGBColor) -> Drawn {
    root.draw(&Rectangle::new([from, to], colour.filled()))
        .map_err(drawing)
}
