//! Veins of the third order: rungs between neighbouring secondaries, and between the main vein and its first secondary.

use super::line::{along, length};
use super::lobes::Margin;
use crate::base::vector::DVec2;

/// Distance of rungs along a secondary, share of the blade's size.
const GAP: f64 = 0.05;
/// How far a rung bulges towards the margin, share of its length.
const BULGE: f64 = 0.12;
/// Shortest and longest rung, shares of the size.
const LENGTHS: (f64, f64) = (0.02, 0.30);
/// Rungs end this far (share of the shorter secondary's length) before the secondaries do.
const LAST: f64 = 0.92;

/// The rungs on one side of a main vein; `secondaries` from base to tip.
pub fn rungs(margin: &Margin, main: &[DVec2], secondaries: &[Vec<DVec2>]) -> Vec<Vec<DVec2>> {
    let mut made = Vec::new();
    for pair in secondaries.windows(2) {
        between(margin, &pair[0], &pair[1], &mut made);
    }
    if let Some(last) = secondaries.last() {
        let start = main.iter().position(|p| (p - last[0]).dot(&(main[main.len() - 1] - last[0])) > 0.0);
        let rest: Vec<DVec2> =
            [last[0]].into_iter().chain(start.into_iter().flat_map(|i| main[i..].iter().copied())).collect();
        between(margin, last, &rest, &mut made);
    }
    made
}

/// Rungs from one line to another, at the same shares of their lengths.
fn between(margin: &Margin, lower: &[DVec2], upper: &[DVec2], made: &mut Vec<Vec<DVec2>>) {
    let lengths = [length(lower), length(upper)];
    let count = (lengths[0] * LAST / (GAP * margin.size)).floor().clamp(0.0, 64.0) as u32;
    for i in 1..=count {
        let share = f64::from(i) * GAP * margin.size / lengths[0];
        // Rungs are staggered: neither evenly spaced nor in one line with those beyond the vein.
        let stagger = if i.is_multiple_of(2) { 0.3 } else { -0.2 } * GAP * margin.size / lengths[0];
        let (from, heading) = along(lower, share * lengths[0]);
        let (to, _) = along(upper, ((share + stagger) * lengths[1]).min(LAST * lengths[1]));
        let side = to - from;
        let middle = (from + to) * 0.5 + heading * (BULGE * side.norm());
        let line: Vec<DVec2> = super::line::quadratic(from, middle, to, 4);
        let fits = (LENGTHS.0 * margin.size..LENGTHS.1 * margin.size).contains(&side.norm());
        if fits && line[1..4].iter().all(|p| margin.contains(*p)) {
            made.push(line);
        }
    }
}
