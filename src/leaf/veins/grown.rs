//! Veins from the outline alone: main veins from the joint to the tips of the lobes (palmate), or one midrib (pinnate);
//! secondaries that leave them alternately at about 45 degrees and bend towards their tips; a third order between. Or
//! veins that do nothing but fork (ginkgo). They serve the mask and the painted textures; they are not a model of growth.

use crate::base::blade::Vein;
use crate::base::maths::{atan2, sincos};
use crate::base::vector::DVec2;
use crate::leaf::Venation;
use crate::leaf::polygon;

/// Samples of the outline on which lobes are sought.
const LOOKS: usize = 720;
/// A lobe's tip is farther from the joint than the sinuses beside it by this share of the blade's size.
const PROMINENCE: f64 = 0.12;
/// Widths of the thick ends as shares of the blade's size; orders go 4 : 2 : 1.
const WIDTHS: [f64; 3] = [0.018, 0.009, 0.0045];

/// How often a forking vein forks on its way to the margin: 64 ends, about a millimetre apart on a ginkgo.
const FORKS: u32 = 6;

/// A lobe: its tip and the middle between the sinuses beside it.
struct Lobe {
    tip: DVec2,
    neck: DVec2,
}

/// All veins of a blade whose joint is the origin, thick ones first. `outline` is dense and counter-clockwise.
pub fn grown(outline: &[DVec2], venation: Venation) -> Vec<Vein> {
    let size = (polygon::doubled_area(outline) * 0.5).sqrt();
    let coarse = resampled(outline, LOOKS);
    let plan = Plan { outline: &coarse, size };
    let mains = match venation {
        Venation::Auto => plan.mains(),
        Venation::Pinnate => vec![plan.midrib()],
        Venation::Forking => return plan.forking(),
    };
    let mut veins: Vec<Vein> = mains.clone();
    for (i, main) in mains.iter().enumerate() {
        let branches = plan.branches(main, 2, &veins, i);
        veins.extend(branches);
    }
    let seconds: Vec<(usize, Vein)> = veins.iter().cloned().enumerate().filter(|(_, v)| v.order == 2).collect();
    for (i, second) in &seconds {
        let branches = plan.branches(second, 3, &veins, *i);
        veins.extend(branches);
    }
    veins
}

fn resampled(outline: &[DVec2], count: usize) -> Vec<DVec2> {
    let total = polygon::perimeter(outline);
    let mut points = Vec::with_capacity(count);
    let (mut walked, mut next) = (0.0, 0.0);
    for (a, b) in polygon::sides(outline) {
        let side = (b - a).norm();
        while next < walked + side && points.len() < count {
            points.push(a + (b - a) * ((next - walked) / side));
            next += total / count as f64;
        }
        walked += side;
    }
    points
}

struct Plan<'a> {
    outline: &'a [DVec2],
    size: f64,
}

