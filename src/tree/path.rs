//! The smooth centre line of an axis as rings for the mesh: a cubic Hermite curve through the knots with Catmull-Rom
//! tangents for uneven spacing, and frames carried along without twist (double reflection, Wang, Juettler, Zheng and Liu
//! 2008).

use super::axis::{Axis, Knot};
use crate::base::maths::{acos, exp};
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
const THIN: f64 = 0.006;
/// How far thin wood may be drawn from its line, in its own radii.
const SLACK: f64 = 0.35;
/// The same for the thinnest wood, metres: less than its own radius.
const LEAST_SLACK: f64 = 0.0008;
/// How much a collar is thicker than the branch where it leaves its parent.
const COLLAR: f64 = 0.4;
/// How deep the trunk goes into the ground, metres.
const DEPTH: f64 = 0.3;

/// The rings of an axis.
pub(super) fn rings(axis: &Axis) -> Vec<Ring> {
    let knots = simplified(&rooted(axis));
    let tangents: Vec<DVec3> = (0..knots.len()).map(|at| tangent(&knots, at)).collect();
    let mut rings: Vec<Ring> = Vec::new();
    for at in 0..knots.len() - 1 {
        let (a, b) = (knots[at], knots[at + 1]);
        let pieces = pieces(&a, &b, tangents[at], tangents[at + 1]);
        for piece in 0..pieces {
            rings.push(between(a, b, tangents[at], tangents[at + 1], piece as f64 / pieces as f64));
        }
    }
    let end = knots.len() - 1;
    rings.push(between(knots[end - 1], knots[end], tangents[end - 1], tangents[end], 1.0));
    if let Some(parent) = axis.parent_radius {
        collar(&mut rings, parent);
    }
    carry_frames(&mut rings);
    slopes(&mut rings);
    rings
}

/// The knots, the trunk's carried into the ground.
fn rooted(axis: &Axis) -> Vec<Knot> {
    let mut knots = axis.knots.clone();
    if axis.parent_radius.is_none() {
        let first = knots[0];
        // More rings where the foot flares.
        let up = knots[1].position - first.position;
        for share in [6.0, 4.0, 3.0, 2.2, 1.6, 1.1, 0.7, 0.3].map(|radii| radii * first.radius / up.norm()) {
            if share < 0.9 {
                let radius = first.radius + (knots[1].radius - first.radius) * share;
                knots.insert(1, Knot { position: first.position + up * share, radius });
            }
        }
        knots.insert(0, Knot { position: first.position - DVec3::y() * DEPTH, radius: first.radius });
    }
    knots
}

/// Leaves out knots of thin wood that hardly bends.
fn simplified(knots: &[Knot]) -> Vec<Knot> {
    let mut kept = vec![knots[0]];
    let mut from = 0;
    for at in 1..knots.len() - 1 {
        let (a, b) = (knots[from], knots[at + 1]);
        let straight = knots[from + 1..=at].iter().all(|knot| {
            let along = (b.position - a.position).try_normalize(1e-12).unwrap_or_else(DVec3::y);
            let offset = knot.position - a.position;
            let share = along.dot(&offset) / (b.position - a.position).norm().max(1e-12);
            let radius = a.radius + (b.radius - a.radius) * share;
            let aside = (offset - along * along.dot(&offset)).norm();
            aside < (SLACK * knot.radius).clamp(LEAST_SLACK, 0.0015) && (radius - knot.radius).abs() < 0.2 * knot.radius
        });
        if knots[at].radius > THIN || !straight || at - from > 24 {
            kept.push(knots[at]);
            from = at;
        }
    }
    kept.push(knots[knots.len() - 1]);
    kept
}

/// The unit tangent at a knot: the mean of the adjoining directions, each weighted by the other's length.
fn tangent(knots: &[Knot], at: usize) -> DVec3 {
    let ahead = knots.get(at + 1).map(|next| next.position - knots[at].position);
    let behind = at.checked_sub(1).map(|last| knots[at].position - knots[last].position);
    let unit = |vector: DVec3| vector.try_normalize(1e-12).unwrap_or_else(DVec3::y);
    match (behind, ahead) {
        (Some(behind), Some(ahead)) => unit(unit(behind) * ahead.norm() + unit(ahead) * behind.norm()),
        (Some(only), None) | (None, Some(only)) => unit(only),
        (None, None) => DVec3::y(),
    }
}

/// Into how many pieces the curve between two knots is cut.
fn pieces(a: &Knot, b: &Knot, from: DVec3, to: DVec3) -> usize {
    let chord = b.position - a.position;
    let along = chord.try_normalize(1e-12).unwrap_or_else(DVec3::y);
    let turn = acos(from.dot(&along).clamp(-1.0, 1.0)) + acos(to.dot(&along).clamp(-1.0, 1.0));
    let tolerance = if a.radius >= THICK { TURN } else { TURN * (THICK / a.radius).min(4.0) };
    let pieces = (turn / tolerance).ceil().max(1.0);
    let long = if a.radius >= THICK { (chord.norm() / (6.0 * a.radius)).ceil() } else { 1.0 };
    pieces.max(long).min(16.0) as usize
}

fn between(a: Knot, b: Knot, from: DVec3, to: DVec3, t: f64) -> Ring {
    let span = (b.position - a.position).norm();
    let (t2, t3) = (t * t, t * t * t);
    let (h0, h1, m0, m1) = (2.0 * t3 - 3.0 * t2 + 1.0, 3.0 * t2 - 2.0 * t3, t3 - 2.0 * t2 + t, t3 - t2);
    let centre = a.position * h0 + b.position * h1 + (from * m0 + to * m1) * span;
    let (d0, n0, n1) = (6.0 * (t - t2), 3.0 * t2 - 4.0 * t + 1.0, 3.0 * t2 - 2.0 * t);
    let along = (b.position - a.position) * d0 + (from * n0 + to * n1) * span;
    let tangent = along.try_normalize(1e-12).unwrap_or(from);
    let radius = a.radius + (b.radius - a.radius) * t;
    Ring { centre, tangent, side: DVec3::x(), radius, slope: 0.0, length: 0.0 }
}

/// Swells a branch where it leaves wood of radius `parent`; the swelling never exceeds the parent.
fn collar(rings: &mut Vec<Ring>, parent: f64) {
    let first = rings[0];
    let reach = parent + 1.5 * first.radius;
    let second = rings[1];
    let room = (second.centre - first.centre).norm();
    if first.radius >= 0.003 && room > reach * 1.2 {
        // A ring at the end of the swelling and one at the parent's surface, on the first piece's line.
        for distance in [reach, parent] {
            let t = distance / room;
            let centre = first.centre + (second.centre - first.centre) * t;
            let radius = first.radius + (second.radius - first.radius) * t;
            rings.insert(1, Ring { centre, radius, ..first });
        }
    }
    for ring in rings.iter_mut() {
        let beyond = ((ring.centre - first.centre).norm() - parent).max(0.0) / (0.8 * first.radius);
        ring.radius = (ring.radius * (1.0 + COLLAR * exp(-beyond))).min(parent.max(ring.radius));
    }
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
