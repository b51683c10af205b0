//! The series of a panel.

use super::clip;
use super::layout::{Look, Placed};
use super::palette::{PAPER, darkened};
use super::primitive::{Pen, Pixel, Primitive};
use super::words::cleaned;
use super::{Mark, Series, Style};
use crate::base::maths::sincos;

/// How much darker than the area its upper edge is.
pub(super) const EDGE: f64 = 0.22;
/// Points that lie nearer than this to the last one drawn add nothing that is seen, in pixels.
const NEAR: f64 = 0.05;

/// Draws the areas.
pub(super) fn draw_areas(placed: &Placed, items: &mut Vec<Primitive>) {
    let is_area = |series: &Series| series.style == Style::Area;
    let areas = placed.panel.series.iter().zip(&placed.looks).filter(|(series, _)| is_area(series));
    for (below, (series, look)) in areas.enumerate() {
        let mut drawn = vec![];
        area(placed, below, *look, &mut drawn);
        diverged(placed, series, *look, &mut drawn);
        items.push(Primitive::Group { name: cleaned(&series.name), items: drawn });
    }
}

/// Draws what is no area: lines, marks and crosses.
pub(super) fn draw_lines(placed: &Placed, items: &mut Vec<Primitive>) {
    for (one, look) in placed.panel.series.iter().zip(&placed.looks).filter(|(one, _)| one.style != Style::Area) {
        let mut drawn = vec![];
        series(placed, one, *look, &mut drawn);
        diverged(placed, one, *look, &mut drawn);
        items.push(Primitive::Group { name: cleaned(&one.name), items: drawn });
    }
}

/// How a series' line is drawn.
pub(super) fn pen(placed: &Placed, look: Look) -> Pen {
    let width = placed.sizes.line;
    Pen { colour: look.colour, width, dashes: look.dashes.map(|dashes| dashes.map(|part| part * width)) }
}

/// The area number `below` from the bottom of the stack, with its upper edge as a line.
fn area(placed: &Placed, below: usize, look: Look, items: &mut Vec<Primitive>) {
    let edge = |heights: &[f64]| {
        let points = placed.stack.at.iter().zip(heights);
        // What a logarithmic axis cannot show of an area lies below its end.
        let pixel = |(&x, &y): (&f64, &f64)| {
            Some([placed.column(x)?, placed.row(y).unwrap_or(placed.area.bottom + placed.area.height())])
        };
        points.filter_map(pixel).collect::<Vec<Pixel>>()
    };
    let (lower, upper) = (edge(&placed.stack.edges[below]), edge(&placed.stack.edges[below + 1]));
    let outline: Vec<Pixel> = upper.iter().copied().chain(lower.into_iter().rev()).collect();
    let points = clip::polygon(&outline, &placed.area);
    if points.len() > 2 {
        items.push(Primitive::Polygon { points, fill: look.colour });
    }
    let pen = Pen { colour: darkened(look.colour, EDGE), width: placed.sizes.hair, dashes: None };
    let pieces = clip::polyline(&upper, &placed.area).into_iter().filter(|piece| piece.len() > 1);
    items.extend(pieces.map(|points| Primitive::Polyline { points, pen }));
}

/// The place of a point, when the axes can show it.
pub(super) fn pixel(placed: &Placed, point: [f64; 2]) -> Option<Pixel> {
    Some([placed.column(point[0])?, placed.row(point[1])?])
}

fn series(placed: &Placed, series: &Series, look: Look, items: &mut Vec<Primitive>) {
    let pixels: Vec<Option<Pixel>> = series.points.iter().map(|&point| pixel(placed, point)).collect();
    if matches!(series.style, Style::Line | Style::Marked(_)) {
        let unbroken = pixels.split(Option::is_none).map(|run| run.iter().flatten().copied().collect::<Vec<Pixel>>());
        for piece in unbroken.flat_map(|run| clip::polyline(&thinned(run), &placed.area)) {
            line(placed, piece, look, series.style == Style::Line, items);
        }
    }
    if let Style::Marks(form) | Style::Marked(form) = series.style {
        for &at in pixels.iter().flatten().filter(|&&at| placed.area.holds(at, 0.5)) {
            mark(form, at, placed, look, items);
        }
    }
}

/// A piece of a line; one point alone would not be seen and becomes a dot, unless a mark will stand there.
fn line(placed: &Placed, points: Vec<Pixel>, look: Look, is_bare: bool, items: &mut Vec<Primitive>) {
    if points.len() > 1 {
        items.push(Primitive::Polyline { points, pen: pen(placed, look) });
    } else if is_bare && let Some(&at) = points.first() {
        items.push(Primitive::Polygon { points: disc(at, placed.sizes.line * 1.2), fill: look.colour });
    }
}

