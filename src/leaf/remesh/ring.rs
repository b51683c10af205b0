//! Where the vertices stand on a loop of the outline: of all ways round, the one that costs least.
//!
//! Candidates stand eight to a spacing, one of them on each corner and on the first key; the first
//! stands where the curve is straightest, for it is a vertex whatever it costs. A way round is a chain of chords; a chord costs by the square of its length's miss of the spacing and by
//! how far the curve strays from it (so that tips and sinuses that show at this spacing become vertices), a joint of two
//! chords by how far its angle is from a whole number of angles of 60 degrees (so that even triangles fit) and, if it is
//! narrow, by how thin its one triangle is. The cheapest chain is found by dynamic programming over pairs of neighbouring vertices.

use crate::base::maths::atan2;
use crate::base::vector::DVec2;
use crate::leaf::remesh::curve::Curve;
use crate::leaf::remesh::energy::shape_cost;
use crate::leaf::remesh::straying::Straying;
use std::f64::consts::{FRAC_PI_3, PI, TAU};

/// Candidates in a spacing, and the fewest in a loop.
const FINENESS: f64 = 8.0;
const FEWEST: usize = 32;
/// Candidates from one vertex to the next, at least and at most.
const SHORTEST: usize = 5;
const LONGEST: usize = 13;
const STEPS: usize = LONGEST - SHORTEST + 1;
/// Angles up to this, radians, are filled by one triangle alone if its ends are near: how much its thinness costs, from
/// which shape cost on, and the most that is asked.
const EAR: f64 = 1.75;
const THIN: f64 = 20.0;
const POINTED: f64 = 1.16;
const FLATTEST: f64 = 2.0;
/// What a corner of the curve and the first key cost that are no vertices.
const SKIPPED: f64 = 0.05;
const FIRST: f64 = 0.15;

/// The candidates of a loop.
struct Candidates {
    arcs: Vec<f64>,
    points: Vec<DVec2>,
    /// What each costs that is no vertex.
    skipped: Vec<f64>,
    /// Aim of a chord's length.
    spacing: f64,
    straying: Straying,
}

/// Cost and direction of the chords that start at each candidate, `STEPS` each.
struct Chords {
    costs: Vec<f64>,
    headings: Vec<f64>,
}

/// Arc lengths of the vertices of a loop at about `spacing`, in order round it; at least three.
pub fn fitted(curve: &Curve, spacing: f64, straying: Straying) -> Vec<f64> {
    let candidates = Candidates::of(curve, spacing, straying);
    candidates.cheapest().into_iter().map(|i| candidates.arcs[i]).collect()
}

/// What an angle inside the rim costs: nought for a multiple of 60 degrees.
pub fn angle_cost(angle: f64) -> f64 {
    let miss = |count: f64| (angle / count - FRAC_PI_3) / FRAC_PI_3;
    let cost = |count: f64| count * miss(count) * miss(count);
    let fewer = (angle / FRAC_PI_3).floor().max(1.0);
    cost(fewer).min(cost(fewer + 1.0))
}

impl Candidates {
    fn of(curve: &Curve, spacing: f64, straying: Straying) -> Self {
        let length = curve.length();
        let count = ((length / spacing * FINENESS).ceil() as usize).max(FEWEST);
        let pitch = length / count as f64;
        let start = straightest(curve, pitch, count);
        let mut arcs: Vec<f64> = (0..=count).map(|i| curve.wrapped(start + i as f64 * pitch)).collect();
        let mut skipped = vec![0.0; count + 1];
        for (corner, cost) in curve.corners().iter().map(|&corner| (corner, SKIPPED)).chain([(0.0, FIRST)]) {
            let nearest = (curve.wrapped(corner - start) / pitch).round() as usize % count;
            (arcs[nearest], skipped[nearest]) = (corner, cost);
        }
        (arcs[count], skipped[count]) = (arcs[0], skipped[0]);
        let points = arcs.iter().map(|&arc| curve.at(arc)).collect();
        Self { arcs, points, skipped, spacing: spacing.min(pitch * FINENESS), straying }
    }

    fn count(&self) -> usize {
        self.arcs.len() - 1
    }

    fn chord(&self, start: usize, end: usize) -> (f64, f64) {
        let from = self.points[start];
        let chord = self.points[end] - from;
        let length = chord.norm();
        let along = if length > 0.0 { chord / length } else { DVec2::zeros() };
        let (mut low, mut high) = (0.0f64, 0.0f64);
        for point in &self.points[start + 1..end] {
            let off = along.perp(&(point - from));
            (low, high) = (low.min(off), high.max(off));
        }
        let skipped: f64 = self.skipped[start + 1..end].iter().sum();
        let (long, wide) = (length / self.spacing - 1.0, (high - low) / self.spacing);
        (long * long + self.straying.of(wide) + skipped, atan2(chord.y, chord.x))
    }

    /// What the triangle costs that must fill a narrow angle between two chords: much if it is thin.
    fn ear(&self, angle: f64, ends: [usize; 3]) -> f64 {
        if angle > EAR {
            return 0.0;
        }
        let [a, b, c] = ends.map(|i| self.points[i]);
        let thin = (shape_cost(a, b, c).min(FLATTEST) - POINTED).max(0.0);
        THIN * thin * thin
    }

