//! The names of the series at the right of a panel.

use super::data;
use super::layout::{Look, Placed};
use super::palette::{INK, darkened};
use super::primitive::{Anchor, Primitive, Text};
use super::words::{cleaned, cut, room};
use super::{Legend, Mark, Style};

/// The most of the chart's width that names may take.
const LARGEST_PART: f64 = 0.24;

/// A row of the legend.
struct Entry {
    /// The number of the series; `None`: the crosses of runs that diverged.
    series: Option<usize>,
    name: String,
}

/// The rows from the top of the column.
fn entries(placed: &Placed) -> Vec<Entry> {
    if placed.panel.legend == Legend::Absent {
        return vec![];
    }
    let all = &placed.panel.series;
    let named = |at: usize| Entry { series: Some(at), name: cleaned(&all[at].name) };
    let (mut areas, others): (Vec<_>, Vec<_>) = (0..all.len()).partition(|&at| all[at].style == Style::Area);
    areas.reverse();
    let mut entries: Vec<Entry> = areas.into_iter().chain(others).map(named).collect();
    entries.retain(|entry| !entry.name.is_empty());
    if all.iter().any(|series| !series.diverged.is_empty()) {
        entries.push(Entry { series: None, name: "diverged".to_owned() });
    }
    entries
}

/// The width of a name's sample with its gaps, in letters.
const SAMPLE: f64 = 2.4;

/// The width of the column, in pixels.
pub(super) fn width(placed: &Placed, chart: f64) -> f64 {
    let letter = placed.sizes.letter;
    let names = entries(placed);
    let widest = names.iter().map(|entry| room(&entry.name, letter)).fold(0.0, f64::max);
    if names.is_empty() { 0.0 } else { widest.min(chart * LARGEST_PART) + letter * SAMPLE }
}

/// Draws the column.
pub(super) fn draw(placed: &Placed, chart: f64, items: &mut Vec<Primitive>) {
    let (area, letter) = (placed.area, placed.sizes.letter);
    let step = letter * 1.45;
    let mut names = entries(placed);
    let fitting = ((area.height() / step + 0.3).floor() as usize).max(1);
    let left_out = if names.len() > fitting { names.len() - (fitting - 1) } else { 0 };
    names.truncate(names.len() - left_out);
    let mut heights = match placed.panel.legend {
        Legend::Ends if left_out == 0 => at_ends(placed, &names, step),
        _ => (0..names.len()).map(|at| area.top + step * (at as f64 + 0.5)).collect(),
    };
    let limit = chart * LARGEST_PART;
    let left = area.right + letter * 0.7;
    for (Entry { series, name }, &height) in names.iter().zip(&heights) {
        match series {
            Some(series) => sample(placed, *series, [left, height], items),
            None => cross(placed, [left + letter * 0.7, height], items),
        }
        let at = [left + letter * (SAMPLE - 0.7), height + letter * 0.36];
        items.push(Primitive::Text(Text::plain(at, cut(name, letter, limit), letter, Anchor::Start, INK)));
    }
    if left_out > 0 {
        let height = heights.pop().map_or(area.top + step / 2.0, |last| last + step);
        let more = cut(&format!("and {left_out} more"), letter, limit + letter);
        let at = [left, height + letter * 0.36];
        items.push(Primitive::Text(Text::plain(at, more, letter, Anchor::Start, INK)));
    }
}

fn cross(placed: &Placed, middle: [f64; 2], items: &mut Vec<Primitive>) {
    data::mark(Mark::Cross, middle, placed, Look { colour: INK, dashes: None }, items);
}

/// A short piece of the series.
fn sample(placed: &Placed, series: usize, [left, middle]: [f64; 2], items: &mut Vec<Primitive>) {
    let (sizes, look) = (placed.sizes, placed.looks[series]);
    let right = left + sizes.letter * 1.4;
    let style = placed.panel.series[series].style;
    if style == Style::Area {
        let half = sizes.letter * 0.45;
        for (inset, fill) in [(0.0, darkened(look.colour, data::EDGE)), (sizes.hair, look.colour)] {
            let (left, right) = ((left + inset).round(), (right - inset).round());
            let (top, bottom) = ((middle - half + inset).round(), (middle + half - inset).round());
            let points = vec![[left, top], [right, top], [right, bottom], [left, bottom]];
            items.push(Primitive::Polygon { points, fill });
        }
    }
    if matches!(style, Style::Line | Style::Marked(_)) {
        let points = vec![[left, middle], [right, middle]];
        items.push(Primitive::Polyline { points, pen: data::pen(placed, look) });
    }
    if let Style::Marks(mark) | Style::Marked(mark) = style {
        data::mark(mark, [left.midpoint(right), middle], placed, look, items);
    }
}

/// The heights at which the named series end, moved apart and into the panel.
fn at_ends(placed: &Placed, names: &[Entry], step: f64) -> Vec<f64> {
    let (top, bottom) = (placed.area.top + step / 2.0, placed.area.bottom - step / 2.0);
    // Diverged runs end at the upper edge.
    let end = |entry: &Entry| entry.series.map_or(placed.area.top, |series| data::end(placed, series));
    let ends: Vec<f64> = names.iter().map(|entry| end(entry).clamp(top, bottom.max(top))).collect();
    let mut order: Vec<usize> = (0..ends.len()).collect();
    order.sort_by(|&a, &b| ends[a].total_cmp(&ends[b]).then(a.cmp(&b)));
    let mut heights = ends;
    for pair in 1..order.len() {
        heights[order[pair]] = heights[order[pair]].max(heights[order[pair - 1]] + step);
    }
    let mut limit = bottom.max(top);
    for &at in order.iter().rev() {
        heights[at] = heights[at].min(limit);
        limit = heights[at] - step;
    }
    heights
}
