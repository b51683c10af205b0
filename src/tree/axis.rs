//! Axes for the mesh: chains of segments that are drawn as one tube. Where a chain of the turtle ends in a fork, its thickest
//! and straightest child goes on with it, so that forks have no butt.

use super::skeleton::Skeleton;
use crate::base::vector::DVec3;

/// A knot of an axis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Knot {
    pub position: DVec3,
    pub radius: f64,
}

/// A chain of knots.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Axis {
    pub knots: Vec<Knot>,
    /// Radius of the wood it grows out of; `None` when it stands on the ground.
    pub parent_radius: Option<f64>,
}

/// Share of a tip's radius at its very end.
const TIP: f64 = 0.6;

/// All axes of the skeleton, in the order of their first segment.
pub(super) fn axes(skeleton: &Skeleton) -> Vec<Axis> {
    let children = skeleton.children();
    let next: Vec<Option<u32>> =
        (0..children.len()).map(|number| successor(skeleton, number, &children[number])).collect();
    let mut goes_on = vec![false; next.len()];
    next.iter().flatten().for_each(|&child| goes_on[child as usize] = true);
    let first = (0..next.len()).filter(|&number| !goes_on[number]);
    first.map(|number| follow(skeleton, number, &next)).collect()
}

/// The child that continues the segment's axis.
fn successor(skeleton: &Skeleton, number: usize, children: &[u32]) -> Option<u32> {
    let segment = &skeleton.segments[number];
    let connected = |child: &&u32| (skeleton.segments[**child as usize].start - segment.end).norm() < 1e-9;
    let same = children.iter().filter(connected).find(|&&child| skeleton.segments[child as usize].axis == segment.axis);
    let merit = |child: u32| {
        let child = &skeleton.segments[child as usize];
        child.radius * (1.0 + child.direction().dot(&segment.direction()))
    };
    let forward = |child: &&u32| skeleton.segments[**child as usize].direction().dot(&segment.direction()) > 0.3;
    let best = children.iter().filter(connected).filter(forward).max_by(|a, b| merit(**a).total_cmp(&merit(**b)));
    same.or(best).copied()
}

fn follow(skeleton: &Skeleton, first: usize, next: &[Option<u32>]) -> Axis {
    let start = &skeleton.segments[first];
    let mut knots = vec![Knot { position: start.start, radius: start.radius }];
    let mut at = first;
    while let Some(child) = next[at] {
        let radius = skeleton.segments[child as usize].radius;
        knots.push(Knot { position: skeleton.segments[at].end, radius });
        at = child as usize;
    }
    let last = &skeleton.segments[at];
    knots.push(Knot { position: last.end, radius: last.radius * TIP });
    let parent_radius = start.parent.map(|parent| skeleton.segments[parent as usize].radius);
    Axis { knots, parent_radius }
}
