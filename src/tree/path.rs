//! The smooth centre line of an axis as rings for the mesh: a cubic Hermite curve through the knots with Catmull-Rom
//! tangents for uneven spacing, and frames carried along without twist (double reflection, Wang, Juettler, Zheng and Liu
//! 2008). Wood keeps its girth up to a fork and loses it just above, as trees do.

use super::axis::{Axis, Knot};
use crate::base::maths::acos;
use crate::base::vector::{DVec3, perpendicular};

/// A ring of the tube.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Ring {
    pub centre: DVec3,
    /// Unit vector along the axis.
    pub tangent: DVec3,
    /// Unit vector to the ring's first vertex.
    pub side: DVec3,
    pub radius: f64,
    /// Change of radius a metre along the axis.
    pub slope: f64,
    /// Length of the axis up to here, metres.
    pub length: f64,
}

/// Largest turn between two rings, radians.
const TURN: f64 = 0.16;
/// Radius above which rings follow each other so closely that no facet shows, metres.
const THICK: f64 = 0.02;
/// Radius below which knots may be left out, metres.
pub(super) const THIN: f64 = 0.006;
/// How far thin wood may be drawn from its line, in its own radii.
const SLACK: f64 = 0.35;
/// The same for the thinnest wood, metres: less than its own radius.
const LEAST_SLACK: f64 = 0.0008;
/// How deep the trunk goes into the ground, metres.
const DEPTH: f64 = 0.3;
/// Length over which the girth falls above a fork, in radii below it.
const SHOULDER: f64 = 2.5;
/// Heights of the rings where the foot flares, in radii.
const FOOT: [f64; 9] = [0.0, 0.25, 0.6, 1.0, 1.5, 2.2, 3.0, 4.2, 6.0];

/// The rings of an axis, appended to `rings`, which is cleared first.
pub(super) fn rings(axis: &Axis, rings: &mut Vec<Ring>) {
    rings.clear();
    let knots = simplified(&axis.knots);
    let root = axis.origin.is_none();
    let mut from = tangent(&knots, 0);
    if root {
        let centre = knots[0].position - DVec3::y() * DEPTH;
        let radius = knots[0].above;
        rings.push(Ring { centre, tangent: from, side: DVec3::x(), radius, slope: 0.0, length: 0.0 });
    }
    let mut shares = Vec::new();
    for at in 0..knots.len() - 1 {
        let (a, b) = (knots[at], knots[at + 1]);
        let to = tangent(&knots, at + 1);
        cuts(&a, &b, (from, to), root && at == 0, &mut shares);
        rings.extend(shares.iter().map(|&share| between(&a, &b, (from, to), share)));
        from = to;
    }
    let end = knots.len() - 1;
    rings.push(between(&knots[end - 1], &knots[end], (tangent(&knots, end - 1), from), 1.0));
    carry_frames(rings);
    slopes(rings);
}

/// Leaves out knots of thin wood that hardly bends.
fn simplified(knots: &[Knot]) -> Vec<Knot> {
    let mut kept = Vec::with_capacity(knots.len());
    kept.push(knots[0]);
    let mut from = 0;
    for at in 1..knots.len() - 1 {
        let thick = knots[at].radius > THIN;
        if thick || at - from > 24 || !is_straight(&knots[from..=at + 1]) {
            kept.push(knots[at]);
            from = at;
        }
    }
    kept.push(knots[knots.len() - 1]);
    kept
}

/// Whether the knots between the ends lie so near the chord, in place and radius, that they are not missed.
fn is_straight(knots: &[Knot]) -> bool {
    let (a, b) = (knots[0], knots[knots.len() - 1]);
    let chord = b.position - a.position;
    let square = chord.norm_squared().max(1e-24);
    knots[1..knots.len() - 1].iter().all(|knot| {
        let offset = knot.position - a.position;
        let share = chord.dot(&offset) / square;
        let radius = a.above + (b.radius - a.above) * share;
        let slack = (SLACK * knot.radius).clamp(LEAST_SLACK, 0.0015);
        (offset - chord * share).norm_squared() < slack * slack && (radius - knot.radius).abs() < 0.2 * knot.radius
    })
}

/// The unit tangent at a knot: the mean of the adjoining directions, each weighted by the other's length; where a fork takes
/// much of the girth away the stem stays straight and the prongs bend.
pub(super) fn tangent(knots: &[Knot], at: usize) -> DVec3 {
    let ahead = knots.get(at + 1).map(|next| next.position - knots[at].position);
    let behind = at.checked_sub(1).map(|last| knots[at].position - knots[last].position);
    let unit = |vector: DVec3| vector.try_normalize(1e-12).unwrap_or_else(DVec3::y);
    match (behind, ahead) {
        (Some(behind), Some(ahead)) => {
            let share = knots[at].above / knots[at].radius.max(1e-12);
            let (behind_weight, ahead_weight) = (ahead.norm(), behind.norm() * share * share * share * share);
            unit(unit(behind) * behind_weight + unit(ahead) * ahead_weight)
        }
        (Some(only), None) | (None, Some(only)) => unit(only),
        (None, None) => DVec3::y(),
    }
}

