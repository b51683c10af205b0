//! Grid, axes, ticks, numbers and captions.

use super::layout::{Placed, caption, lower_caption};
use super::palette::{FRAME, GRID, INK};
use super::primitive::{Anchor, Pen, Primitive, Text, crisp};
use super::words::cut;

/// What lies below the data: grid, numbers and captions.
pub(super) fn draw(placed: &Placed, items: &mut Vec<Primitive>) {
    grid(placed, items);
    upright_numbers(placed, items);
    if placed.is_numbered {
        lower_numbers(placed, items);
    }
    captions(placed, items);
}

fn line(from: [f64; 2], to: [f64; 2], colour: [u8; 3], width: f64) -> Primitive {
    Primitive::Polyline { points: vec![from, to], pen: Pen { colour, width, dashes: None } }
}

/// Pixel columns of the lower axis' ticks.
fn columns<'a>(placed: &'a Placed, values: impl Iterator<Item = f64> + 'a) -> impl Iterator<Item = f64> + 'a {
    values.filter_map(|value| placed.column(value)).map(|column| crisp(column, placed.sizes.hair))
}

/// Pixel rows of the upright axis' ticks.
fn rows<'a>(placed: &'a Placed, values: impl Iterator<Item = f64> + 'a) -> impl Iterator<Item = f64> + 'a {
    values.filter_map(|value| placed.row(value)).map(|row| crisp(row, placed.sizes.hair))
}

fn grid(placed: &Placed, items: &mut Vec<Primitive>) {
    let (area, hair) = (placed.area, placed.sizes.hair);
    for column in columns(placed, placed.x_ticks.major.iter().map(|tick| tick.value)) {
        items.push(line([column, area.top], [column, area.bottom], GRID, hair));
    }
    for row in rows(placed, placed.y_ticks.major.iter().map(|tick| tick.value)) {
        items.push(line([area.left, row], [area.right, row], GRID, hair));
    }
}

/// The two axes and their ticks, which lie over the data.
pub(super) fn draw_lines(placed: &Placed, items: &mut Vec<Primitive>) {
    let (area, hair, letter) = (placed.area, placed.sizes.hair, placed.sizes.letter);
    let (left, bottom) = (crisp(area.left, hair), crisp(area.bottom, hair));
    let (long, short) = (letter * 0.35, letter * 0.18);
    let tick = |column, length| line([column, bottom], [column, bottom + length], FRAME, hair);
    if placed.is_numbered {
        items.extend(columns(placed, placed.x_ticks.major.iter().map(|t| t.value)).map(|column| tick(column, long)));
        items.extend(columns(placed, placed.x_ticks.minor.iter().copied()).map(|column| tick(column, short)));
    }
    let tick = |row, length| line([left - length, row], [left, row], FRAME, hair);
    items.extend(rows(placed, placed.y_ticks.major.iter().map(|t| t.value)).map(|row| tick(row, long)));
    items.extend(rows(placed, placed.y_ticks.minor.iter().copied()).map(|row| tick(row, short)));
    items.push(line([left, area.top], [left, bottom + hair / 2.0], FRAME, hair));
    items.push(line([left, bottom], [area.right, bottom], FRAME, hair));
}

fn upright_numbers(placed: &Placed, items: &mut Vec<Primitive>) {
    let (letter, small) = (placed.sizes.letter, placed.sizes.small);
    let right = placed.area.left - letter * 0.6;
    for tick in &placed.y_ticks.major {
        let Some(row) = placed.row(tick.label_at) else { continue };
        let text = cut(&tick.label, small, right);
        items.push(Primitive::Text(Text::plain([right, row + small * 0.36], text, small, Anchor::End, INK)));
    }
}

fn lower_numbers(placed: &Placed, items: &mut Vec<Primitive>) {
    let small = placed.sizes.small;
    let base = placed.area.bottom + placed.sizes.letter * 1.4;
    for tick in placed.x_ticks.major.iter().filter(|tick| !tick.label.is_empty()) {
        let Some(column) = placed.column(tick.label_at) else { continue };
        items.push(Primitive::Text(Text::plain([column, base], tick.label.clone(), small, Anchor::Middle, INK)));
    }
}

/// The upright axis' caption stands level above it, where it is read without turning the head.
fn captions(placed: &Placed, items: &mut Vec<Primitive>) {
    let (area, letter) = (placed.area, placed.sizes.letter);
    let crosses = if placed.panel.series.iter().any(|s| !s.diverged.is_empty()) { placed.sizes.mark } else { 0.0 };
    let text = cut(&caption(&placed.panel.y), letter, area.right - letter);
    // It begins above the numbers, so that it is seen to belong to them.
    let at = [letter, area.top - letter * 0.65 - crosses];
    items.push(Primitive::Text(Text::plain(at, text, letter, Anchor::Start, INK)));
    if placed.is_numbered {
        let text = cut(&lower_caption(&placed.panel.x, placed.x.range), letter, area.width());
        let at = [area.left.midpoint(area.right), area.bottom + letter * 2.85];
        items.push(Primitive::Text(Text::plain(at, text, letter, Anchor::Middle, INK)));
    }
    items.retain(|item| !matches!(item, Primitive::Text(text) if text.text.is_empty()));
}
