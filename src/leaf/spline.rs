//! The closed cubic spline through key points, with centripetal parameters (Lee 1989; spacing sqrt of the chord), broken
//! at sharp key points. It is the interpolating cubic B-spline of the paper's section 3, kept as its second derivatives
//! at the keys (the same function; de Boor, "A Practical Guide to Splines", chapter IV). Between two corners the ends are
//! natural; without corners the spline is periodic and twice continuously differentiable everywhere.

use crate::base::maths::atan2;
use crate::base::vector::DVec2;

/// A closed curve of one cubic for each pair of neighbouring keys.
#[derive(Clone, Debug, PartialEq)]
pub struct Spline {
    keys: Vec<DVec2>,
    corners: Vec<bool>,
    /// Parameter length of the span that starts at each key.
    widths: Vec<f64>,
    /// Second derivatives at both ends of each span.
    bends: Vec<[DVec2; 2]>,
}

/// The angle by which the line a-b-c turns at b, 0 to pi.
pub fn turning(a: DVec2, b: DVec2, c: DVec2) -> f64 {
    let (back, ahead) = (b - a, c - b);
    atan2(back.perp(&ahead), back.dot(&ahead)).abs()
}

impl Spline {
    /// The curve through `keys` (at least 3, neighbours distinct); it may break its direction where the polygon of the keys
    /// turns by more than `corner` radians.
    pub fn through(keys: &[DVec2], corner: f64) -> Self {
        let count = keys.len();
        let sharp = |i: usize| turning(keys[(i + count - 1) % count], keys[i], keys[(i + 1) % count]) > corner;
        Self::broken_at(keys, (0..count).map(sharp).collect())
    }

    /// The curve through `keys` that may break its direction at those marked, one mark a key.
    pub fn broken_at(keys: &[DVec2], corners: Vec<bool>) -> Self {
        let count = keys.len();
        let widths: Vec<f64> = (0..count).map(|i| (keys[(i + 1) % count] - keys[i]).norm().sqrt()).collect();
        let mut spline = Self { keys: keys.to_vec(), corners, widths, bends: vec![[DVec2::zeros(); 2]; count] };
        let places: Vec<usize> = (0..count).filter(|&i| spline.corners[i]).collect();
        if places.is_empty() {
            spline.bend_round();
        }
        for (rank, &start) in places.iter().enumerate() {
            let end = places[(rank + 1) % places.len()];
            spline.bend_stretch(start, (end + count - start - 1) % count + 1);
        }
        spline
    }

    /// Number of spans, which is the number of keys.
    pub fn spans(&self) -> usize {
        self.keys.len()
    }

    /// Whether the curve may break its direction at a key.
    #[cfg(test)]
    pub fn is_corner(&self, key: usize) -> bool {
        self.corners[key]
    }

    /// The point of a span at `t` in 0..1; exactly a key at both ends.
    pub fn at(&self, span: usize, t: f64) -> DVec2 {
        let (s, width) = (1.0 - t, self.widths[span]);
        let line = self.keys[span] * s + self.keys[(span + 1) % self.keys.len()] * t;
        let [first, last] = self.bends[span];
        line + (first * (s * s * s - s) + last * (t * t * t - t)) * (width * width / 6.0)
    }

    /// The curve as a polygon of `per_span` points a span, keys included.
    pub fn polyline(&self, per_span: usize) -> Vec<DVec2> {
        (0..self.spans())
            .flat_map(|span| (0..per_span).map(move |i| (span, i as f64 / per_span as f64)))
            .map(|(span, t)| self.at(span, t))
            .collect()
    }

    /// Six times the jump of the chord's slope at a key: the right-hand side of the continuity equations.
    fn jump(&self, key: usize) -> DVec2 {
        let count = self.keys.len();
        let before = (key + count - 1) % count;
        let slope = |i: usize| (self.keys[(i + 1) % count] - self.keys[i]) / self.widths[i];
        (slope(key) - slope(before)) * 6.0
    }

    /// Natural spline over `spans` spans from the corner `start`.
    fn bend_stretch(&mut self, start: usize, spans: usize) {
        let count = self.keys.len();
        let inner: Vec<usize> = (1..spans).map(|i| (start + i) % count).collect();
        let width = |key: usize| self.widths[key];
        let before = |key: usize| self.widths[(key + count - 1) % count];
        let lower: Vec<f64> = inner.iter().map(|&k| before(k)).collect();
        let upper: Vec<f64> = inner.iter().map(|&k| width(k)).collect();
        let diagonal: Vec<f64> = inner.iter().map(|&k| 2.0 * (before(k) + width(k))).collect();
        let right: Vec<DVec2> = inner.iter().map(|&k| self.jump(k)).collect();
        let bends = tridiagonal(&lower, &diagonal, &upper, &right);
        for (&key, &bend) in inner.iter().zip(&bends) {
            self.bends[key][0] = bend;
            self.bends[(key + count - 1) % count][1] = bend;
        }
    }

