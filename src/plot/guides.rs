//! Bands and guides of a panel, with words where the data leave room.

use super::clip::{self, Area};
use super::data::pixel;
use super::layout::Placed;
use super::palette::{BAND, GUIDE};
use super::primitive::{Anchor, Pen, Pixel, Primitive, Text};
use super::words::{cleaned, cut, room};
use super::{Along, Band, Guide, Style};

/// Where along a guide its words may begin to be tried: shares of the way that is free, from its lower or right end.
const TRIED: [f64; 9] = [0.0, 0.125, 0.25, 0.375, 0.5, 0.625, 0.75, 0.875, 1.0];

/// Draws what lies below the series.
pub(super) fn draw(placed: &Placed, items: &mut Vec<Primitive>) {
    placed.panel.bands.iter().for_each(|one| band(placed, one, items));
    if placed.panel.guides.is_empty() {
        return;
    }
    let mut taken = drawn_places(placed);
    placed.panel.guides.iter().for_each(|one| guide(placed, one, &mut taken, items));
}

/// Points along everything that the series draw as lines or marks, half a letter apart.
fn drawn_places(placed: &Placed) -> Vec<Pixel> {
    let step = placed.sizes.small * 0.5;
    let mut places = vec![];
    for series in placed.panel.series.iter().filter(|series| series.style != Style::Area) {
        let pixels: Vec<Option<Pixel>> = series.points.iter().map(|&point| pixel(placed, point)).collect();
        for run in pixels.split(Option::is_none) {
            let run: Vec<Pixel> = run.iter().flatten().copied().collect();
            for piece in clip::polyline(&run, &placed.area) {
                piece.windows(2).for_each(|pair| places.extend(between(pair[0], pair[1], step)));
                places.extend(piece.last());
            }
        }
    }
    places
}

/// Points from `from` towards `to`, the first included, at most `step` apart.
fn between(from: Pixel, to: Pixel, step: f64) -> impl Iterator<Item = Pixel> {
    let count = (distance(from, to) / step).ceil().max(1.0) as u32;
    (0..count).map(move |at| {
        let t = f64::from(at) / f64::from(count);
        [0, 1].map(|axis| from[axis] + (to[axis] - from[axis]) * t)
    })
}

fn band(placed: &Placed, band: &Band, items: &mut Vec<Primitive>) {
    let (whole, small) = (placed.area, placed.sizes.small);
    let (from, to) = (band.from.min(band.to), band.from.max(band.to));
    let place = |value, edge, of: &dyn Fn(f64) -> Option<f64>| of(value).unwrap_or(edge);
    let area = match band.along {
        Along::X => Area {
            left: place(from, whole.left, &|v| placed.column(v)).max(whole.left),
            right: place(to, whole.right, &|v| placed.column(v)).min(whole.right),
            ..whole
        },
        Along::Y => Area {
            bottom: place(from, whole.bottom, &|v| placed.row(v)).min(whole.bottom),
            top: place(to, whole.top, &|v| placed.row(v)).max(whole.top),
            ..whole
        },
    };
    if area.width() <= 0.0 || area.height() <= 0.0 {
        return;
    }
    let Area { left, top, right, bottom } = area;
    items.push(Primitive::Polygon {
        points: vec![[left, top], [right, top], [right, bottom], [left, bottom]],
        fill: BAND,
    });
    let text = cut(&cleaned(&band.label), small, area.width() - small);
    let base = if area.height() >= small * 1.4 { top + small * 1.1 } else { top - small * 0.4 };
    if !text.is_empty() && base - small >= whole.top {
        let words = Text::plain([left + small * 0.5, base], text, small, Anchor::Start, GUIDE);
        items.push(Primitive::Text(words));
    }
}