/// Without the points that lie on the one before; both ends stay.
fn thinned(mut points: Vec<Pixel>) -> Vec<Pixel> {
    let Some(&end) = points.last() else { return points };
    let mut last: Option<Pixel> = None;
    points.retain(|point| {
        let is_far = last.is_none_or(|last| (0..2).any(|axis| (last[axis] - point[axis]).abs() >= NEAR));
        if is_far {
            last = Some(*point);
        }
        is_far
    });
    if points.len() > 1 && points.last() != Some(&end) {
        points.push(end);
    }
    points
}

/// Crosses at the upper edge for runs that have no error to show.
fn diverged(placed: &Placed, series: &Series, look: Look, items: &mut Vec<Primitive>) {
    let columns = series.diverged.iter().filter_map(|&x| placed.column(x));
    for column in columns.filter(|&column| placed.area.holds([column, placed.area.top], 0.5)) {
        mark(Mark::Cross, [column, placed.area.top], placed, look, items);
    }
}

fn disc(middle: Pixel, radius: f64) -> Vec<Pixel> {
    const CORNERS: u32 = 32;
    let corner = |at: u32| {
        let (sine, cosine) = sincos(f64::from(at) * std::f64::consts::TAU / f64::from(CORNERS));
        [middle[0] + radius * cosine, middle[1] + radius * sine]
    };
    (0..CORNERS).map(corner).collect()
}

/// A mark with a thin edge of paper, so that marks that overlap stay countable.
pub(super) fn mark(form: Mark, middle: Pixel, placed: &Placed, look: Look, items: &mut Vec<Primitive>) {
    let reach = placed.sizes.mark;
    let at = |x: f64, y: f64| [middle[0] + x * reach, middle[1] + y * reach];
    // The forms have about equal areas.
    let filled = match form {
        Mark::Circle => disc(middle, reach),
        Mark::Square => vec![at(-0.88, -0.88), at(0.88, -0.88), at(0.88, 0.88), at(-0.88, 0.88)],
        Mark::Diamond => vec![at(0.0, -1.25), at(1.25, 0.0), at(0.0, 1.25), at(-1.25, 0.0)],
        Mark::Up => vec![at(0.0, -1.3), at(1.2, 0.85), at(-1.2, 0.85)],
        Mark::Down => vec![at(0.0, 1.3), at(-1.2, -0.85), at(1.2, -0.85)],
        Mark::Plus => return cross([at(-1.2, 0.0), at(1.2, 0.0), at(0.0, -1.2), at(0.0, 1.2)], placed, look, items),
        Mark::Cross => return cross([at(-1.0, -1.0), at(1.0, 1.0), at(1.0, -1.0), at(-1.0, 1.0)], placed, look, items),
    };
    let edge: Vec<Pixel> = filled.iter().chain(&filled[..2]).copied().collect();
    let pen = Pen { colour: PAPER, width: placed.sizes.letter * 0.1, dashes: None };
    items.push(Primitive::Polyline { points: edge, pen });
    items.push(Primitive::Polygon { points: filled, fill: look.colour });
}

fn cross([a, b, c, d]: [Pixel; 4], placed: &Placed, look: Look, items: &mut Vec<Primitive>) {
    let width = placed.sizes.line;
    for (colour, width) in [(PAPER, width * 2.2), (look.colour, width)] {
        let pen = Pen { colour, width, dashes: None };
        items.extend([[a, b], [c, d]].map(|ends| Primitive::Polyline { points: ends.to_vec(), pen }));
    }
}

/// The pixel row at which a series ends at the right: of an area, the middle of its end.
pub(super) fn end(placed: &Placed, at: usize) -> f64 {
    let series = &placed.panel.series[at];
    let row = if series.style == Style::Area {
        let below = placed.panel.series[..at].iter().filter(|other| other.style == Style::Area).count();
        let last = |edge: usize| placed.stack.edges[edge].last().and_then(|&height| placed.row(height));
        last(below).zip(last(below + 1)).map(|(lower, upper)| lower.midpoint(upper))
    } else {
        let shown = series.points.iter().filter_map(|&point| pixel(placed, point));
        shown.max_by(|a, b| a[0].total_cmp(&b[0])).map(|at| at[1])
    };
    row.unwrap_or(placed.area.bottom)
}
