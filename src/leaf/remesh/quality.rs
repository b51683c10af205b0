//! How good a flat triangle mesh is.

use crate::base::maths::acos;
use crate::base::vector::DVec2;
use crate::leaf::remesh::sizing::Sizing;
use crate::leaf::remesh::triangulation::corner_angle;
use std::ops::Range;

/// Rim corners sharper than this excuse the triangles in them: no mesher can open a tip.
pub const SHARP_RIM: f64 = 60.0 * std::f64::consts::PI / 180.0;
/// What a radian of the smallest angle, and one of the edges' variation, count for in the score against mean q.
const ANGLE: f64 = 0.1;
const UNEVENNESS: f64 = 0.2;
/// Beyond this the smallest angle counts no more, radians.
const ENOUGH: f64 = 45.0 * std::f64::consts::PI / 180.0;

/// The figures of a mesh.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Quality {
    /// Smallest angle of the triangles that touch no sharp rim corner, radians.
    pub min_angle: f64,
    /// 1st percentile of the smallest angles of all triangles, radians.
    pub angle_p01: f64,
    /// Mean of q = 2 r/R, twice the incircle's radius over the circumcircle's: 1 for an equilateral triangle.
    pub q_mean: f64,
    /// 5th percentile of q.
    pub q_p05: f64,
    /// Standard deviation of the edges' lengths over their mean.
    pub edge_cv: f64,
    /// Longest over shortest edge.
    pub edge_ratio: f64,
    /// Triangles that are excused from `min_angle`.
    pub excused: usize,
}

impl Quality {
    /// One number to compare rounds by: mean q, less what the smallest angle misses of 45 degrees and the edges' unevenness.
    pub fn score(&self) -> f64 {
        self.q_mean - (ENOUGH - self.min_angle).max(0.0) * ANGLE - self.edge_cv * UNEVENNESS
    }

    /// Whether neither the score nor mean q is worse than those of another mesh.
    pub fn is_no_worse_than(&self, other: &Self) -> bool {
        self.score() >= other.score() && self.q_mean >= other.q_mean
    }
}

/// q = 8 (s-a)(s-b)(s-c) / (abc) and the cosine of the smallest angle.
fn graded_triangle(points: [DVec2; 3]) -> (f64, f64) {
    let squares = [0, 1, 2].map(|i| (points[(i + 1) % 3] - points[i]).norm_squared());
    let [a, b, c] = squares.map(f64::sqrt);
    let ratio = (b + c - a) * (c + a - b) * (a + b - c) / (a * b * c);
    let cosine = |i: usize, b: f64, c: f64| (squares[(i + 1) % 3] + squares[(i + 2) % 3] - squares[i]) / (2.0 * b * c);
    (ratio, cosine(0, b, c).max(cosine(1, c, a)).max(cosine(2, a, b)))
}

/// Which rim vertices are sharp corners.
fn sharp_rim(points: &[DVec2], loops: &[Range<usize>]) -> Vec<bool> {
    let is_sharp = |range: &Range<usize>, i: usize| {
        let before = if i == range.start { range.end } else { i } - 1;
        let after = if i + 1 == range.end { range.start } else { i + 1 };
        corner_angle(points[before], points[i], points[after]) < SHARP_RIM
    };
    loops.iter().flat_map(|range| range.clone().map(move |i| is_sharp(range, i))).collect()
}

/// The value below which a share of the values lies; 0 if there are none.
fn percentile(values: &mut [f64], share: usize) -> f64 {
    let at = values.len() / share;
    if at < values.len() { *values.select_nth_unstable_by(at, f64::total_cmp).1 } else { 0.0 }
}

