//! Time and colour bar, in the lower corners.

use glam::vec2;

use super::canvas::Canvas;
use super::colour::{Colours, linear};
use super::text;
use super::view::View;

/// Writes the time on the left and the colours of the range on the right.
pub(super) fn draw(canvas: &mut Canvas, time: f64, view: &View) {
    if !view.legend {
        return;
    }
    let (width, height) = (canvas.width as f32, canvas.height as f32);
    let letter = (height / 36.0).max(8.0);
    let margin = 1.6 * letter;
    let ink = linear([52, 62, 74]);
    let base = height - margin - letter;

    let time = format!("t = {time:.3} s");
    plate(
        canvas,
        [margin, margin + text::width(&time, letter)],
        base,
        letter,
    );
    text::write(canvas, &time, vec2(margin, base), letter, ink);

    let (low, high) = view.range;
    let [low, high] = [low, high].map(number);
    let unit = format!("{high} {}", view.quantity.unit());
    let unit = unit.trim_end();
    let right = width - margin - text::width(unit, letter);
    let bar = (0.2 * width).min(right - margin).max(1.0);
    let bar_right = right - 0.7 * letter;
    let bar_left = bar_right - bar;
    let low_left = bar_left - 0.7 * letter - text::width(&low, letter);
    plate(canvas, [low_left, width - margin], base, letter);
    text::write(canvas, unit, vec2(right, base), letter, ink);
    text::write(canvas, &low, vec2(low_left, base), letter, ink);

    let colours = Colours::new(view.colours);
    let columns = bar_left.max(0.0) as usize..bar_right.max(0.0) as usize;
    let rows = base as usize..(base + letter + 0.5) as usize;
    for x in columns.clone() {
        let colour = colours.at((x as f32 + 0.5 - bar_left) / bar);
        rows.clone().for_each(|y| canvas.blend(x, y, colour, 1.0));
    }
    // A thin frame separates the white end from the background.
    let [left, right] = [columns.start, columns.end].map(|x| x as f32);
    let [top, bottom] = [rows.start, rows.end].map(|y| y as f32);
    let corners = [
        vec2(left, top),
        vec2(right, top),
        vec2(right, bottom),
        vec2(left, bottom),
    ];
    for i in 0..4 {
        let ends = [corners[i], corners[(i + 1) % 4]];
        canvas.line(ends, 0.5, ink, |_, _, _| 0.6);
    }
}

/// A light plate behind a line of text, so that it can be read in front of water.
fn plate(canvas: &mut Canvas, [left, right]: [f32; 2], base: f32, letter: f32) {
    let colour = linear([214, 221, 229]);
    let pixels =
        |from: f32, to: f32| (from - 0.5 * letter).max(0.0) as usize..(to + 0.5 * letter) as usize;
    let rows = pixels(base, base + letter);
    for x in pixels(left, right) {
        rows.clone().for_each(|y| canvas.blend(x, y, colour, 0.6));
    }
}

/// A number with at most two decimals and no trailing zeros.
fn number(value: f32) -> String {
    let text = format!("{value:.2}");
    text.trim_end_matches('0').trim_end_matches('.').to_owned()
}
