//! A loop of the outline by arc length: a table of the spline's points tells span and parameter, the spline itself the place.

use crate::base::vector::DVec2;
use crate::leaf::spline::{Spline, turning};

/// A key is a corner where the curve turns at once by more than this, radians.
const BREAK: f64 = 0.35;
/// Entries of the table in a span, at least and at most.
const FEWEST: usize = 8;
const MOST: usize = 4096;
/// Points of the curve that are compared with a chord.
const LOOKS: usize = 8;

/// A closed spline with its arc length.
#[derive(Clone, Debug)]
pub struct Curve<'a> {
    spline: &'a Spline,
    /// Points of the curve; the last repeats the first.
    points: Vec<DVec2>,
    /// Span and parameter of each point.
    places: Vec<(usize, f64)>,
    /// Arc length up to each point, on the polygon of the points.
    arcs: Vec<f64>,
    /// The last entry at or before each of as many even parts of the length as there are entries.
    buckets: Vec<u32>,
    /// Area swept by the ray from the first point, up to each point.
    swept: Vec<f64>,
    /// Arc lengths at which the curve breaks its direction.
    corners: Vec<f64>,
}

impl<'a> Curve<'a> {
    /// The curve with a table no coarser than `step`, as far as `MOST` entries a span allow.
    pub fn new(spline: &'a Spline, step: f64) -> Self {
        let mut places = Vec::new();
        for span in 0..spline.spans() {
            let rough: f64 = (0..8).map(|k| chord(spline, span, k)).sum();
            let count = ((rough / step).ceil() as usize).clamp(FEWEST, MOST);
            places.extend((0..count).map(|k| (span, k as f64 / count as f64)));
        }
        let mut points: Vec<DVec2> = places.iter().map(|&(span, t)| spline.at(span, t)).collect();
        places.push((spline.spans() - 1, 1.0));
        points.push(points[0]);
        let (mut arcs, mut swept) = (vec![0.0], vec![0.0]);
        for (i, pair) in points.windows(2).enumerate() {
            arcs.push(arcs[i] + (pair[1] - pair[0]).norm());
            swept.push(swept[i] + (pair[0] - points[0]).perp(&(pair[1] - points[0])) * 0.5);
        }
        let buckets = buckets(&arcs);
        let mut curve = Self { spline, points, places, arcs, buckets, swept, corners: Vec::new() };
        curve.corners = curve.breaks();
        curve
    }

    fn breaks(&self) -> Vec<f64> {
        let last = self.points.len() - 1;
        let turn =
            |i: usize| turning(self.points[if i == 0 { last } else { i } - 1], self.points[i], self.points[i + 1]);
        (0..last).filter(|&i| self.places[i].1 == 0.0 && turn(i) > BREAK).map(|i| self.arcs[i]).collect()
    }

    /// Length of the closed curve.
    pub fn length(&self) -> f64 {
        self.arcs[self.arcs.len() - 1]
    }

    /// Signed area enclosed, positive when counter-clockwise.
    pub fn area(&self) -> f64 {
        self.swept[self.swept.len() - 1]
    }

    /// Arc lengths of the places where the curve breaks its direction.
    pub fn corners(&self) -> &[f64] {
        &self.corners
    }

    /// Entry of the table before an arc length in 0..=length, and how far on to the next entry, 0..1.
    fn entry(&self, arc: f64) -> (usize, f64) {
        let bucket = ((arc / self.length() * self.buckets.len() as f64) as usize).min(self.buckets.len() - 1);
        let mut i = self.buckets[bucket] as usize;
        while i + 2 < self.arcs.len() && self.arcs[i + 1] <= arc {
            i += 1;
        }
        let side = self.arcs[i + 1] - self.arcs[i];
        (i, if side > 0.0 { ((arc - self.arcs[i]) / side).clamp(0.0, 1.0) } else { 0.0 })
    }

    /// The arc length brought into 0..length.
    pub fn wrapped(&self, arc: f64) -> f64 {
        let length = self.length();
        if arc < 0.0 {
            arc + length
        } else if arc >= length {
            arc - length
        } else {
            arc
        }
    }

    /// The point of the spline at an arc length, which wraps.
    pub fn at(&self, arc: f64) -> DVec2 {
        let (i, part) = self.entry(self.wrapped(arc));
        let (span, t) = self.places[i];
        let next = if self.places[i + 1].0 == span { self.places[i + 1].1 } else { 1.0 };
        self.spline.at(span, t + (next - t) * part)
    }