    fn chords(&self) -> Chords {
        let count = self.count();
        let mut chords = Chords { costs: vec![f64::INFINITY; count * STEPS], headings: vec![0.0; count * STEPS] };
        for start in 0..count {
            for step in 0..STEPS.min((count + 1).saturating_sub(start + SHORTEST)) {
                let at = start * STEPS + step;
                (chords.costs[at], chords.headings[at]) = self.chord(start, start + SHORTEST + step);
            }
        }
        chords
    }

    /// The candidates of the cheapest way round.
    fn cheapest(&self) -> Vec<usize> {
        let (count, chords) = (self.count(), self.chords());
        // Least cost of a way from 0 to each candidate whose last chord took each step, and the step before that.
        let mut best = vec![(f64::INFINITY, 0u8); (count + 1) * STEPS];
        for step in 0..STEPS {
            best[(SHORTEST + step) * STEPS + step].0 = chords.costs[step];
        }
        for start in SHORTEST..count {
            for step in 0..STEPS.min((count + 1).saturating_sub(start + SHORTEST)) {
                let out = start * STEPS + step;
                let end = &mut (f64::INFINITY, 0u8);
                for before in 0..STEPS.min((start + 1).saturating_sub(SHORTEST)) {
                    let so_far = best[start * STEPS + before].0;
                    if so_far < end.0 {
                        let back = (start - SHORTEST - before) * STEPS + before;
                        let angle = joint(chords.headings[back], chords.headings[out]);
                        let ends = [start - SHORTEST - before, start, start + SHORTEST + step];
                        let cost = so_far + angle_cost(angle) + self.ear(angle, ends);
                        if cost < end.0 {
                            *end = (cost, before as u8);
                        }
                    }
                }
                let place = (start + SHORTEST + step) * STEPS + step;
                if end.0 + chords.costs[out] < best[place].0 {
                    best[place] = (end.0 + chords.costs[out], end.1);
                }
            }
        }
        self.traced_back(&best)
    }

    fn traced_back(&self, best: &[(f64, u8)]) -> Vec<usize> {
        let count = self.count();
        let last = |step: &usize| best[count * STEPS + step].0;
        let mut step = (0..STEPS).min_by(|a, b| last(a).total_cmp(&last(b))).unwrap_or(0);
        let mut at = count;
        let mut ring = Vec::new();
        while at >= SHORTEST + step {
            let before = usize::from(best[at * STEPS + step].1);
            at -= SHORTEST + step;
            step = before;
            ring.push(at);
        }
        ring.reverse();
        ring
    }
}

/// The arc length, of `count` at a `pitch`, about which the curve is straightest: a vertex may stand there at little cost.
fn straightest(curve: &Curve, pitch: f64, count: usize) -> f64 {
    let points: Vec<DVec2> = (0..count).map(|i| curve.at(i as f64 * pitch)).collect();
    let reach = FINENESS as usize;
    let bend = |i: usize| {
        let (from, to) = (points[(i + count - reach) % count], points[(i + reach) % count]);
        let off = |k: usize| (to - from).perp(&(points[(i + count - reach + k) % count] - from)).abs();
        (1..2 * reach).map(off).fold(0.0, f64::max) / (to - from).norm_squared()
    };
    let bends: Vec<f64> = (0..count).map(bend).collect();
    let least = (0..count).min_by(|&a, &b| bends[a].total_cmp(&bends[b]));
    least.map_or(0.0, |i| i as f64 * pitch)
}

/// The angle inside the rim where two chords with these headings join.
fn joint(back: f64, ahead: f64) -> f64 {
    let turn = ahead - back;
    let turn = if turn > PI {
        turn - TAU
    } else if turn < -PI {
        turn + TAU
    } else {
        turn
    };
    PI - turn
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::base::maths::sincos;
    use crate::leaf::remesh::straying::PLANNED;
    use crate::leaf::spline::Spline;

    #[test]
    fn a_circle_is_even() {
        let point = |i: u32| sincos(TAU * f64::from(i) / 64.0);
        let spline = Spline::through(&(0..64).map(point).map(|(s, c)| DVec2::new(c, s)).collect::<Vec<_>>(), PI);
        let curve = Curve::new(&spline, 0.01);
        let ring = fitted(&curve, 0.2, PLANNED);
        assert!((30..=33).contains(&ring.len()), "{}", ring.len());
        let mut steps = (0..ring.len()).map(|i| curve.wrapped(ring[(i + 1) % ring.len()] - ring[i]));
        assert!(steps.all(|s| (0.17..0.23).contains(&s)));
    }

    #[test]
    fn tips_stay_rim_vertices() {
        let star: Vec<DVec2> = (0..10u32)
            .map(|i| (sincos(PI * f64::from(i) / 5.0), if i % 2 == 0 { 1.0 } else { 0.5 }))
            .map(|((s, c), radius)| DVec2::new(c, s) * radius)
            .collect();
        let spline = Spline::through(&star, 0.5);
        let curve = Curve::new(&spline, 0.01);
        let ring: Vec<DVec2> = fitted(&curve, 0.11, PLANNED).into_iter().map(|arc| curve.at(arc)).collect();
        for tip in &star {
            let nearest = ring.iter().map(|p| (p - tip).norm()).fold(9.0, f64::min);
            assert!(nearest < 1e-9, "{tip} is {nearest} from the rim");
        }
    }

    #[test]
    fn whole_numbers_of_even_triangles_cost_nothing() {
        assert!((1..=5).all(|n| angle_cost(f64::from(n) * FRAC_PI_3) < 1e-15));
        assert!((angle_cost(PI / 2.0) - 0.125).abs() < 1e-15);
        assert!(angle_cost(0.3) > angle_cost(0.6));
    }
}