    /// Periodic spline: the cyclic system by Sherman and Morrison's rank-one update.
    fn bend_round(&mut self) {
        let count = self.keys.len();
        let before = |key: usize| self.widths[(key + count - 1) % count];
        let lower: Vec<f64> = (0..count).map(before).collect();
        let upper = self.widths.clone();
        let mut diagonal: Vec<f64> = (0..count).map(|k| 2.0 * (before(k) + upper[k])).collect();
        let (corner, gamma) = (lower[0], -diagonal[0]);
        diagonal[0] -= gamma;
        diagonal[count - 1] -= corner * corner / gamma;
        let right: Vec<DVec2> = (0..count).map(|k| self.jump(k)).collect();
        let mut update = vec![DVec2::zeros(); count];
        update[0] = DVec2::repeat(gamma);
        update[count - 1] = DVec2::repeat(corner);
        let x = tridiagonal(&lower, &diagonal, &upper, &right);
        let z = tridiagonal(&lower, &diagonal, &upper, &update);
        let ratio = corner / gamma;
        let scale = 1.0 + z[0].x + ratio * z[count - 1].x;
        let factor = (x[0] + x[count - 1] * ratio) / scale;
        for key in 0..count {
            let bend = x[key] - factor.component_mul(&z[key]);
            self.bends[key][0] = bend;
            self.bends[(key + count - 1) % count][1] = bend;
        }
    }
}

/// Solves a diagonally dominant tridiagonal system (Thomas); `lower[0]` and the last of `upper` are not read.
fn tridiagonal(lower: &[f64], diagonal: &[f64], upper: &[f64], right: &[DVec2]) -> Vec<DVec2> {
    let count = right.len();
    let mut ratios = vec![0.0; count];
    let mut solution = vec![DVec2::zeros(); count];
    for i in 0..count {
        let (ratio, previous) = if i == 0 { (0.0, DVec2::zeros()) } else { (ratios[i - 1], solution[i - 1]) };
        let below = if i == 0 { 0.0 } else { lower[i] };
        let pivot = diagonal[i] - below * ratio;
        ratios[i] = upper[i] / pivot;
        solution[i] = (right[i] - previous * below) / pivot;
    }
    for i in (0..count.saturating_sub(1)).rev() {
        let next = solution[i + 1];
        solution[i] -= next * ratios[i];
    }
    solution
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::base::maths::{ln, sincos};
    use std::f64::consts::{PI, TAU};

    fn ellipse(count: usize) -> Vec<DVec2> {
        (0..count)
            .map(|i| {
                let angle = TAU * i as f64 / count as f64;
                let (sine, cosine) = sincos(angle + 0.3 * sincos(angle).0);
                DVec2::new(2.0 * cosine, sine)
            })
            .collect()
    }

    fn error(count: usize) -> f64 {
        let spline = Spline::through(&ellipse(count), PI);
        spline.polyline(32).iter().map(|p| (p.x * p.x / 4.0 + p.y * p.y - 1.0).abs()).fold(0.0, f64::max)
    }

    #[test]
    fn keys_are_interpolated_and_the_curve_is_twice_smooth() {
        let keys = ellipse(17);
        let spline = Spline::through(&keys, PI);
        for span in 0..17 {
            assert!((spline.at(span, 0.0) - keys[span]).norm() < 1e-12);
            assert!((spline.at(span, 1.0) - keys[(span + 1) % 17]).norm() < 1e-12);
            let slope = |span: usize, t: f64| (spline.at(span, t + 1e-5) - spline.at(span, t - 1e-5)) / 2e-5;
            let before = slope(span, 1.0) / spline.widths[span];
            let after = slope((span + 1) % 17, 0.0) / spline.widths[(span + 1) % 17];
            assert!((before - after).norm() < 1e-6, "span {span}: {before} {after}");
        }
    }

    #[test]
    fn an_ellipse_is_met_with_fourth_order() {
        let errors = [16, 32, 64, 128].map(error);
        for pair in errors.windows(2).skip(1) {
            let order = ln(pair[0] / pair[1]) / ln(2.0);
            assert!(order > 3.7, "order {order} of {errors:?}");
        }
    }

    #[test]
    fn corners_keep_straight_sides_straight() {
        let square = [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)].map(|(x, y)| DVec2::new(x, y));
        let spline = Spline::through(&square, 1.0);
        assert!((0..4).all(|key| spline.is_corner(key)));
        assert!((spline.at(0, 0.5) - DVec2::new(0.5, 0.0)).norm() < 1e-15);
    }

    #[test]
    fn one_corner_makes_one_stretch_round() {
        let keys = [(0.0, 0.0), (1.0, -0.6), (2.0, 0.0), (1.6, 1.0), (0.6, 1.0)].map(|(x, y)| DVec2::new(x, y));
        let spline = Spline::through(&keys, 1.57);
        assert_eq!((0..5).filter(|&k| spline.is_corner(k)).count(), 1);
        assert!((0..5).all(|k| (spline.at(k, 0.0) - keys[k]).norm() < 1e-12));
    }
}
