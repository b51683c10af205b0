//! How well veins agree with a hand trace: centre line against centre line.

use super::skeleton::thinned;
use crate::base::blade::Vein;
use crate::base::vector::DVec2;
use crate::leaf::grid::Grid;
use crate::leaf::raster::{draw_line, filled};
use crate::leaf::trace::Pose;

/// Veins up to this order count as major: hand traces hold main veins and their branches.
pub const MAJOR: u8 = 2;

/// Agreement of centre lines within a tolerance.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Agreement {
    /// Share of the veins' length that lies near the truth's.
    pub precision: f64,
    /// Share of the truth's length that lies near the veins'.
    pub recall: f64,
}

impl Agreement {
    /// Harmonic mean of precision and recall.
    #[must_use]
    pub fn f1(&self) -> f64 {
        2.0 * self.precision * self.recall / (self.precision + self.recall).max(1e-300)
    }
}

/// Compares the major veins with a truth: one closed polygon round the whole vein tree, in pixels, filled by the non-zero
/// rule and thinned. `size` is that of the picture in pixels, `tolerance` is in pixels.
#[must_use]
pub fn agreement(veins: &[Vein], pose: &Pose, truth: &[[f64; 2]], size: (u32, u32), tolerance: f64) -> Agreement {
    let truth: Vec<DVec2> = truth.iter().map(|&p| DVec2::from(p)).collect();
    let wanted = thinned(&filled(&[&truth], size.0 as usize, size.1 as usize));
    let found = thinned(&lines(veins, pose, size));
    let share = |of: &Grid<bool>, near: &Grid<bool>| {
        let distances = near.squared_distances();
        let within = of.cells.iter().zip(&distances.cells).filter(|(c, d)| **c && **d <= tolerance * tolerance);
        within.count() as f64 / of.area().max(1) as f64
    };
    Agreement { precision: share(&found, &wanted), recall: share(&wanted, &found) }
}

/// Correlation (Pearson) over the blade's pixels of the distance to the nearest major vein with that to the nearest centre
/// line of the truth; 0 where one of them is missing. `blade` is its outline in pixels; other arguments as for [`agreement`].
#[must_use]
pub fn distance_correlation(veins: &[Vein], pose: &Pose, truth: &[[f64; 2]], blade: &[DVec2], size: (u32, u32)) -> f64 {
    let truth: Vec<DVec2> = truth.iter().map(|&p| DVec2::from(p)).collect();
    let (width, height) = (size.0 as usize, size.1 as usize);
    let wanted = thinned(&filled(&[&truth], width, height)).squared_distances();
    let found = lines(veins, pose, size).squared_distances();
    let inside = filled(&[blade], width, height);
    let pairs = found.cells.iter().zip(&wanted.cells).zip(&inside.cells).filter(|(_, inside)| **inside);
    correlation(pairs.map(|((a, b), _)| (a.sqrt(), b.sqrt())))
}

/// Pearson's correlation of pairs; 0 when one side does not vary.
fn correlation(pairs: impl Iterator<Item = (f64, f64)>) -> f64 {
    let mut sums = [0.0; 6];
    for (a, b) in pairs {
        for (sum, value) in sums.iter_mut().zip([1.0, a, b, a * a, b * b, a * b]) {
            *sum += value;
        }
    }
    let [n, a, b, aa, bb, ab] = sums;
    let spread = (n * aa - a * a) * (n * bb - b * b);
    // Less is rounding of values that do not vary.
    if spread > 1e-9 * (n * aa) * (n * bb) { (n * ab - a * b) / spread.sqrt() } else { 0.0 }
}

/// The major veins' centre lines in a picture.
fn lines(veins: &[Vein], pose: &Pose, size: (u32, u32)) -> Grid<bool> {
    let (width, height) = (size.0 as usize, size.1 as usize);
    let mut grid = Grid { width, height, cells: vec![false; width * height] };
    for vein in veins.iter().filter(|v| v.order <= MAJOR) {
        let line: Vec<DVec2> = vein.points.iter().map(|&p| pose.pixel(p)).collect();
        draw_line(&mut grid, &line);
    }
    grid
}

#[cfg(test)]
mod tests {
    use super::*;

    fn upright() -> Pose {
        Pose { joint: DVec2::new(50.0, 90.0), axis: DVec2::new(0.0, -1.0), scale: 1e-3 }
    }

    fn vein(order: u8, points: &[(f64, f64)]) -> Vein {
        let points = points.iter().map(|&(x, y)| DVec2::new(x, y) * 1e-3).collect();
        Vein { points, width: 1e-3, end_width: 5e-4, order }
    }

    /// A bar 4 px wide from the joint 80 px upwards.
    const BAR: [[f64; 2]; 4] = [[48.0, 90.0], [52.0, 90.0], [52.0, 10.0], [48.0, 10.0]];

    #[test]
    fn the_truth_s_own_line_agrees_and_one_beside_it_does_not() {
        let along = [vein(1, &[(0.0, 0.0), (0.0, 80.0)])];
        let good = agreement(&along, &upright(), &BAR, (100, 100), 3.0);
        assert!(good.f1() > 0.99, "{good:?}");
        let beside = [vein(1, &[(10.0, 0.0), (10.0, 80.0)])];
        assert_eq!(agreement(&beside, &upright(), &BAR, (100, 100), 3.0).f1(), 0.0);
        assert!(agreement(&beside, &upright(), &BAR, (100, 100), 13.0).f1() > 0.99);
    }

    #[test]
    fn half_a_vein_recalls_half_and_a_stray_one_halves_the_precision() {
        let half = agreement(&[vein(1, &[(0.0, 0.0), (0.0, 40.0)])], &upright(), &BAR, (100, 100), 4.0);
        assert!(half.precision > 0.99 && (half.recall - 0.5).abs() < 0.08, "{half:?}");
        let stray = [vein(1, &[(0.0, 0.0), (0.0, 80.0)]), vein(2, &[(30.0, 0.0), (30.0, 80.0)])];
        let stray = agreement(&stray, &upright(), &BAR, (100, 100), 4.0);
        assert!((stray.precision - 0.5).abs() < 0.05 && stray.recall > 0.99, "{stray:?}");
        let fine = [vein(1, &[(0.0, 0.0), (0.0, 80.0)]), vein(3, &[(30.0, 0.0), (30.0, 80.0)])];
        assert!(agreement(&fine, &upright(), &BAR, (100, 100), 4.0).precision > 0.99, "fine veins do not count");
    }

    #[test]
    fn the_distances_from_the_truth_s_own_line_correlate_fully_and_reversed_ones_do_not() {
        let blade = [(10.0, 5.0), (90.0, 5.0), (90.0, 95.0), (10.0, 95.0)].map(|(x, y)| DVec2::new(x, y));
        let of = |x: f64| {
            let line = [vein(1, &[(x, -5.0), (x, 85.0)])];
            distance_correlation(&line, &upright(), &BAR, &blade, (100, 100))
        };
        assert!(of(0.0) > 0.98 && of(20.0) < of(10.0) && of(10.0) < of(0.0), "{} {} {}", of(0.0), of(10.0), of(20.0));
        assert_eq!(distance_correlation(&[], &upright(), &[], &blade, (100, 100)), 0.0);
    }

    #[test]
    fn nothing_agrees_with_nothing_without_harm() {
        assert_eq!(agreement(&[], &upright(), &[], (10, 10), 1.0).f1(), 0.0);
    }
}
