//! Polylines: lengths, places along them, distances from them.

use crate::base::vector::DVec2;
use crate::leaf::polygon;

/// Length of a line.
pub fn length(line: &[DVec2]) -> f64 {
    line.windows(2).map(|w| (w[1] - w[0]).norm()).sum()
}

/// The point and the heading (unit) at a length along a line; beyond the end, those of the end.
pub fn along(line: &[DVec2], length: f64) -> (DVec2, DVec2) {
    let mut walked = 0.0;
    let mut last = (line.first().copied().unwrap_or_default(), DVec2::y());
    for pair in line.windows(2) {
        let side = pair[1] - pair[0];
        let step = side.norm();
        if step > 0.0 {
            if walked + step >= length {
                return (pair[0] + side * ((length - walked) / step), side / step);
            }
            last = (pair[1], side / step);
        }
        walked += step;
    }
    last
}

/// Distance of a point from a line.
pub fn distance(p: DVec2, line: &[DVec2]) -> f64 {
    line.windows(2).map(|w| polygon::segment_distance(p, w[0], w[1])).fold(f64::INFINITY, f64::min)
}

/// A quadratic curve (Bezier) as a line of `pieces` pieces.
pub fn quadratic(from: DVec2, control: DVec2, to: DVec2, pieces: u32) -> Vec<DVec2> {
    let at = |t: f64| from * ((1.0 - t) * (1.0 - t)) + control * (2.0 * t * (1.0 - t)) + to * (t * t);
    (0..=pieces).map(|i| at(f64::from(i) / f64::from(pieces))).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn places_along_a_bent_line() {
        let line = [(0.0, 0.0), (0.0, 3.0), (0.0, 3.0), (4.0, 3.0)].map(|(x, y)| DVec2::new(x, y));
        assert_eq!(length(&line), 7.0);
        assert_eq!(along(&line, 5.0), (DVec2::new(2.0, 3.0), DVec2::x()));
        assert_eq!(along(&line, 9.0), (DVec2::new(4.0, 3.0), DVec2::x()));
        assert_eq!(distance(DVec2::new(3.0, 5.0), &line), 2.0);
    }

    #[test]
    fn a_quadratic_curve_ends_at_its_ends() {
        let line = quadratic(DVec2::zeros(), DVec2::new(1.0, 2.0), DVec2::new(2.0, 0.0), 4);
        assert_eq!((line[0], line[2], line[4]), (DVec2::zeros(), DVec2::new(1.0, 1.0), DVec2::new(2.0, 0.0)));
    }
}
