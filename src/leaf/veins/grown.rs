//! Veins from the outline alone. Palmate blades: a main vein from the joint to the tip of each lobe, bent as its lobe is
//! bent; others: one midrib. Secondaries leave the main veins at about 50 degrees and bend towards their tips: one to every
//! large tooth where the margin has such (craspedodromous), else evenly spaced, ending at small teeth, or on an entire
//! margin in loops (brochidodromous). A third order runs across between neighbouring secondaries like rungs of a ladder
//! (percurrent), and across what fields are left. Terms after Ellis et al. 2009, "Manual of Leaf Architecture". They serve the mask and the painted textures;
//! they are not a model of growth.

use super::forking::forking;
use super::line::{along, distance, length, quadratic};
use super::lobes::{Lobe, Margin, Tooth};
use super::rungs::{filling, rungs};
use crate::base::blade::Vein;
use crate::base::maths::{atan2, sincos};
use crate::base::vector::DVec2;
use crate::leaf::Venation;
use std::ops::Range;

/// Widths of the thick ends as shares of the blade's size; orders go 4 : 2 : 1.
const WIDTHS: [f64; 3] = [0.018, 0.009, 0.0045];
/// Width of the thin end against the thick one.
const TAPER: f64 = 0.25;
/// Teeth of at least this height (share of the size) have a secondary each: on palmate blades, and on pinnate ones, where
/// only lobes are that large.
const LARGE: (f64, f64) = (0.020, 0.040);
/// Teeth of this height draw a secondary's end.
const SMALL: f64 = 0.006;
/// How far (share of the size) a secondary's end is drawn to a small tooth.
const DRAWN: f64 = 0.05;
/// Angle (radians) between a main vein and the chord of a secondary that leads to a large tooth (measured on grape leaves:
/// 22 to 42 degrees; 35 to 47 on the side of the joint), and that of evenly spaced ones at the base and at the tip.
const TO_TOOTH: f64 = 0.64;
const TO_TOOTH_OF_BASE: f64 = 0.82;
const EVENLY: (f64, f64) = (0.96, 0.62);
/// How much steeper than its chord a secondary leaves (radians).
const BEND: f64 = 0.20;
/// Even spacing along a main vein on one side, and where the first begins, shares of the size.
const GAP: f64 = 0.18;
const FIRST: f64 = 0.05;
/// Distance (share of the size) that secondaries keep from other main veins and from each other at their starts.
const CLEAR: f64 = 0.05;
/// Secondaries to teeth begin at least this far apart and from the joint, shares of the size.
const APART: f64 = 0.09;
const NEAREST: f64 = 0.14;
/// The steepest angle (radians) between a main vein and the chord of a secondary.
const STEEPEST: f64 = 1.25;
/// Places of the margin nearer to the joint than this are at the joint, share of the size.
const AT_JOINT: f64 = 0.15;
/// Points (of 17) of its way that a secondary keeps at least: one that soon meets another vein is left out.
const LEAST_OF_WAY: usize = 8;
/// Shortest secondary, share of the size.
const SHORTEST: f64 = 0.06;
/// Where on an entire margin a secondary begins to loop, share of the way to the margin.
const LOOP: f64 = 0.80;

/// All veins of a blade whose joint is the origin, thick ones first. `outline` is dense and counter-clockwise.
pub fn grown(outline: &[DVec2], venation: Venation) -> Vec<Vein> {
    let Some(margin) = Margin::new(outline) else { return Vec::new() };
    let lobes = match venation {
        Venation::Auto => margin.lobes(),
        Venation::Pinnate => Vec::new(),
        Venation::Forking => return forking(&margin),
    };
    Plan::new(&margin, lobes).veins()
}

/// A main vein and its lobe.
struct Main {
    line: Vec<DVec2>,
    lobe: Lobe,
}

struct Plan<'a> {
    margin: &'a Margin,
    mains: Vec<Main>,
    large: Vec<Tooth>,
    small: Vec<Tooth>,
}

impl<'a> Plan<'a> {
    fn new(margin: &'a Margin, lobes: Vec<Lobe>) -> Self {
        let lobes = if lobes.is_empty() { vec![margin.whole()] } else { lobes };
        let line = |lobe: Lobe| Main { line: main_line(margin, lobe), lobe };
        let mut mains: Vec<Main> = lobes.into_iter().map(line).collect();
        mains.sort_by(|a, b| length(&b.line).total_cmp(&length(&a.line)).then(a.lobe.tip.cmp(&b.lobe.tip)));
        let teeth = |least: f64| margin.teeth(least * margin.size);
        let large = teeth(if mains.len() > 1 { LARGE.0 } else { LARGE.1 });
        Self { margin, mains, large, small: teeth(SMALL) }
    }

