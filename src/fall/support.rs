//! The plane on which a body comes to rest: of all planes that lie on or above some points, the one that is lowest at the
//! origin.
//!
//! A rigid body that comes down on an uneven bed is at rest where its centre of mass is lowest: on three contacts about it.
//! With x, z the places of its points about the centre and d the height of the bed over the body there, the plane
//! d = c + a x + b z by which the body leans and rises has the least c with c + a x + b z >= d for all: a linear program in
//! three unknowns, solved by the simplex method on its dual. Each step exchanges one of three contacts for the point that
//! the plane leaves highest above it.

use fearless_simd::prelude::*;
use fearless_simd::{Level, dispatch, f64x4};

/// Distance of the points that bound the slopes, over the lengths of bodies.
const FAR: f64 = 1e3;
/// Most exchanges; bodies take a dozen.
const MOST_STEPS: usize = 48;

/// A point: along x, along z, height.
pub(super) type Point = [f64; 3];

/// Points that are looked at together.
const LANES: usize = 4;

/// Points coordinate by coordinate.
#[derive(Default)]
pub(super) struct Cloud(Vec<[[f64; LANES]; 3]>, usize);

impl Cloud {
    /// Takes all points away.
    pub(super) fn clear(&mut self) {
        self.0.clear();
        self.1 = 0;
    }

    /// Adds a point.
    pub(super) fn push(&mut self, point: Point) {
        let lane = self.1 % LANES;
        if lane == 0 {
            // the others of its group are the same point until they are added
            self.0.push(point.map(|value| [value; LANES]));
        } else if let Some(group) = self.0.last_mut() {
            group.iter_mut().zip(point).for_each(|(values, value)| values[lane] = value);
        }
        self.1 += 1;
    }

