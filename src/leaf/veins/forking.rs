//! Veins that leave the joint side by side and fork until they meet the margin, even in width and in the angle between
//! their ends: the open dichotomous venation of ginkgo.

use super::line::quadratic;
use super::lobes::Margin;
use crate::base::blade::Vein;
use crate::base::maths::{atan2, sincos};
use crate::base::vector::DVec2;

/// How often a forking vein forks on its way to the margin: 64 ends, about a millimetre apart on a ginkgo.
const FORKS: u32 = 6;
/// Width of all veins, share of the size.
const WIDTH: f64 = 0.0045;

/// All veins of the blade; every vein starts at the joint or at another's end.
pub fn forking(margin: &Margin) -> Vec<Vein> {
    let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
    // Angles from +y, where the tip lies; near the joint the margin's direction says nothing.
    for p in margin.points.iter().filter(|p| p.norm() > 0.5 * margin.size) {
        let angle = atan2(p.x, p.y);
        (low, high) = (low.min(angle), high.max(angle));
    }
    let mut veins = Vec::new();
    if low <= high {
        fork(margin, DVec2::zeros(), (low, high), FORKS, &mut veins);
    }
    veins
}

/// The vein from `start` that supplies the sector between two angles, and both its branches.
fn fork(margin: &Margin, start: DVec2, (low, high): (f64, f64), left: u32, veins: &mut Vec<Vein>) {
    let middle = 0.5 * (low + high);
    let (sine, cosine) = sincos(middle);
    let direction = DVec2::new(sine, cosine);
    let reach = reach(margin, direction);
    // Forks come closer together outwards, so that the veins' distance stays about the same.
    let end = if left == 0 { 1.0 } else { 1.0 - 0.93 * f64::from(left) / f64::from(FORKS) };
    let from = start.norm() / reach;
    let control = direction * (reach * (from + 0.5 * (end - from)).min(end));
    let points = inner(margin, quadratic(start, control, direction * (reach * end), 6));
    let tip = points[points.len() - 1];
    let width = WIDTH * margin.size;
    veins.push(Vein { points, width, end_width: width * 0.8, order: 3 });
    if left > 0 {
        fork(margin, tip, (low, middle), left - 1, veins);
        fork(margin, tip, (middle, high), left - 1, veins);
    }
}

/// How far the blade extends from the joint in a direction.
fn reach(margin: &Margin, direction: DVec2) -> f64 {
    let ahead = |p: &&DVec2| p.dot(&direction) / p.norm().max(1e-300);
    let far = margin.points.iter().filter(|p| p.norm() > 0.2 * margin.size);
    far.max_by(|a, b| ahead(a).total_cmp(&ahead(b))).map_or(margin.size, |p| p.norm()) * 0.985
}

/// The part of a line before it leaves the blade; the whole line when it leaves at once.
fn inner(margin: &Margin, line: Vec<DVec2>) -> Vec<DVec2> {
    let fits = |p: &DVec2| p.norm() < 0.05 * margin.size || margin.contains(*p);
    let kept = line.iter().take_while(|p| fits(p)).count();
    if kept >= 2 { line[..kept].to_vec() } else { line }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::leaf::polygon;
    use std::f64::consts::{FRAC_PI_2, TAU};

    #[test]
    fn forking_veins_hang_together_and_end_at_the_margin_all_round() {
        let radius = |a: f64| 0.04 * (0.6 + 0.4 * crate::base::maths::cos(5.0 * (a - FRAC_PI_2)));
        let angles = (0..900u32).map(|i| TAU * f64::from(i) / 900.0);
        let point = |a: f64| DVec2::new(sincos(a).1, sincos(a).0) * radius(a) + DVec2::new(0.0, 0.008);
        let outline: Vec<DVec2> = angles.map(point).collect();
        let veins = forking(&Margin::new(&outline).unwrap());
        // A binary tree of FORKS forks.
        assert_eq!(veins.len(), (2 << FORKS) - 1);
        let starts_on_another = |vein: &&Vein| {
            let start = vein.points[0];
            start.norm() == 0.0 || veins.iter().any(|v| (v.points[v.points.len() - 1] - start).norm() < 1e-12)
        };
        assert_eq!(veins.iter().filter(starts_on_another).count(), veins.len());
        let ends =
            veins.iter().map(|v| v.points[v.points.len() - 1]).filter(|p| polygon::distance(&outline, *p) < 2e-3);
        assert!(ends.count() >= 1 << FORKS);
    }
}