/// Shares of the curve between two knots where rings stand, from 0, without the end.
fn cuts(a: &Knot, b: &Knot, (from, to): (DVec3, DVec3), foot: bool, shares: &mut Vec<f64>) {
    shares.clear();
    let chord = b.position - a.position;
    let long = chord.norm();
    let along = if long > 1e-12 { chord / long } else { DVec3::y() };
    let turn = acos(from.dot(&along).clamp(-1.0, 1.0)) + acos(to.dot(&along).clamp(-1.0, 1.0));
    let tolerance = if a.above >= THICK { TURN } else { TURN * (THICK / a.above).min(4.0) };
    let bent = (turn / tolerance).ceil();
    // Straight wood needs rings only where its girth changes the run of the bark.
    let slim = if a.above >= THICK { (long / (16.0 * a.above)).ceil() } else { 1.0 };
    let pieces = bent.max(slim).clamp(1.0, 16.0);
    shares.extend((0..pieces as usize).map(|piece| piece as f64 / pieces));
    if foot {
        shares.extend(FOOT.iter().map(|radii| radii * a.above / long).filter(|&share| share < 0.9));
    }
    if a.radius > 1.06 * a.above {
        let shoulder = shoulder(a, long) / long;
        shares.extend([0.33 * shoulder, 0.66 * shoulder, shoulder]);
    }
    if shares.len() > pieces as usize {
        let least = 0.3 * a.above / long;
        shares.sort_by(f64::total_cmp);
        shares.dedup_by(|next, last| *next - *last < least);
        shares.retain(|&share| share < 1.0 - least.min(0.5));
    }
}

/// Over what length the girth falls above a fork, metres.
fn shoulder(a: &Knot, long: f64) -> f64 {
    (SHOULDER * a.radius).min(0.6 * long)
}

/// Radius at a distance from the knot `a` on the way to `b`, which is `long` away.
pub(super) fn radius(a: &Knot, b: &Knot, long: f64, distance: f64) -> f64 {
    let t = (distance / shoulder(a, long).max(1e-9)).clamp(0.0, 1.0);
    let taper = a.above + (b.radius - a.above) * (distance / long.max(1e-9)).clamp(0.0, 1.0);
    taper + (a.radius - a.above) * (1.0 - t * t * (3.0 - 2.0 * t))
}

fn between(a: &Knot, b: &Knot, (from, to): (DVec3, DVec3), t: f64) -> Ring {
    let span = (b.position - a.position).norm();
    let (t2, t3) = (t * t, t * t * t);
    let (h0, h1, m0, m1) = (2.0 * t3 - 3.0 * t2 + 1.0, 3.0 * t2 - 2.0 * t3, t3 - 2.0 * t2 + t, t3 - t2);
    let centre = a.position * h0 + b.position * h1 + (from * m0 + to * m1) * span;
    let (d0, n0, n1) = (6.0 * (t - t2), 3.0 * t2 - 4.0 * t + 1.0, 3.0 * t2 - 2.0 * t);
    let along = (b.position - a.position) * d0 + (from * n0 + to * n1) * span;
    let tangent = along.try_normalize(1e-12).unwrap_or(from);
    Ring { centre, tangent, side: DVec3::x(), radius: radius(a, b, span, t * span), slope: 0.0, length: 0.0 }
}

/// Carries the first side along the rings without twist.
fn carry_frames(rings: &mut [Ring]) {
    rings[0].side = perpendicular(rings[0].tangent);
    let mut length = 0.0;
    for at in 1..rings.len() {
        let (last, ring) = (rings[at - 1], rings[at]);
        length += (ring.centre - last.centre).norm();
        let reflect = |vector: DVec3, mirror: DVec3| {
            let square = mirror.norm_squared();
            if square < 1e-24 { vector } else { vector - mirror * (2.0 * mirror.dot(&vector) / square) }
        };
        let step = ring.centre - last.centre;
        let (side, tangent) = (reflect(last.side, step), reflect(last.tangent, step));
        let side = reflect(side, ring.tangent - tangent);
        let side = side - ring.tangent * ring.tangent.dot(&side);
        rings[at].side = side.try_normalize(1e-9).unwrap_or_else(|| perpendicular(ring.tangent));
        rings[at].length = length;
    }
}

fn slopes(rings: &mut [Ring]) {
    for at in 0..rings.len() {
        let (a, b) = (rings[at.saturating_sub(1)], rings[(at + 1).min(rings.len() - 1)]);
        let run = b.length - a.length;
        rings[at].slope = if run > 1e-9 { ((b.radius - a.radius) / run).clamp(-2.0, 2.0) } else { 0.0 };
    }
}