    fn veins(&self) -> Vec<Vein> {
        let longest = self.mains.iter().map(|main| length(&main.line)).fold(0.0, f64::max);
        let share = |line: &[DVec2]| 0.5 + 0.5 * length(line) / longest;
        let mut veins: Vec<Vein> =
            self.mains.iter().map(|main| self.vein(main.line.clone(), 1, share(&main.line))).collect();
        let (mut seconds, mut thirds) = (Vec::new(), Vec::new());
        for number in 0..self.mains.len() {
            for left in [true, false] {
                let side = self.secondaries(number, left, &seconds);
                thirds.extend(rungs(self.margin, &self.mains[number].line, &side));
                seconds.extend(side);
            }
        }
        let lines: Vec<&[DVec2]> =
            self.mains.iter().map(|main| &main.line).chain(&seconds).map(Vec::as_slice).collect();
        let more = filling(self.margin, &lines, &thirds);
        thirds.extend(more);
        let share = |line: &[DVec2]| 0.6 + 0.4 * (2.0 * length(line) / longest).min(1.0);
        veins.extend(seconds.into_iter().map(|line| {
            let share = share(&line);
            self.vein(line, 2, share)
        }));
        veins.extend(thirds.into_iter().map(|line| self.vein(line, 3, 1.0)));
        veins
    }

    fn vein(&self, points: Vec<DVec2>, order: u8, share: f64) -> Vein {
        let width = WIDTHS[usize::from(order) - 1] * self.margin.size * share;
        Vein { points, width, end_width: width * TAPER, order }
    }

    /// The secondaries on one side of a main vein, from its base to its tip, clear of those made before.
    fn secondaries(&self, number: usize, left: bool, made: &[Vec<DVec2>]) -> Vec<Vec<DVec2>> {
        let lobe = self.mains[number].lobe;
        // Counter-clockwise, the margin on the right of a main vein that points outwards comes before its tip.
        let section = if left { lobe.tip + 1..lobe.to } else { lobe.from..lobe.tip };
        let reach = (CLEAR * self.margin.size / self.margin.spacing) as usize;
        let on_side = |tooth: &&Tooth| section.contains(&tooth.tip) && tooth.tip.abs_diff(lobe.tip) > reach;
        let large: Vec<&Tooth> = self.large.iter().filter(on_side).collect();
        let toothed = large.len() >= 2 && self.large.len() >= 4;
        let ends = if toothed { self.toothed(number, left, &large) } else { self.even(number, left, &section) };
        self.drawn(number, &ends, made)
    }

    /// The way to every large tooth; where two would begin close together the higher tooth is served.
    fn toothed(&self, number: usize, left: bool, teeth: &[&Tooth]) -> Vec<(f64, DVec2)> {
        let lobe = self.mains[number].lobe;
        let bound = self.margin.at(if left { lobe.to } else { lobe.from });
        let angle = if bound.norm() < AT_JOINT * self.margin.size { TO_TOOTH_OF_BASE } else { TO_TOOTH };
        let line = &self.mains[number].line;
        let mut ranked = teeth.to_vec();
        ranked.sort_by(|a, b| b.height.total_cmp(&a.height).then(a.tip.cmp(&b.tip)));
        let mut ends: Vec<(f64, DVec2)> = Vec::new();
        for tooth in ranked {
            let tip = self.margin.at(tooth.tip);
            let Some(start) = self.leaving(line, tip, angle) else { continue };
            if ends.iter().all(|(other, _)| (other - start).abs() > APART * self.margin.size) {
                ends.push((start, tip));
            }
        }
        ends.sort_by(|a, b| a.0.total_cmp(&b.0));
        ends
    }

    /// Where along a line a vein to a place leaves so that its chord makes an angle with the line, or a steeper one that
    /// keeps the chord in the blade; `None` when there is none.
    fn leaving(&self, line: &[DVec2], to: DVec2, angle: f64) -> Option<f64> {
        let whole = length(line);
        let first = (NEAREST * self.margin.size / whole).min(1.0);
        let fits = |share: &f64| {
            let (place, heading) = along(line, share * whole);
            let chord = to - place;
            let found = atan2(heading.perp(&chord).abs(), heading.dot(&chord));
            let inside = |i: u32| self.margin.contains(place + chord * (f64::from(i) / 24.0));
            (angle..STEEPEST).contains(&found) && (1..24).all(inside)
        };
        let shares = (0..=100).map(|i| first + (0.97 - first) * f64::from(i) / 100.0);
        shares.into_iter().find(fits).map(|share| share * whole)
    }

