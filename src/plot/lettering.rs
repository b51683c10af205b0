//! Texts as strokes at pixels.

use super::letters::{BASE, LINES, Point, STROKE, TRACKING, UNITS, glyph};
use super::marks::{base as unmarked, marked_strokes};
use super::primitive::{Anchor, Pixel, Text, crisp};
use super::words::{POWER_RISE, POWER_SIZE, runs, width};

/// Strokes of less pixels are moved to whole ones.
const THIN: f64 = 1.3;
/// Straight pieces of a curve.
const PIECES: u32 = 8;

/// A text as lines of one width.
pub(super) struct Lettering {
    pub(super) lines: Vec<Vec<Pixel>>,
    /// In pixels.
    pub(super) stroke: f64,
}

/// The strokes of a text.
pub(super) fn letter(text: &Text) -> Lettering {
    let boldness = if text.is_bold { 1.35 } else { 1.0 };
    let stroke = (text.size * STROKE / UNITS * boldness).max(1.0);
    let whole = width(&text.text, text.size);
    let before = match text.anchor {
        Anchor::Start => 0.0,
        Anchor::Middle => whole / 2.0,
        Anchor::End => whole,
    };
    // Level text stands on whole pixels, so that its level strokes are crisp.
    let is_level = text.direction == [1.0, 0.0];
    let base = if is_level { [text.at[0], text.at[1].round()] } else { text.at };
    // So does the first stem of a thin letter: half grey on two pixels, an `i` would be lost between others. Thicker ones
    // gain less than their even spacing is worth.
    let is_fitted = is_level && stroke < THIN;
    let mut lines = vec![];
    let mut pen = -before;
    for run in runs(&text.text) {
        let size = text.size * if run.is_power { POWER_SIZE } else { 1.0 };
        let rise = if run.is_power { (text.size * POWER_RISE).round() } else { 0.0 } + stroke.round() / 2.0;
        for letter in run.text.chars() {
            let (advance, _) = glyph(unmarked(letter));
            let strokes = marked_strokes(letter);
            let stem = stem(&strokes).filter(|_| is_fitted).map(|x| base[0] + pen + x * size / UNITS);
            let pen_fitted = pen + stem.map_or(0.0, |stem| crisp(stem, stroke) - stem);
            let place = |point: [f64; 2]| {
                let (along, up) = (pen_fitted + point[0] * size / UNITS, rise + fitted(point[1], size));
                let [right, down] = text.direction;
                [base[0] + along * right + up * down, base[1] + along * down - up * right]
            };
            lines.extend(strokes.iter().map(|points| flattened(points).into_iter().map(place).collect()));
            pen += (advance + TRACKING) * size / UNITS;
        }
    }
    Lettering { lines, stroke }
}

/// Where the first upright straight of a letter stands, in units.
fn stem(strokes: &[Vec<Point>]) -> Option<f64> {
    let is_upright = |pair: &&[Point]| pair[0].x == pair[1].x && !pair[0].is_control && !pair[1].is_control;
    strokes.iter().flat_map(|stroke| stroke.windows(2)).find(is_upright).map(|pair| f64::from(pair[0].x))
}

/// The height above the base line, in pixels: the lines of the letters are whole pixels apart, the rest lies between.
fn fitted(y: f64, size: f64) -> f64 {
    let height = |line: f64| ((line - BASE) * size / UNITS).round();
    let above = LINES.iter().position(|&line| line >= y).unwrap_or(LINES.len());
    match (above.checked_sub(1).map(|below| LINES[below]), LINES.get(above)) {
        (Some(low), Some(&high)) => height(low) + (height(high) - height(low)) * (y - low) / (high - low),
        (Some(highest), None) => height(highest) + (y - highest) * size / UNITS,
        (None, _) => height(LINES[0]),
    }
}

/// A stroke with its curves in straight pieces, in units.
fn flattened(points: &[Point]) -> Vec<[f64; 2]> {
    let at = |point: &Point| [f64::from(point.x), f64::from(point.y)];
    let mut line: Vec<[f64; 2]> = vec![];
    let mut control = None;
    for point in points {
        let end = at(point);
        if point.is_control {
            control = Some(end);
            continue;
        }
        match (control.take(), line.last().copied()) {
            (Some(control), Some(start)) => line.extend((1..=PIECES).map(|piece| curve(start, control, end, piece))),
            _ => line.push(end),
        }
    }
    line
}

fn curve(start: [f64; 2], control: [f64; 2], end: [f64; 2], piece: u32) -> [f64; 2] {
    let t = f64::from(piece) / f64::from(PIECES);
    let s = 1.0 - t;
    [0, 1].map(|axis| s * s * start[axis] + 2.0 * s * t * control[axis] + t * t * end[axis])
}

#[cfg(test)]
mod tests {
    use super::*;

    fn text(words: &str, size: f64, anchor: Anchor) -> Text {
        Text::plain([100.0, 50.0], words, size, anchor, [0; 3])
    }

    fn ends(lettering: &Lettering, axis: usize) -> [f64; 2] {
        let all = lettering.lines.iter().flatten().map(|point| point[axis]);
        all.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], at| [low.min(at), high.max(at)])
    }

    #[test]
    fn letters_stand_on_the_base_line_and_around_their_anchor() {
        for size in [10.0, 14.0, 21.0, 28.0] {
            let middle = letter(&text("HOH", size, Anchor::Middle));
            let [left, right] = ends(&middle, 0);
            assert!((left.midpoint(right) - 100.0).abs() < 0.6, "{size}");
            let lowest = ends(&middle, 1)[1];
            assert_eq!(lowest + middle.stroke.round() / 2.0, 50.0, "{size}");
            assert!(ends(&letter(&text("H", size, Anchor::Start)), 0)[0] > 100.0);
            assert!(ends(&letter(&text("H", size, Anchor::End)), 0)[1] < 100.0);
        }
    }

    #[test]
    fn strokes_of_all_heights_rise_with_their_height() {
        for size in 6..60 {
            let heights: Vec<f64> = (0..=20).map(|y| fitted(f64::from(y), f64::from(size))).collect();
            assert!(heights.windows(2).all(|pair| pair[0] <= pair[1]), "{size}");
        }
    }

    #[test]
    fn powers_stand_higher_and_turned_text_is_turned() {
        let top = |words: &str| ends(&letter(&text(words, 20.0, Anchor::Start)), 1)[0];
        assert!(top("10^3") < top("103"));
        let level = letter(&text("ab", 20.0, Anchor::Start));
        let upwards = letter(&Text { direction: [0.0, -1.0], ..text("ab", 20.0, Anchor::Start) });
        for (a, b) in level.lines.iter().flatten().zip(upwards.lines.iter().flatten()) {
            assert!((a[0] - 100.0 - (50.0 - b[1])).abs() < 1e-9 && (a[1] - 50.0 - (b[0] - 100.0)).abs() < 1e-9);
        }
    }
}
