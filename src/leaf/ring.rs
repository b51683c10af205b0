//! The rim of the mesh: points on the outline, evenly spaced between the corners that show at this spacing.

use crate::base::vector::DVec2;
use crate::leaf::polygon;
use crate::leaf::spline::turning;

/// A bend of the outline by more than this over `WINDOW` spacings to either side is kept as a rim vertex: tips, sinuses.
const KEPT_TURN: f64 = 55.0 * std::f64::consts::PI / 180.0;
const WINDOW: f64 = 0.7;
/// The outline is looked at in this many points a spacing.
const LOOKS: f64 = 12.0;

/// A dense closed line with the arc length at each of its points.
struct Line {
    points: Vec<DVec2>,
    arcs: Vec<f64>,
    length: f64,
}

impl Line {
    fn new(points: Vec<DVec2>) -> Self {
        let mut length = 0.0;
        let mut arcs = Vec::with_capacity(points.len());
        for (a, b) in polygon::sides(&points) {
            arcs.push(length);
            length += (b - a).norm();
        }
        Self { points, arcs, length }
    }

    /// The point at an arc length, which wraps.
    fn at(&self, arc: f64) -> DVec2 {
        let arc = if arc < 0.0 { arc + self.length } else { arc };
        let arc = if arc >= self.length { arc - self.length } else { arc };
        let i = self.arcs.partition_point(|&a| a <= arc).saturating_sub(1);
        let (a, b) = (self.points[i], self.points[(i + 1) % self.points.len()]);
        let side = (b - a).norm();
        a + (b - a) * if side > 0.0 { ((arc - self.arcs[i]) / side).clamp(0.0, 1.0) } else { 0.0 }
    }

    fn gap(&self, a: f64, b: f64) -> f64 {
        let straight = (a - b).abs();
        straight.min(self.length - straight)
    }

    /// Arc lengths of the corners at this spacing, in order; the first is the point nearest the origin.
    fn corners(&self, spacing: f64) -> Vec<f64> {
        let window = WINDOW * spacing;
        let turn = |i: usize| turning(self.at(self.arcs[i] - window), self.points[i], self.at(self.arcs[i] + window));
        let mut sharp: Vec<(f64, f64)> =
            (0..self.points.len()).map(|i| (turn(i), self.arcs[i])).filter(|c| c.0 > KEPT_TURN).collect();
        sharp.sort_by(|a, b| b.0.total_cmp(&a.0).then(a.1.total_cmp(&b.1)));
        let joint = (0..self.points.len()).min_by(|&i, &j| self.points[i].norm().total_cmp(&self.points[j].norm()));
        let mut kept: Vec<f64> = joint.map(|i| self.arcs[i]).into_iter().collect();
        for (_, arc) in sharp {
            if kept.iter().all(|&other| self.gap(arc, other) > window) {
                kept.push(arc);
            }
        }
        kept.sort_by(f64::total_cmp);
        kept
    }
}

/// Rim vertices about `spacing` apart, counter-clockwise like the dense `outline`, moved by a little so that the polygon
/// has the outline's area.
pub fn sampled(outline: &[DVec2], spacing: f64) -> Vec<DVec2> {
    let line = Line::new(polygon::densified(outline, spacing / LOOKS));
    let corners = line.corners(spacing);
    let mut arcs = Vec::new();
    for (rank, &start) in corners.iter().enumerate() {
        let end = if rank + 1 < corners.len() { corners[rank + 1] } else { corners[0] + line.length };
        let least = if corners.len() < 3 { 3 } else { 1 };
        let count = ((end - start) / spacing).round().max(f64::from(least)) as usize;
        arcs.extend((0..count).map(|i| start + (end - start) * i as f64 / count as f64));
    }
    let ring: Vec<DVec2> = arcs.iter().map(|&arc| line.at(arc)).collect();
    with_area(&line, &arcs, &ring)
}

/// Every vertex moves out by what the two chords beside it cut off (half of each), so that area is kept place by place.
fn with_area(line: &Line, arcs: &[f64], ring: &[DVec2]) -> Vec<DVec2> {
    let count = ring.len();
    let cut: Vec<f64> = (0..count).map(|i| segment_area(line, arcs[i], arcs.get(i + 1).copied(), arcs[0])).collect();
    (0..count)
        .map(|i| {
            let (before, after) = (ring[(i + count - 1) % count], ring[(i + 1) % count]);
            let across = after - before;
            let reach = ((ring[i] - before).norm() + (after - ring[i]).norm()) * 0.35;
            let shift = (cut[i] + cut[(i + count - 1) % count]) / across.norm().max(reach);
            ring[i] + DVec2::new(across.y, -across.x).try_normalize(0.0).unwrap_or_default() * shift
        })
        .collect()
}

/// Signed area between a chord and the line it cuts off.
fn segment_area(line: &Line, start: f64, end: Option<f64>, first: f64) -> f64 {
    let end = end.unwrap_or(first + line.length);
    let steps = 16;
    let points: Vec<DVec2> =
        (0..=steps).map(|i| line.at(start + (end - start) * f64::from(i) / f64::from(steps))).collect();
    let origin = points[0];
    points.windows(2).map(|w| (w[0] - origin).perp(&(w[1] - origin)) * 0.5).sum()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::base::maths::sincos;
    use crate::leaf::polygon::doubled_area;

    fn circle(count: u32) -> Vec<DVec2> {
        let angle = |i: u32| std::f64::consts::TAU * f64::from(i) / f64::from(count);
        (0..count).map(|i| sincos(angle(i))).map(|(s, c)| DVec2::new(c, s + 1.0)).collect()
    }

    #[test]
    fn a_circle_is_even_and_keeps_its_area() {
        let ring = sampled(&circle(2000), 0.2);
        let sides: Vec<f64> = polygon::sides(&ring).map(|(a, b)| (b - a).norm()).collect();
        let (low, high) = sides.iter().fold((9.0, 0.0), |(l, h): (f64, f64), &s| (l.min(s), h.max(s)));
        assert!(high / low < 1.01, "{low} to {high}");
        assert!((doubled_area(&ring) / std::f64::consts::TAU - 1.0).abs() < 1e-3);
    }

    #[test]
    fn tips_stay_rim_vertices() {
        let star: Vec<DVec2> = (0..10u32)
            .map(|i| (sincos(std::f64::consts::PI * f64::from(i) / 5.0), if i % 2 == 0 { 1.0 } else { 0.5 }))
            .map(|((s, c), radius)| DVec2::new(c, s) * radius)
            .collect();
        let ring = sampled(&star, 0.11);
        for tip in &star {
            assert!(polygon::distance(&ring, *tip) < 1e-3, "{tip} was lost");
        }
    }
}
