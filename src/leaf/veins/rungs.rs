//! Veins of the third order: rungs between neighbouring secondaries, and between the main vein and its first secondary; and
//! across the fields that these leave empty, as between the feet of main veins.

use super::line::{along, length};
use super::lobes::Margin;
use crate::base::maths::sincos;
use crate::base::random::hash_unit;
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

/// Angle (radians) at which a rung leaves a vein where a field is filled, and by how much it varies.
const LEAVING: (f64, f64) = (1.2, 0.25);
/// Rungs keep this share of their distance from each other.
const APART: f64 = 0.62;
/// The longest, share of the size.
const LONGEST: f64 = 0.5;
/// Rungs that meet no other vein end at this share of the way to the margin.
const SHORT_OF_MARGIN: f64 = 0.9;

/// Rungs across the fields between `veins` (of the first and second order, thick ones first) that `made` leave empty.
pub fn filling(margin: &Margin, veins: &[&[DVec2]], made: &[Vec<DVec2>]) -> Vec<Vec<DVec2>> {
    let gap = GAP * margin.size;
    let mut middles: Vec<DVec2> = made.iter().flat_map(|line| thirds(line)).collect();
    let mut found = Vec::new();
    for (number, line) in veins.iter().enumerate() {
        let count = (length(line) * LAST / gap).floor().clamp(0.0, 64.0) as u32;
        for (i, side) in (1..=count).flat_map(|i| [(i, 1.0), (i, -1.0)]) {
            let own = |salt: u64| f64::from(hash_unit(salt, (number as u64) << 32 | u64::from(i))) - 0.5;
            let (from, heading) = along(line, (f64::from(i) + 0.6 * own(1)) * gap);
            let (sine, cosine) = sincos(side * (LEAVING.0 + 2.0 * LEAVING.1 * own(2)));
            let way = DVec2::new(cosine * heading.x - sine * heading.y, sine * heading.x + cosine * heading.y);
            let lines = veins.iter().enumerate().filter(|(other, _)| *other != number).map(|(_, line)| *line);
            let lines = lines.chain(made.iter().chain(&found).map(Vec::as_slice));
            let Some(reach) = reach(margin, lines, from, way) else { continue };
            let to = from + way * reach;
            let rung = super::line::quadratic(from, (from + to) * 0.5 + heading * (BULGE * reach), to, 4);
            let is_free = |p: &DVec2| middles.iter().all(|other| (other - p).norm() > APART * gap);
            let fits = (LENGTHS.0 * margin.size..LONGEST * margin.size).contains(&reach);
            if fits && thirds(&rung).iter().all(is_free) && rung[1..4].iter().all(|p| margin.contains(*p)) {
                middles.extend(thirds(&rung));
                found.push(rung);
            }
        }
    }
    found
}

/// Three places within a line.
fn thirds(line: &[DVec2]) -> [DVec2; 3] {
    let whole = length(line);
    [0.25, 0.5, 0.75].map(|share| along(line, share * whole).0)
}

/// How far it is from a place of a vein to the next of these lines in a direction, or most of the way to the margin.
fn reach<'a>(margin: &Margin, lines: impl Iterator<Item = &'a [DVec2]>, from: DVec2, way: DVec2) -> Option<f64> {
    let least = 0.2 * LENGTHS.0 * margin.size;
    let mut nearest = margin.reach(from, way)?.0 * SHORT_OF_MARGIN;
    for line in lines {
        for pair in line.windows(2) {
            let (side, to) = (pair[1] - pair[0], pair[0] - from);
            let turn = way.perp(&side);
            let (along, across) = (to.perp(&side) / turn, to.perp(&way) / turn);
            if turn != 0.0 && along > least && along < nearest && (0.0..=1.0).contains(&across) {
                nearest = along;
            }
        }
    }
    Some(nearest)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_empty_field_is_filled_with_rungs_apart_from_each_other_and_within_the_blade() {
        let square =
            [(0.0, 0.0), (0.04, 0.0), (0.04, 0.08), (-0.04, 0.08), (-0.04, 0.0)].map(|(x, y)| DVec2::new(x, y));
        let margin = Margin::new(&square).unwrap();
        let mains = [-0.02, 0.0, 0.02].map(|x| vec![DVec2::new(0.1 * x, 0.001), DVec2::new(x, 0.078)]);
        let lines: Vec<&[DVec2]> = mains.iter().map(Vec::as_slice).collect();
        let found = filling(&margin, &lines, &[]);
        assert!(found.len() > 20, "{}", found.len());
        let middle = |line: &Vec<DVec2>| thirds(line)[1];
        for (i, one) in found.iter().enumerate() {
            assert!(one.iter().all(|p| margin.contains(*p) || p.y < 0.002));
            let apart = |other: &Vec<DVec2>| (middle(one) - middle(other)).norm() > 0.9 * APART * GAP * margin.size;
            assert!(found[..i].iter().all(apart));
        }
        // What is full stays as it is.
        assert!(filling(&margin, &lines, &found).len() * 4 < found.len());
    }
}
