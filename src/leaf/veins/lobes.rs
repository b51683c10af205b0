//! What an outline tells about veins: the lobes that stand out from the joint, and the teeth along the margin.

use crate::base::maths::atan2;
use crate::base::vector::DVec2;
use crate::leaf::polygon;

/// Points to which an outline is resampled.
const LOOKS: usize = 720;
/// A lobe's tip is farther from the joint than the sinuses beside it by this share of the blade's size.
const PROMINENCE: f64 = 0.12;
/// Lobes make a blade palmate when there are three, and they spread over this angle (radians).
const SPREAD: f64 = 1.75;
/// Tips seen from the joint under a smaller angle (radians) belong to one lobe.
const DISTINCT: f64 = 0.30;
/// Half the chords (as lengths of margin, shares of the size) over which a tooth stands out.
const CHORDS: [f64; 2] = [0.06, 0.12];
/// Teeth are at least this far apart along the margin, share of the size.
const APART: f64 = 0.05;

/// An outline with even spacing, counter-clockwise, starting at the point nearest to the joint, which is the origin.
#[derive(Clone, Debug)]
pub struct Margin {
    /// The points.
    pub points: Vec<DVec2>,
    /// Square root of the area.
    pub size: f64,
    /// Length of margin between two points.
    pub spacing: f64,
}

/// A lobe: numbers of margin points.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Lobe {
    /// Where it begins: the sinus before it, or the joint.
    pub from: usize,
    /// Its tip.
    pub tip: usize,
    /// Where it ends.
    pub to: usize,
}

/// A tooth: its tip, and how far it stands out from a chord of the margin, metres.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tooth {
    /// Number of the margin point.
    pub tip: usize,
    /// Height over the chord.
    pub height: f64,
}

impl Margin {
    /// Resamples an outline; `None` when it holds no area.
    pub fn new(outline: &[DVec2]) -> Option<Self> {
        let size = (polygon::doubled_area(outline).abs() * 0.5).sqrt();
        let mut points = resampled(outline);
        let nearest = (0..points.len()).min_by(|&a, &b| points[a].norm().total_cmp(&points[b].norm()));
        points.rotate_left(nearest.unwrap_or(0));
        let spacing = polygon::perimeter(outline) / LOOKS as f64;
        (size > 0.0 && points.len() >= 12).then_some(Self { points, size, spacing })
    }

    /// The point with a number that may run over the end.
    pub fn at(&self, number: usize) -> DVec2 {
        self.points[number % self.points.len()]
    }

    /// The lobes of a palmate blade in order; none when it is not palmate.
    pub fn lobes(&self) -> Vec<Lobe> {
        let lobes = self.distinct();
        let angle = |lobe: &Lobe| {
            let tip = self.at(lobe.tip);
            atan2(tip.x, tip.y)
        };
        let (low, high) =
            lobes.iter().map(angle).fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), a| (l.min(a), h.max(a)));
        if lobes.len() >= 3 && high - low >= SPREAD { lobes } else { Vec::new() }
    }

    /// The lobes that stand out, without those whose tips are seen from the joint close beside farther ones: large teeth.
    fn distinct(&self) -> Vec<Lobe> {
        let mut lobes = self.maxima();
        let close = |a: &Lobe, b: &Lobe| {
            let (a, b) = (self.at(a.tip), self.at(b.tip));
            atan2(a.perp(&b).abs(), a.dot(&b)) < DISTINCT
        };
        while let Some(i) = lobes.windows(2).position(|pair| close(&pair[0], &pair[1])) {
            let (first, second) = (lobes[i], lobes[i + 1]);
            let farther = if self.at(first.tip).norm() >= self.at(second.tip).norm() { first } else { second };
            lobes[i] = Lobe { from: first.from, tip: farther.tip, to: second.to };
            lobes.remove(i + 1);
        }
        lobes
    }

    /// Maxima of the distance from the joint that stand out on both sides.
    fn maxima(&self) -> Vec<Lobe> {
        let count = self.points.len();
        let radius = |i: usize| self.at(i).norm();
        let mut extremes = vec![0];
        let (mut rising, mut best) = (true, 0);
        for i in 0..=count {
            let ahead = radius(i) - radius(best);
            if (rising && ahead >= 0.0) || (!rising && ahead <= 0.0) {
                best = i;
            } else if ahead.abs() > PROMINENCE * self.size {
                extremes.push(best);
                (rising, best) = (!rising, i);
            }
        }
        extremes.push(count);
        let tips = (1..extremes.len().saturating_sub(1)).step_by(2);
        tips.map(|i| Lobe { from: extremes[i - 1], tip: extremes[i], to: extremes[i + 1] }).collect()
    }

    /// The whole blade as one lobe with the tip farthest from the joint.
    pub fn whole(&self) -> Lobe {
        let count = self.points.len();
        let tip = (0..count).max_by(|&a, &b| self.at(a).norm().total_cmp(&self.at(b).norm()).then(b.cmp(&a)));
        Lobe { from: 0, tip: tip.unwrap_or(0), to: count }
    }

    /// Teeth that stand out by at least a height (metres), in order, none within reach of a higher one.
    pub fn teeth(&self, least: f64) -> Vec<Tooth> {
        let count = self.points.len();
        let heights: Vec<f64> = (0..count).map(|i| self.height(i)).collect();
        let reach = ((APART * self.size / self.spacing) as usize).clamp(1, count / 4);
        let highest = |i: &usize| {
            let near = (1..=reach).flat_map(|d| [(i + d) % count, (i + count - d) % count]);
            near.into_iter().all(|j| heights[*i] > heights[j] || (heights[*i] == heights[j] && *i < j))
        };
        let high = (0..count).filter(|&i| heights[i] >= least).filter(highest);
        high.map(|tip| Tooth { tip, height: heights[tip] }).collect()
    }

    /// How far a point lies outside the chords over it, more than the bend of the margin at large would have it, metres;
    /// negative in sinuses.
    fn height(&self, i: usize) -> f64 {
        let own = |chord: f64| self.over_chord(i, chord) - self.over_chord(i, 3.0 * chord) / 9.0;
        CHORDS.into_iter().map(own).fold(f64::NEG_INFINITY, f64::max)
    }

    /// How far a point lies outside the chord between the points a length of margin (share of the size) before and after it:
    /// on an arc proportional to the square of the length.
    fn over_chord(&self, i: usize, length: f64) -> f64 {
        let count = self.points.len();
        let reach = ((length * self.size / self.spacing) as usize).clamp(1, count / 4);
        let (a, b) = (self.at(i + count - reach), self.at(i + reach));
        (self.at(i) - a).perp(&(b - a)) / (b - a).norm().max(1e-12)
    }

    /// How far it is from a point inside to the margin in a direction (unit), and after which of its points it is met.
    pub fn reach(&self, from: DVec2, direction: DVec2) -> Option<(f64, usize)> {
        let meet = |(number, (a, b)): (usize, (DVec2, DVec2))| {
            let (side, to) = (b - a, a - from);
            let turn = direction.perp(&side);
            let (along, across) = (to.perp(&side) / turn, to.perp(&direction) / turn);
            (turn != 0.0 && along > 0.0 && (0.0..=1.0).contains(&across)).then_some((along, number))
        };
        polygon::sides(&self.points).enumerate().filter_map(meet).min_by(|a, b| a.0.total_cmp(&b.0))
    }

    /// Whether a point lies in the blade.
    pub fn contains(&self, p: DVec2) -> bool {
        polygon::contains(&self.points, p)
    }
}