fn guide(placed: &Placed, guide: &Guide, taken: &mut Vec<Pixel>, items: &mut Vec<Primitive>) {
    let (area, small) = (placed.area, placed.sizes.small);
    let ends = match *guide {
        Guide::Slope { order, through, .. } => sloped(placed, order, through),
        Guide::Level { y, .. } => placed.row(y).map(|row| [[area.left, row], [area.right, row]]),
        Guide::Upright { x, .. } => placed.column(x).map(|column| [[column, area.bottom], [column, area.top]]),
    };
    let Some(piece) = ends.and_then(|ends| clip::polyline(&ends, &area).pop()) else { return };
    let dash = placed.sizes.line * 2.5;
    let pen = Pen { colour: GUIDE, width: placed.sizes.hair, dashes: Some([dash, dash]) };
    let (from, to) = (piece[0], piece[piece.len() - 1]);
    items.push(Primitive::Polyline { points: piece, pen });
    let text = match guide {
        Guide::Slope { order, label, .. } if label.is_empty() => format!("slope {}", number(*order)),
        Guide::Slope { label, .. } | Guide::Level { label, .. } | Guide::Upright { label, .. } => cleaned(label),
    };
    let text = cut(&text, small, distance(from, to) - small * 2.0);
    if !text.is_empty() && area.height() >= small * 2.0 {
        items.push(Primitive::Text(along(placed, [from, to], text, taken)));
    }
}

fn number(value: f64) -> String {
    format!("{value}").replace('-', "\u{2212}")
}

fn distance(from: Pixel, to: Pixel) -> f64 {
    let (right, down) = (to[0] - from[0], to[1] - from[1]);
    (right * right + down * down).sqrt()
}

/// A text along the line, above or below it, where it covers the least of what is `taken`; at best at the line's lower
/// end, where guides through one point are farthest apart. What it covers is taken then.
fn along(placed: &Placed, [from, to]: [Pixel; 2], text: String, taken: &mut Vec<Pixel>) -> Text {
    let small = placed.sizes.small;
    let (length, wide) = (distance(from, to), room(&text, small));
    let direction = [(to[0] - from[0]) / length, (to[1] - from[1]) / length];
    let free = length - wide - small * 1.2;
    let falls = direction[1] >= 0.0;
    let starts = TRIED.map(|part| small * 0.6 + free * if falls { 1.0 - part } else { part });
    // The letters reach from the base line up to 0.75 of their size.
    let place = |start: f64, rise: f64| {
        [0, 1].map(|axis| from[axis] + direction[axis] * start + rise * [direction[1], -direction[0]][axis])
    };
    let covered = |at: &Pixel| {
        let box_holds = |point: &&Pixel| {
            let [right, down] = [point[0] - at[0], point[1] - at[1]];
            let (forth, up) = (right * direction[0] + down * direction[1], right * direction[1] - down * direction[0]);
            forth > -small * 0.4 && forth < wide + small * 0.4 && up > -small * 0.3 && up < small
        };
        taken.iter().filter(box_holds).count() + if placed.area.holds(*at, 0.0) { 0 } else { 2 }
    };
    let tried = starts.iter().flat_map(|&start| [small * 0.4, -small * 1.05].map(|rise| place(start, rise)));
    let at = tried.min_by_key(covered).unwrap_or(from);
    let end = [0, 1].map(|axis| at[axis] + direction[axis] * wide);
    taken.extend(between(at, end, small * 0.5));
    Text { direction, halo: true, ..Text::plain(at, text, small, Anchor::Start, GUIDE) }
}

/// The line of this slope from the left to the right end of the axis.
fn sloped(placed: &Placed, order: f64, through: [f64; 2]) -> Option<[Pixel; 2]> {
    let (x, y) = (placed.x, placed.y);
    let (x0, y0) = (x.scaled(through[0]), y.scaled(through[1]));
    let ([left, right], [low, high]) = (x.range.map(|end| x.scaled(end)), y.range.map(|end| y.scaled(end)));
    let row = |at: f64| placed.area.bottom - (y0 + order * (at - x0) - low) / (high - low) * placed.area.height();
    let ends = [[placed.area.left, row(left)], [placed.area.right, row(right)]];
    ends.iter().all(|end| end[1].abs() < 1.0e12).then_some(ends)
}