    /// Evenly spaced starts, those of one side in the middle between those of the other, and where the ways end: at the
    /// margin, at a small tooth near by, or half way to another main vein.
    fn even(&self, number: usize, left: bool, section: &Range<usize>) -> Vec<(f64, DVec2)> {
        let (line, size) = (&self.mains[number].line, self.margin.size);
        let whole = length(line);
        let first = if self.mains.len() > 1 { FIRST + 0.5 * GAP } else { FIRST };
        let count = ((whole / size - first) / GAP).max(0.0).ceil() as u32;
        let shift = if left == number.is_multiple_of(2) { 0.0 } else { 0.5 * GAP };
        let start = |i: u32| (first + shift + f64::from(i) * GAP) * size;
        (0..count.min(64))
            .map(start)
            .filter(|s| *s < whole - 0.5 * GAP * size)
            .filter_map(|s| {
                let (place, heading) = along(line, s);
                let angle = EVENLY.0 + (EVENLY.1 - EVENLY.0) * s / whole;
                let direction = turned(heading, if left { angle } else { -angle });
                let (reach, side) = self.margin.reach(place, direction)?;
                let own = section.contains(&side);
                own.then(|| (s, self.at_tooth(place + direction * reach)))
            })
            .collect()
    }

    /// The nearest small tooth within reach, or the place itself.
    fn at_tooth(&self, place: DVec2) -> DVec2 {
        let tips = self.small.iter().map(|tooth| self.margin.at(tooth.tip));
        let nearest = tips.min_by(|a, b| (a - place).norm().total_cmp(&(b - place).norm()));
        nearest.filter(|tip| (tip - place).norm() < DRAWN * self.margin.size).unwrap_or(place)
    }

    /// Lines between starts and ends, bent towards the tip, those left out that come too near to others.
    fn drawn(&self, number: usize, starts: &[(f64, DVec2)], before: &[Vec<DVec2>]) -> Vec<Vec<DVec2>> {
        let (line, size) = (&self.mains[number].line, self.margin.size);
        let entire = self.small.len() < 6;
        let mut made: Vec<Vec<DVec2>> = Vec::new();
        for &(start, end) in starts {
            let (place, heading) = along(line, start);
            let chord = end - place;
            let side = if heading.perp(&chord) > 0.0 { 1.0 } else { -1.0 };
            let bent = |bend: f64| quadratic(place, place + turned(chord, side * bend) * 0.5, end, 16);
            let ways = [BEND, 0.5 * BEND, 0.0].map(bent);
            let reach = |way: &Vec<DVec2>| self.clear(way, number, before);
            let free = ways.iter().find(|way| reach(way) + 1 == way.len()).unwrap_or(&ways[0]);
            let mut way = free[..=reach(free)].to_vec();
            if way.len() < LEAST_OF_WAY {
                continue;
            }
            if entire && self.mains.len() == 1 {
                way = looped(&way, heading);
            }
            let apart = made.last().is_none_or(|other| distance(place, other) > 0.5 * CLEAR * size);
            if length(&way) > SHORTEST * size && apart {
                made.push(way);
            }
        }
        made
    }

    /// Number of the last point of a way up to which it stays in the blade and clear of other main veins.
    fn clear(&self, way: &[DVec2], number: usize, before: &[Vec<DVec2>]) -> usize {
        let free = |p: &DVec2| {
            let others = self.mains.iter().enumerate().filter(|(i, _)| *i != number);
            let own = distance(*p, &self.mains[number].line);
            let nearest = others.map(|(_, main)| distance(*p, &main.line)).fold(f64::INFINITY, f64::min);
            let beside = before.iter().map(|line| distance(*p, line)).fold(f64::INFINITY, f64::min);
            let clear = CLEAR * self.margin.size;
            nearest > own.min(clear) && beside > own.min(0.5 * clear) && self.margin.contains(*p)
        };
        let last = way.len() - 1;
        let kept = way[1..last].iter().take_while(|p| free(p)).count();
        // The end itself lies on the margin.
        if kept + 2 == way.len() { last } else { kept }
    }
}