fn resampled(outline: &[DVec2]) -> Vec<DVec2> {
    let total = polygon::perimeter(outline);
    let mut points = Vec::with_capacity(LOOKS);
    let (mut walked, mut next) = (0.0, 0.0);
    for (a, b) in polygon::sides(outline) {
        let side = (b - a).norm();
        while next < walked + side && points.len() < LOOKS {
            points.push(a + (b - a) * ((next - walked) / side));
            next += total / LOOKS as f64;
        }
        walked += side;
    }
    points
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::base::maths::{cos, sincos};
    use std::f64::consts::{FRAC_PI_2, TAU};

    /// A star of unequal rays about a place above the joint.
    fn star(rays: f64, depth: f64) -> Vec<DVec2> {
        let radius = |a: f64| 0.04 * (1.0 - depth + depth * cos(rays * (a - FRAC_PI_2)));
        let angles = (0..900u32).map(|i| TAU * f64::from(i) / 900.0);
        angles.map(|a| DVec2::new(sincos(a).1, sincos(a).0) * radius(a) + DVec2::new(0.0, 0.008)).collect()
    }

    #[test]
    fn a_star_has_a_lobe_for_each_ray() {
        let margin = Margin::new(&star(5.0, 0.4)).unwrap();
        assert_eq!(margin.lobes().len(), 5);
        assert_eq!(margin.points.len(), LOOKS);
        assert!(Margin::new(&star(5.0, 0.02)).unwrap().lobes().is_empty());
    }

    #[test]
    fn teeth_are_where_the_margin_stands_out() {
        let margin = Margin::new(&star(12.0, 0.1)).unwrap();
        let teeth = margin.teeth(0.01 * margin.size);
        assert_eq!(teeth.len(), 12);
        let off = |t: &Tooth| {
            let from = margin.at(t.tip) - DVec2::new(0.0, 0.008);
            1.0 - cos(12.0 * (atan2(from.y, from.x) - FRAC_PI_2))
        };
        assert!(teeth.iter().all(|t| off(t) < 0.1));
    }

    #[test]
    fn reach_is_the_radius_of_a_circle() {
        let margin = Margin::new(&star(1.0, 0.0)).unwrap();
        let found = margin.reach(DVec2::new(0.0, 0.008), DVec2::new(0.6, 0.8)).unwrap().0;
        assert!((found / 0.04 - 1.0).abs() < 1e-3);
    }

    #[test]
    fn outlines_of_nothing_do_no_harm() {
        for outline in [vec![], vec![DVec2::zeros(); 3]] {
            assert!(Margin::new(&outline).is_none());
        }
    }
}