    fn swept_to(&self, arc: f64) -> f64 {
        let (i, part) = self.entry(arc);
        let from = self.points[0];
        let end = self.points[i] + (self.points[i + 1] - self.points[i]) * part;
        self.swept[i] + (self.points[i] - from).perp(&(end - from)) * 0.5
    }

    /// Signed area between the curve and its chord from one arc length on to another: positive where the curve lies to the
    /// right of the chord, which is outside.
    pub fn cut(&self, start: f64, end: f64) -> f64 {
        let (start, end) = (self.wrapped(start), self.wrapped(end));
        let (a, b) = (self.at(start) - self.points[0], self.at(end) - self.points[0]);
        let round = if end <= start { self.area() } else { 0.0 };
        self.swept_to(end) - self.swept_to(start) + round - a.perp(&b) * 0.5
    }

    /// How far the curve strays from a chord that stands for it from one arc length on to another; looked at in a few points.
    pub fn straying(&self, arcs: [f64; 2], ends: [DVec2; 2]) -> f64 {
        self.farthest(arcs, ends).0
    }

    /// How far the curve strays, and at which arc length it strays most.
    pub fn farthest(&self, [start, end]: [f64; 2], [from, to]: [DVec2; 2]) -> (f64, f64) {
        let chord = to - from;
        let last = self.points.len() - 1;
        let first = self.entry(start).0 + 1;
        let span = self.entry(end).0 + if end <= start { last } else { 0 } - (first - 1);
        let looks = span.min(LOOKS);
        let mut widest = (0.0f64, first);
        for k in 0..looks {
            let i = first + (2 * k + 1) * span / (2 * looks);
            let i = if i >= last { i - last } else { i };
            let off = chord.perp(&(self.points[i] - from)).abs();
            if off > widest.0 {
                widest = (off, i);
            }
        }
        (widest.0 / chord.norm().max(f64::MIN_POSITIVE), self.arcs[widest.1])
    }
}

fn buckets(arcs: &[f64]) -> Vec<u32> {
    let count = arcs.len() - 1;
    let mut entry = 0;
    let start = |bucket: usize| arcs[count] * (bucket as f64 / count as f64) * (1.0 - 1e-12);
    let entries = (0..count).map(|bucket| {
        while entry + 2 < arcs.len() && arcs[entry + 1] <= start(bucket) {
            entry += 1;
        }
        entry as u32
    });
    entries.collect()
}

fn chord(spline: &Spline, span: usize, eighth: u32) -> f64 {
    (spline.at(span, f64::from(eighth + 1) / 8.0) - spline.at(span, f64::from(eighth) / 8.0)).norm()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::base::maths::sincos;
    use std::f64::consts::{PI, TAU};

    fn circle(keys: u32) -> Spline {
        let point = |i: u32| sincos(TAU * f64::from(i) / f64::from(keys));
        Spline::through(&(0..keys).map(point).map(|(s, c)| DVec2::new(c, s)).collect::<Vec<_>>(), PI)
    }

    #[test]
    fn a_circle_is_measured_by_arc_length() {
        let spline = circle(64);
        let curve = Curve::new(&spline, 0.001);
        assert!((curve.length() - TAU).abs() < 1e-5 && (curve.area() - PI).abs() < 1e-5);
        for arc in [0.3, 3.0, 6.0] {
            let (sine, cosine) = sincos(arc);
            assert!((curve.at(arc) - DVec2::new(cosine, sine)).norm() < 1e-5);
            assert!((curve.at(arc - TAU) - curve.at(arc)).norm() < 1e-5);
        }
        // The segment of a circle over the angle w has the area (w - sin w) / 2, and the height 1 - cos(w / 2).
        for start in [0.5, 6.0] {
            assert!((curve.cut(start, start + 1.0) - (1.0 - sincos(1.0).0) / 2.0).abs() < 1e-5);
            let height = 1.0 - sincos(0.5).1;
            let [from, to] = [start, start + 1.0].map(|arc| curve.wrapped(arc));
            let straying = curve.straying([from, to], [curve.at(from), curve.at(to)]);
            assert!(straying <= height + 1e-5 && straying > 0.95 * height);
        }
        assert!(curve.corners().is_empty());
    }

    #[test]
    fn the_corners_of_a_square_are_found() {
        let keys = [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)].map(|(x, y)| DVec2::new(x, y));
        let spline = Spline::through(&keys, 1.0);
        let curve = Curve::new(&spline, 0.1);
        assert_eq!(curve.corners().len(), 4);
        assert!((curve.corners()[2] - 2.0).abs() < 1e-12 && (curve.area() - 1.0).abs() < 1e-12);
    }
}