/// Grades a mesh whose first vertices are its loops.
pub fn graded(points: &[DVec2], loops: &[Range<usize>], triangles: &[[u32; 3]], sizing: Sizing) -> Quality {
    let length = |a: DVec2, b: DVec2| (b - a).norm() / sizing.at((a + b) * 0.5);
    let sharp = sharp_rim(points, loops);
    let is_excused = |t: &[u32; 3]| t.iter().any(|&v| sharp.get(v as usize).copied().unwrap_or(false));
    let (mut ratios, mut cosines) = (Vec::with_capacity(triangles.len()), Vec::with_capacity(triangles.len()));
    let (mut worst, mut excused, mut sides) = (0.5f64, 0, Sides::default());
    for triangle in triangles {
        let corners = triangle.map(|v| points[v as usize]);
        let (ratio, cosine) = graded_triangle(corners);
        ratios.push(ratio);
        cosines.push(-cosine);
        if is_excused(triangle) {
            excused += 1;
        } else {
            worst = worst.max(cosine);
        }
        (0..3).for_each(|i| sides.add(length(corners[i], corners[(i + 1) % 3])));
    }
    for range in loops {
        crate::leaf::polygon::sides(&points[range.clone()]).for_each(|(a, b)| sides.add(length(a, b)));
    }
    let q_mean = ratios.iter().sum::<f64>() / ratios.len().max(1) as f64;
    Quality {
        min_angle: acos(worst.min(1.0)),
        angle_p01: acos((-percentile(&mut cosines, 100)).min(1.0)),
        q_mean,
        q_p05: percentile(&mut ratios, 20),
        edge_cv: sides.variation(),
        edge_ratio: sides.longest / sides.shortest,
        excused,
    }
}

/// Sums over sides; every edge is added twice, by its two triangles or by one and the rim.
#[derive(Debug)]
struct Sides {
    count: f64,
    sum: f64,
    squares: f64,
    shortest: f64,
    longest: f64,
}

impl Default for Sides {
    fn default() -> Self {
        Self { count: 0.0, sum: 0.0, squares: 0.0, shortest: f64::INFINITY, longest: 0.0 }
    }
}

impl Sides {
    fn add(&mut self, length: f64) {
        self.count += 1.0;
        self.sum += length;
        self.squares += length * length;
        self.shortest = self.shortest.min(length);
        self.longest = self.longest.max(length);
    }

    fn variation(&self) -> f64 {
        let mean = self.sum / self.count;
        (self.squares / self.count - mean * mean).max(0.0).sqrt() / mean
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn known_triangles_have_known_figures() {
        let right = [(0.0, 0.0), (1.0, 0.0), (0.0, 1.0)].map(|(x, y)| DVec2::new(x, y));
        let even = [(0.0, 0.0), (1.0, 0.0), (0.5, 0.75f64.sqrt())].map(|(x, y)| DVec2::new(x, y));
        let (ratio, cosine) = graded_triangle(right);
        assert!((ratio - (2.0 * 2f64.sqrt() - 2.0)).abs() < 1e-14 && (cosine - 0.5f64.sqrt()).abs() < 1e-14);
        let (ratio, cosine) = graded_triangle(even);
        assert!((ratio - 1.0).abs() < 1e-14 && (cosine - 0.5).abs() < 1e-14);
    }

    #[test]
    fn a_halved_square_has_known_figures() {
        let square = [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)].map(|(x, y)| DVec2::new(x, y));
        let quality = graded(&square, std::slice::from_ref(&(0..4)), &[[0, 1, 2], [0, 2, 3]], Sizing::EVEN);
        assert!((quality.min_angle - std::f64::consts::FRAC_PI_4).abs() < 1e-12);
        assert!((quality.edge_ratio - 2f64.sqrt()).abs() < 1e-12);
        // Four edges of 1 and one of sqrt 2: their variance is 4/25 (sqrt 2 - 1)^2.
        let (mean, deviation) = ((4.0 + 2f64.sqrt()) / 5.0, 0.4 * (2f64.sqrt() - 1.0));
        assert!((quality.edge_cv - deviation / mean).abs() < 1e-12);
        assert_eq!(quality.excused, 0);
    }
}
