//! Axes for the mesh: chains of segments that are drawn as one tube. Where a chain of the turtle ends in a fork, its thickest
//! and straightest child goes on with it, so that forks have no butt.
//!
//! Radii here are those that are seen. They follow the skeleton's but for one thing: a child that leaves its parent is held
//! to `LATERAL` of the parent's radius, or to `FORK` where it is a fork's second prong, over its whole axis, so that it
//! never grows again; what it bears is held likewise. The skeleton keeps the sums of the pipe model.

use super::skeleton::{Segment, Skeleton};
use crate::base::vector::DVec3;

/// A knot of an axis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Knot {
    pub position: DVec3,
    /// Radius of the wood up to here, metres.
    pub radius: f64,
    /// Radius of the wood from here on, metres: less where branches have left.
    pub above: f64,
}

/// Where an axis leaves its parent.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Origin {
    /// Number of the parent's axis.
    pub axis: usize,
    /// Number of the parent's knot.
    pub knot: usize,
}

/// A chain of knots.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Axis {
    /// The stable id of its first segment.
    pub id: u64,
    pub knots: Vec<Knot>,
    /// What it grows out of; `None` when it stands on the ground.
    pub origin: Option<Origin>,
}

/// Share of a tip's radius at its very end.
const TIP: f64 = 0.6;
/// A child that is thinner than this share of its parent is a lateral, else a prong of a fork.
const PRONG: f64 = 0.7;
/// Largest share of its parent's radius that a lateral has.
const LATERAL: f64 = 0.6;
/// The same for a prong.
const FORK: f64 = 0.9;
/// Radius above which wood keeps its girth up to the fork where it loses some, metres; thinner wood tapers evenly.
const THIN: f64 = 0.006;
/// No child.
const NONE: u32 = u32::MAX;

/// All axes of the skeleton, in the order of their first segment, so that parents stand before their children.
pub(super) fn axes(skeleton: &Skeleton) -> Vec<Axis> {
    let segments = &skeleton.segments;
    let links = links(segments);
    // Axis of each segment, and the number of its first knot.
    let mut places = vec![(0u32, 0u32); segments.len()];
    let mut axes: Vec<Axis> = Vec::new();
    let mut caps: Vec<f64> = Vec::new();
    for first in (0..segments.len()).filter(|&number| !links.goes_on[number]) {
        let start = &segments[first];
        let place = start.parent.map(|parent| places[parent as usize]);
        let origin = place.map(|(axis, knot)| Origin { axis: axis as usize, knot: knot as usize + 1 });
        let cap = start.parent.map_or(f64::INFINITY, |parent| {
            let parent = segments[parent as usize].radius;
            let seen = parent.min(caps[places[start.parent.unwrap_or(0) as usize].0 as usize]);
            seen * if start.radius < PRONG * parent { LATERAL } else { FORK }
        });
        let number = axes.len() as u32;
        let knots = follow(segments, first, &links, cap, |at, knot| places[at] = (number, knot));
        axes.push(Axis { id: start.id, knots, origin });
        caps.push(cap);
    }
    axes
}

/// How the segments hang together.
struct Links {
    /// The child that continues each segment's axis, or [`NONE`].
    next: Vec<u32>,
    /// Whether each segment continues its parent's axis.
    goes_on: Vec<bool>,
    /// Sum of the squared radii of the wood that leaves each segment, square metres.
    areas: Vec<f64>,
}

fn links(segments: &[Segment]) -> Links {
    let count = segments.len();
    let (mut next, mut merits) = (vec![NONE; count], vec![0.0f64; count]);
    let mut areas = vec![0.0; count];
    for (number, child) in segments.iter().enumerate() {
        let Some(parent) = child.parent else { continue };
        let segment = &segments[parent as usize];
        areas[parent as usize] += child.radius * child.radius;
        if (child.start - segment.end).norm_squared() >= 1e-18 {
            continue;
        }
        // The turtle's own axis goes on before all others; else the thickest and straightest child that goes forward.
        let merit = if child.axis == segment.axis {
            f64::INFINITY
        } else {
            let cosine = child.direction().dot(&segment.direction());
            if cosine > 0.3 { child.radius * (1.0 + cosine) } else { 0.0 }
        };
        if merit > merits[parent as usize] {
            (next[parent as usize], merits[parent as usize]) = (number as u32, merit);
        }
    }
    let mut goes_on = vec![false; count];
    next.iter().filter(|&&child| child != NONE).for_each(|&child| goes_on[child as usize] = true);
    Links { next, goes_on, areas }
}

/// The knots of the axis that starts with the segment `first`; `place` is told where each segment's first knot is.
fn follow(segments: &[Segment], first: usize, links: &Links, cap: f64, mut place: impl FnMut(usize, u32)) -> Vec<Knot> {
    let start = &segments[first];
    let held = start.radius.min(cap);
    let mut knots = vec![Knot { position: start.start, radius: held, above: held }];
    let mut at = first;
    place(at, 0);
    while links.next[at] != NONE {
        let child = links.next[at] as usize;
        let above = segments[child].radius.min(cap);
        let below = segments[at].radius.min(cap);
        // Up to a fork the wood is as thick as all that leaves it together.
        let radius = if below > THIN { links.areas[at].sqrt().clamp(above, below) } else { above };
        knots.push(Knot { position: segments[at].end, radius, above });
        at = child;
        place(at, knots.len() as u32 - 1);
    }
    let last = &segments[at];
    let tip = last.radius.min(cap) * TIP;
    knots.push(Knot { position: last.end, radius: tip, above: tip });
    knots
}

#[cfg(test)]
mod tests {
    use super::super::{Settings, grow};
    use super::*;
    use crate::base::limits::Limits;

    fn grown(axiom: &str) -> Vec<Axis> {
        let settings = Settings { axiom: axiom.to_owned(), iterations: 0, ..Settings::default() };
        axes(&grow(&settings, 1, &Limits::default()).unwrap().0.skeleton)
    }

    #[test]
    fn radii_never_grow_and_children_are_held_to_their_share() {
        // A lateral of 65 %, a prong of 95 % and what they bear.
        let axes = grown("!(20)F(1)[+!(13)F(1)[+!(12)F(1)]F(1)][-!(19)F(1)F(1)]!(15)F(1)");
        for axis in &axes {
            for pair in axis.knots.windows(2) {
                assert!(pair[0].radius >= pair[0].above && pair[0].above >= pair[1].radius);
            }
        }
        let shares: Vec<f64> = axes
            .iter()
            .filter_map(|axis| Some(axis.knots[0].radius / axes[axis.origin?.axis].knots[axis.origin?.knot].radius))
            .collect();
        assert_eq!(shares.len(), 3);
        let wanted = [LATERAL, FORK, FORK];
        assert!(shares.iter().zip(wanted).all(|(share, wanted)| (share - wanted).abs() < 1e-12), "{shares:?}");
    }

    #[test]
    fn every_branch_starts_at_a_knot_of_its_parent() {
        let axes = grown("!(20)F(1)[+!(9)F(1)F(1)][-!(8)F(1)]!(15)F(1)[+!(7)F(1)]F(1)");
        assert_eq!(axes.len(), 4);
        for axis in &axes[1..] {
            let origin = axis.origin.unwrap();
            assert_eq!(axes[origin.axis].knots[origin.knot].position, axis.knots[0].position);
        }
    }
}
