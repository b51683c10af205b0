//! Where the vertices stand on a loop of the outline: of all ways round, the one that costs least.
//!
//! Candidates stand eight to a spacing, one of them on each corner. A way round is a chain of chords; a chord costs by the square
//! of its length's miss of the spacing and of how far the curve strays from it (so that tips and sinuses that show at this
//! spacing become vertices), a joint of two chords by how far its angle is from a whole number of angles of 60 degrees (so
//! that even triangles fit). The cheapest chain is found by dynamic programming over pairs of neighbouring vertices.

use crate::base::maths::atan2;
use crate::base::vector::DVec2;
use crate::leaf::remesh::curve::Curve;
use std::f64::consts::{FRAC_PI_3, PI, TAU};

/// Candidates in a spacing, and the fewest in a loop.
const FINENESS: f64 = 8.0;
const FEWEST: usize = 32;
/// Candidates from one vertex to the next, at least and at most.
const SHORTEST: usize = 5;
const LONGEST: usize = 13;
const STEPS: usize = LONGEST - SHORTEST + 1;
/// Weights of straying (in spacings) and of angles (in thirds of pi) against lengths (in spacings).
const STRAYING: f64 = 4.0;
const ANGLE: f64 = 1.0;
/// What a corner of the curve costs that is no vertex.
const SKIPPED: f64 = 0.05;

/// The candidates of a loop.
struct Candidates {
    arcs: Vec<f64>,
    points: Vec<DVec2>,
    /// Which of them are corners.
    is_corner: Vec<bool>,
    /// Aim of a chord's length.
    spacing: f64,
}

/// Cost and direction of the chords that start at each candidate, `STEPS` each.
struct Chords {
    costs: Vec<f64>,
    headings: Vec<f64>,
}

/// Arc lengths of the vertices of a loop at about `spacing`, in order, the first 0; at least three.
pub fn fitted(curve: &Curve, spacing: f64) -> Vec<f64> {
    let candidates = Candidates::of(curve, spacing);
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
    fn of(curve: &Curve, spacing: f64) -> Self {
        let length = curve.length();
        let count = ((length / spacing * FINENESS).ceil() as usize).max(FEWEST);
        let pitch = length / count as f64;
        let mut arcs: Vec<f64> = (0..=count).map(|i| i as f64 * pitch).collect();
        let mut is_corner = vec![false; count + 1];
        for &corner in curve.corners() {
            let nearest = (corner / pitch).round() as usize;
            if (1..count).contains(&nearest) {
                (arcs[nearest], is_corner[nearest]) = (corner, true);
            }
        }
        let points = arcs.iter().map(|&arc| curve.at(arc)).collect();
        Self { arcs, points, is_corner, spacing: spacing.min(pitch * FINENESS) }
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
        let skipped = self.is_corner[start + 1..end].iter().filter(|&&is_corner| is_corner).count();
        let (long, wide) = (length / self.spacing - 1.0, (high - low) / self.spacing);
        (long * long + STRAYING * wide * wide + SKIPPED * skipped as f64, atan2(chord.y, chord.x))
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
                        let cost = so_far + ANGLE * joint(chords.headings[back], chords.headings[out]);
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

/// What the joint of two chords with these headings costs.
fn joint(back: f64, ahead: f64) -> f64 {
    let turn = ahead - back;
    let turn = if turn > PI {
        turn - TAU
    } else if turn < -PI {
        turn + TAU
    } else {
        turn
    };
    angle_cost(PI - turn)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::base::maths::sincos;
    use crate::leaf::spline::Spline;

    #[test]
    fn a_circle_is_even() {
        let point = |i: u32| sincos(TAU * f64::from(i) / 64.0);
        let spline = Spline::through(&(0..64).map(point).map(|(s, c)| DVec2::new(c, s)).collect::<Vec<_>>(), PI);
        let curve = Curve::new(&spline, 0.01);
        let ring = fitted(&curve, 0.2);
        assert!((30..=33).contains(&ring.len()), "{}", ring.len());
        let steps = ring.windows(2).map(|w| w[1] - w[0]).chain([curve.length() - ring[ring.len() - 1]]);
        assert!(steps.into_iter().all(|s| (0.17..0.23).contains(&s)));
    }

    #[test]
    fn tips_stay_rim_vertices() {
        let star: Vec<DVec2> = (0..10u32)
            .map(|i| (sincos(PI * f64::from(i) / 5.0), if i % 2 == 0 { 1.0 } else { 0.5 }))
            .map(|((s, c), radius)| DVec2::new(c, s) * radius)
            .collect();
        let spline = Spline::through(&star, 0.5);
        let curve = Curve::new(&spline, 0.01);
        let ring: Vec<DVec2> = fitted(&curve, 0.11).into_iter().map(|arc| curve.at(arc)).collect();
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