impl Plan<'_> {
    /// Main veins: one to each lobe if there are at least three, else a midrib.
    fn mains(&self) -> Vec<Vein> {
        let lobes = self.lobes();
        if lobes.len() < 3 {
            return vec![self.midrib()];
        }
        let longest = lobes.iter().map(|l| l.tip.norm()).fold(0.0, f64::max);
        let mut mains: Vec<Vein> = lobes
            .iter()
            .map(|lobe| self.vein(self.inner(bezier(lobe.neck, lobe.tip)), 1, 0.5 + 0.5 * lobe.tip.norm() / longest))
            .collect();
        mains.sort_by(|a, b| b.width.total_cmp(&a.width));
        mains
    }

    /// One vein from the joint to the farthest point.
    fn midrib(&self) -> Vein {
        let far = |p: &&DVec2| p.norm();
        let tip = self.outline.iter().max_by(|a, b| far(a).total_cmp(&far(b))).copied().unwrap_or_default();
        self.vein(bezier(tip * 0.5, tip), 1, 1.0)
    }

    /// Veins that leave the joint side by side and fork until they meet the margin, even in width and in the angle
    /// between their ends: the open dichotomous venation of ginkgo.
    fn forking(&self) -> Vec<Vein> {
        let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
        // Angles from +y, where the tip lies; near the joint the margin's direction says nothing.
        for p in self.outline.iter().filter(|p| p.norm() > 0.5 * self.size) {
            let angle = atan2(p.x, p.y);
            (low, high) = (low.min(angle), high.max(angle));
        }
        let mut veins = Vec::new();
        self.fork(DVec2::zeros(), (low, high), FORKS, &mut veins);
        veins
    }

    /// The vein from `start` that supplies the sector between two angles, and both its branches.
    fn fork(&self, start: DVec2, (low, high): (f64, f64), left: u32, veins: &mut Vec<Vein>) {
        let middle = 0.5 * (low + high);
        let (sine, cosine) = sincos(middle);
        let direction = DVec2::new(sine, cosine);
        let reach = self.reach(direction);
        // Forks come closer together outwards, so that the veins' distance stays about the same.
        let end = if left == 0 { 1.0 } else { 1.0 - 0.93 * f64::from(left) / f64::from(FORKS) };
        let goal = direction * (reach * end);
        let from = start.norm() / reach;
        let control = direction * (reach * (from + 0.5 * (end - from)).min(end));
        let line = |t: f64| start * ((1.0 - t) * (1.0 - t)) + control * (2.0 * t * (1.0 - t)) + goal * (t * t);
        let points: Vec<DVec2> = self.inner((0..=6).map(|i| line(f64::from(i) / 6.0)).collect());
        let tip = points[points.len() - 1];
        let width = WIDTHS[2] * self.size;
        veins.push(Vein { points, width, end_width: width * 0.8, order: 3 });
        if left > 0 {
            self.fork(tip, (low, middle), left - 1, veins);
            self.fork(tip, (middle, high), left - 1, veins);
        }
    }

    /// How far the blade extends from the joint in a direction.
    fn reach(&self, direction: DVec2) -> f64 {
        let ahead = |p: &&DVec2| p.dot(&direction) / p.norm().max(1e-300);
        let nearest =
            self.outline.iter().filter(|p| p.norm() > 0.2 * self.size).max_by(|a, b| ahead(a).total_cmp(&ahead(b)));
        nearest.map_or(self.size, |p| p.norm()) * 0.985
    }

    fn vein(&self, points: Vec<DVec2>, order: u8, share: f64) -> Vein {
        let width = WIDTHS[usize::from(order) - 1] * self.size * share;
        Vein { points, width, end_width: width * 0.25, order }
    }

    /// The part of a line before it leaves the blade.
    fn inner(&self, line: Vec<DVec2>) -> Vec<DVec2> {
        let ring = self.outline;
        let fits = |p: &DVec2| p.norm() < 0.05 * self.size || polygon::contains(ring, *p);
        let kept: Vec<DVec2> = line.iter().copied().take_while(fits).collect();
        if kept.len() >= 2 { kept } else { line }
    }

    /// Maxima of the distance from the joint that stand out on both sides.
    fn lobes(&self) -> Vec<Lobe> {
        let count = self.outline.len();
        let radius: Vec<f64> = self.outline.iter().map(|p| p.norm()).collect();
        let base = (0..count).min_by(|&a, &b| radius[a].total_cmp(&radius[b])).unwrap_or(0);
        let turned: Vec<usize> = (0..=count).map(|i| (base + i) % count).collect();
        let mut extremes: Vec<usize> = vec![0];
        let (mut rising, mut best) = (true, 0);
        for i in 0..=count {
            let ahead = radius[turned[i]] - radius[turned[best]];
            if (rising && ahead >= 0.0) || (!rising && ahead <= 0.0) {
                best = i;
            } else if ahead.abs() > PROMINENCE * self.size {
                extremes.push(best);
                (rising, best) = (!rising, i);
            }
        }
        extremes.push(count);
        let at = |i: usize| self.outline[turned[extremes[i]]];
        (1..extremes.len().saturating_sub(1))
            .step_by(2)
            .map(|i| Lobe { tip: at(i), neck: self.neck(at(i - 1), at(i), at(i + 1)) })
            .collect()
    }

    /// Where a main vein passes between two sinuses; a sinus at the joint gives no hint.
    fn neck(&self, before: DVec2, tip: DVec2, after: DVec2) -> DVec2 {
        let near = |p: DVec2| p.norm() < 0.15 * self.size;
        let straight = tip * 0.5;
        if near(before) || near(after) { straight } else { straight * 0.5 + (before + after) * 0.25 }
    }

    /// Branches of a vein, alternating sides; they stop before the margin and before other veins.
    fn branches(&self, parent: &Vein, order: u8, others: &[Vein], number: usize) -> Vec<Vein> {
        let length: f64 = parent.points.windows(2).map(|w| (w[1] - w[0]).norm()).sum();
        let (gap, first, angle) = if order == 2 { (0.115, 0.22, 0.80) } else { (0.075, 0.09, 1.0) };
        let mut made: Vec<Vein> = Vec::new();
        let mut walked = first * self.size;
        let mut side = if number.is_multiple_of(2) { 1.0 } else { -1.0 };
        while walked < length - 0.06 * self.size {
            let (start, heading) = along(&parent.points, walked);
            let share = 1.0 - 0.5 * walked / length;
            let line = self.marched(start, heading, side * angle, order, (others, &made, number));
            let reach: f64 = line.windows(2).map(|w| (w[1] - w[0]).norm()).sum();
            if reach > if order == 2 { 0.07 } else { 0.03 } * self.size {
                made.push(self.vein(line, order, share));
            }
            walked += gap * self.size * 0.5;
            side = -side;
        }
        made
    }

    /// Steps from a vein into the blade, the angle to the parent's heading easing to two thirds.
    fn marched(
        &self,
        start: DVec2,
        heading: DVec2,
        angle: f64,
        order: u8,
        near: (&[Vein], &[Vein], usize),
    ) -> Vec<DVec2> {
        let step = 0.02 * self.size;
        let clear = if order == 2 { 0.055 } else { 0.022 } * self.size;
        let most = if order == 2 { 60 } else { 9 };
        let (others, made, number) = near;
        let mut line = vec![start];
        for i in 0..most {
            let turn = angle * (1.0 - 0.33 * f64::from(i) / 20.0).max(0.6);
            let (sine, cosine) = sincos(turn);
            let direction = DVec2::new(cosine * heading.x - sine * heading.y, sine * heading.x + cosine * heading.y);
            let next = line[line.len() - 1] + direction * step;
            let margin = 0.015 * self.size;
            if !polygon::contains(self.outline, next) || polygon::distance(self.outline, next) < margin {
                break;
            }
            let foreign = |(i, v): (usize, &Vein)| i != number && from_vein(next, v).0 < clear;
            if others.iter().enumerate().any(foreign)
                || made.iter().any(|v| i > 1 && from_vein(next, v).0 < clear * 0.6)
            {
                break;
            }
            line.push(next);
        }
        line
    }
}