/// The line of a main vein: from the joint to the tip, drawn half way to the middle of the lobe's neck.
fn main_line(margin: &Margin, lobe: Lobe) -> Vec<DVec2> {
    let tip = margin.at(lobe.tip);
    let (before, after) = (margin.at(lobe.from), margin.at(lobe.to));
    let straight = tip * 0.5;
    // A sinus at the joint gives no hint.
    let near = |p: DVec2| p.norm() < AT_JOINT * margin.size;
    let neck = if near(before) || near(after) { straight } else { straight * 0.5 + (before + after) * 0.25 };
    let line = quadratic(DVec2::zeros(), neck, tip, 24);
    let inside = |p: &&DVec2| p.norm() < 0.05 * margin.size || margin.contains(**p);
    let kept = line[..24].iter().take_while(inside).count();
    if kept == 24 { line } else { quadratic(DVec2::zeros(), straight, tip, 24) }
}

fn turned(v: DVec2, angle: f64) -> DVec2 {
    let (sine, cosine) = sincos(angle);
    DVec2::new(cosine * v.x - sine * v.y, sine * v.x + cosine * v.y)
}

/// The line bent before the margin towards the blade's tip, so that it runs along the margin to the next secondary.
fn looped(way: &[DVec2], heading: DVec2) -> Vec<DVec2> {
    let whole = length(way);
    let (from, _) = along(way, LOOP * whole);
    let (corner, _) = along(way, 0.93 * whole);
    let to = corner + heading * (0.22 * whole) - (corner - way[0]) * 0.06;
    let kept = way.iter().take_while(|p| (**p - way[0]).norm() < (from - way[0]).norm()).copied();
    kept.chain(quadratic(from, corner, to, 6)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::leaf::polygon;
    use std::f64::consts::{FRAC_PI_2, TAU};

    fn star() -> Vec<DVec2> {
        let radius = |angle: f64| 0.04 * (0.6 + 0.4 * crate::base::maths::cos(5.0 * (angle - FRAC_PI_2)));
        let points = (0..900u32).map(|i| TAU * f64::from(i) / 900.0);
        points.map(|a| DVec2::new(sincos(a).1, sincos(a).0) * radius(a) + DVec2::new(0.0, 0.008)).collect()
    }

    fn oval() -> Vec<DVec2> {
        let point = |i: u32| sincos(TAU * f64::from(i) / 600.0);
        (0..600).map(point).map(|(s, c)| DVec2::new(0.02 * c, 0.04 * (s + 1.0))).collect()
    }

    fn count(veins: &[Vein], order: u8) -> usize {
        veins.iter().filter(|v| v.order == order).count()
    }

    #[test]
    fn a_five_lobed_blade_has_five_mains_and_veins_stay_inside() {
        let outline = star();
        let veins = grown(&outline, Venation::Auto);
        assert_eq!(count(&veins, 1), 5);
        let straight = |v: &Vein| v.points[24].x.abs() < 0.05 * v.points[24].y;
        assert!(veins.iter().filter(|v| v.order == 1).any(straight));
        assert!(count(&veins, 2) >= 10);
        for vein in &veins {
            assert!(vein.width > vein.end_width && vein.end_width > 0.0);
            let inside = |p: &DVec2| polygon::contains(&outline, *p) || polygon::distance(&outline, *p) < 2e-4;
            assert!(vein.points.iter().all(inside), "{vein:?}");
        }
    }

    #[test]
    fn every_secondary_begins_on_a_main_vein() {
        for outline in [star(), oval()] {
            let veins = grown(&outline, Venation::Auto);
            let on_main =
                |v: &Vein| veins.iter().filter(|m| m.order == 1).any(|m| distance(v.points[0], &m.points) < 1e-9);
            assert!(veins.iter().filter(|v| v.order == 2).all(on_main));
        }
    }

    #[test]
    fn a_lobed_blade_may_be_pinnate() {
        assert_eq!(count(&grown(&star(), Venation::Pinnate), 1), 1);
    }

    #[test]
    fn an_oval_blade_has_one_midrib_and_pairs_of_secondaries() {
        let veins = grown(&oval(), Venation::Auto);
        assert_eq!(count(&veins, 1), 1);
        let (left, right): (Vec<&Vein>, Vec<&Vein>) =
            veins.iter().filter(|v| v.order == 2).partition(|v| v.points[4].x < 0.0);
        assert!((4..=9).contains(&left.len()) && (4..=9).contains(&right.len()), "{} {}", left.len(), right.len());
    }

    #[test]
    fn outlines_without_area_have_no_veins() {
        assert!(grown(&[], Venation::Auto).is_empty());
        assert!(grown(&[DVec2::zeros(); 12], Venation::Forking).is_empty());
    }
}