    /// The point that lies highest above a plane, by more than `least`; the first of several.
    fn highest(&self, plane: [f64; 3], least: f64) -> Option<Point> {
        let (lanes, groups) =
            dispatch!(Level::new(), simd => simd.vectorize(#[inline(always)] || self.highest_with(simd, plane, least)));
        let mut best = (least, f64::INFINITY, 0);
        for lane in 0..LANES {
            if lanes[lane] > best.0 || (lanes[lane] == best.0 && groups[lane] < best.1) {
                best = (lanes[lane], groups[lane], lane);
            }
        }
        let group = self.0.get(best.1 as usize).filter(|_| best.1.is_finite())?;
        Some(group.map(|values| values[best.2]))
    }

    /// The highest of every lane over a plane, with its group.
    #[inline(always)]
    fn highest_with<W: Simd>(&self, simd: W, [c, a, b]: [f64; 3], least: f64) -> ([f64; LANES], [f64; LANES]) {
        let mut highest = f64x4::splat(simd, least);
        let mut groups = f64x4::splat(simd, f64::INFINITY);
        let mut number = 0.0;
        for [x, z, height] in &self.0 {
            let [x, z, height] = [x, z, height].map(|values| f64x4::simd_from(simd, *values));
            let over = height - c - x * a - z * b;
            let is_higher = over.simd_gt(highest);
            highest = is_higher.select(over, highest);
            groups = is_higher.select(f64x4::splat(simd, number), groups);
            number += 1.0;
        }
        (highest.into(), groups.into())
    }

    /// The height of the highest point.
    fn top(&self) -> f64 {
        self.0.iter().flat_map(|group| group[2]).fold(f64::NEG_INFINITY, f64::max)
    }
}

/// The height at the origin and the slopes along x and z of the lowest plane over the points. Slopes reach to about `steepest`;
/// `accuracy` is how far a point may lie above the plane. Without points it is the plane at 0.
pub(super) fn support(points: &Cloud, steepest: f64, accuracy: f64) -> [f64; 3] {
    let top = points.top();
    if !top.is_finite() {
        return [0.0; 3];
    }
    // three points far away, so low that planes through them are as steep as may be
    let low = top - steepest * FAR;
    let mut feet = [[FAR, 0.0, low], [-0.5 * FAR, 0.87 * FAR, low], [-0.5 * FAR, -0.87 * FAR, low]];
    let mut plane = [low, 0.0, 0.0];
    for _ in 0..MOST_STEPS {
        let Some(next) = points.highest(plane, accuracy).and_then(|point| exchanged(&feet, point)) else { break };
        let Some(through) = through(&next) else { break };
        (feet, plane) = (next, through);
    }
    plane
}

/// The feet with one of them exchanged for a point, such that the origin stays between them.
fn exchanged(feet: &[Point; 3], point: Point) -> Option<[Point; 3]> {
    let mut best = (-1e-9, None);
    for place in 0..3 {
        let mut next = *feet;
        next[place] = point;
        let inside = shares(&next).map_or(f64::NEG_INFINITY, |[a, b, c]| a.min(b).min(c));
        if inside > best.0 {
            best = (inside, Some(next));
        }
    }
    best.1
}

/// The shares of three places in the origin: all positive when it lies between them.
fn shares(feet: &[Point; 3]) -> Option<[f64; 3]> {
    let [a, b, c] = feet;
    let cross = |p: &Point, q: &Point| p[0] * q[1] - p[1] * q[0];
    let parts = [cross(b, c), cross(c, a), cross(a, b)];
    let area = parts[0] + parts[1] + parts[2];
    (area.abs() > 1e-15).then(|| parts.map(|part| part / area))
}

/// The plane through three points.
fn through(feet: &[Point; 3]) -> Option<[f64; 3]> {
    let [p, q, r] = feet;
    let (u, v) = ([q[0] - p[0], q[1] - p[1], q[2] - p[2]], [r[0] - p[0], r[1] - p[1], r[2] - p[2]]);
    let area = u[0] * v[1] - u[1] * v[0];
    if area.abs() < 1e-15 {
        return None;
    }
    let a = (u[2] * v[1] - v[2] * u[1]) / area;
    let b = (u[0] * v[2] - v[0] * u[2]) / area;
    Some([p[2] - a * p[0] - b * p[1], a, b])
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::base::random::{Purpose, Stream};

    fn support(points: &[Point], steepest: f64, accuracy: f64) -> [f64; 3] {
        let mut cloud = Cloud::default();
        points.iter().for_each(|point| cloud.push(*point));
        super::support(&cloud, steepest, accuracy)
    }

    #[test]
    fn three_points_about_the_origin_carry_a_plane_and_slopes_are_bounded() {
        let points = [[1.0, 0.0, 0.1], [-1.0, 1.0, 0.2], [-1.0, -1.0, 0.0], [0.1, 0.1, -1.0]];
        let [c, a, b] = support(&points, 1.0, 1e-12);
        for [x, z, d] in &points[..3] {
            assert!((c + a * x + b * z - d).abs() < 1e-12);
        }
        // all on one side: as steep as may be, no further
        let [_, a, b] = support(&[[1.0, 0.0, 0.0], [1.0, 0.1, 0.0]], 0.5, 1e-12);
        assert!(a.abs() < 1.1 && b.abs() < 1.1);
        assert_eq!(support(&[], 1.0, 1e-9), [0.0; 3]);
    }

    #[test]
    fn no_plane_over_the_points_is_lower_at_the_origin() {
        for case in 0..40 {
            let mut stream = Stream::new(7, Purpose::Litter, case, 0);
            let points: Vec<Point> = (0..120)
                .map(|_| [stream.range(-0.04, 0.04), stream.range(-0.05, 0.05), stream.range(0.0, 0.02)])
                .collect();
            let [c, a, b] = support(&points, 1.0, 1e-9);
            assert!(points.iter().all(|[x, z, d]| c + a * x + b * z >= d - 2e-9));
            // convex in the slopes: a minimum against its neighbours is that of all
            let least = |a: f64, b: f64| points.iter().map(|p| p[2] - a * p[0] - b * p[1]).fold(-1.0, f64::max);
            for (da, db) in [(1.0, 0.0), (-1.0, 0.0), (0.0, 1.0), (0.0, -1.0), (0.7, 0.7), (-0.7, 0.7)] {
                assert!(least(a + 1e-4 * da, b + 1e-4 * db) >= c - 1e-8, "{case}");
            }
        }
    }
}