/// A quadratic curve from the origin.
fn bezier(control: DVec2, end: DVec2) -> Vec<DVec2> {
    (0..=24).map(|i| f64::from(i) / 24.0 * 0.97).map(|t| control * (2.0 * t * (1.0 - t)) + end * (t * t)).collect()
}

/// The point and the heading at a length along a line.
fn along(line: &[DVec2], length: f64) -> (DVec2, DVec2) {
    let mut walked = 0.0;
    for pair in line.windows(2) {
        let side = pair[1] - pair[0];
        if walked + side.norm() >= length {
            return (pair[0] + side * ((length - walked) / side.norm()), side.normalize());
        }
        walked += side.norm();
    }
    let last = line.len() - 1;
    (line[last], (line[last] - line[last - 1]).normalize())
}

/// Distance of a point from a vein's line, and where along the line the nearest piece starts, 0 to 1.
pub fn from_vein(p: DVec2, vein: &Vein) -> (f64, f64) {
    let pieces = vein.points.len() as f64 - 1.0;
    let distance = |(i, w): (usize, &[DVec2])| (polygon::segment_distance(p, w[0], w[1]), i as f64 / pieces);
    vein.points.windows(2).enumerate().map(distance).fold((f64::INFINITY, 0.0), |a, b| if b.0 < a.0 { b } else { a })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn star() -> Vec<DVec2> {
        let radius = |angle: f64| {
            let lobed = 0.6 + 0.4 * crate::base::maths::cos(5.0 * (angle - std::f64::consts::FRAC_PI_2));
            lobed * 0.04
        };
        let points = (0..900u32).map(|i| std::f64::consts::TAU * f64::from(i) / 900.0);
        points.map(|a| DVec2::new(sincos(a).1, sincos(a).0) * radius(a) + DVec2::new(0.0, 0.008)).collect()
    }

    #[test]
    fn a_five_lobed_blade_has_five_mains_and_veins_stay_inside() {
        let outline = star();
        let veins = grown(&outline, Venation::Auto);
        let mains: Vec<&Vein> = veins.iter().filter(|v| v.order == 1).collect();
        assert_eq!(mains.len(), 5);
        assert!(mains.iter().any(|v| v.points[24].x.abs() < 0.05 * v.points[24].y));
        assert!(veins.iter().filter(|v| v.order == 2).count() >= 10);
        for vein in &veins {
            assert!(vein.width > vein.end_width && vein.end_width > 0.0);
            assert!(vein.points.iter().skip(1).all(|&p| polygon::contains(&outline, p)));
        }
    }

    #[test]
    fn a_lobed_blade_may_be_pinnate() {
        let veins = grown(&star(), Venation::Pinnate);
        assert_eq!(veins.iter().filter(|v| v.order == 1).count(), 1);
    }

    #[test]
    fn forking_veins_hang_together_and_end_at_the_margin_all_round() {
        let outline = star();
        let veins = grown(&outline, Venation::Forking);
        // A binary tree of FORKS forks.
        assert_eq!(veins.len(), (2 << FORKS) - 1);
        let starts_on_another = |vein: &&Vein| {
            let start = vein.points[0];
            start.norm() == 0.0 || veins.iter().any(|v| (v.points[v.points.len() - 1] - start).norm() < 1e-12)
        };
        assert!(veins.iter().filter(starts_on_another).count() == veins.len());
        let ends =
            veins.iter().map(|v| v.points[v.points.len() - 1]).filter(|p| polygon::distance(&outline, *p) < 2e-3);
        assert!(ends.count() >= 1 << FORKS);
    }

    #[test]
    fn an_oval_blade_has_one_midrib() {
        let point = |i: u32| sincos(std::f64::consts::TAU * f64::from(i) / 600.0);
        let outline: Vec<DVec2> = (0..600).map(point).map(|(s, c)| DVec2::new(0.02 * c, 0.04 * (s + 1.0))).collect();
        let veins = grown(&outline, Venation::Auto);
        assert_eq!(veins.iter().filter(|v| v.order == 1).count(), 1);
        assert!(veins.iter().filter(|v| v.order == 2).count() >= 6);
    }
}
