//! Radii of the segments: as the rules set them by `!`, or by the pipe model (Shinozaki et al. 1964; exponent after Murray
//! 1926 and Leonardo): a segment's radius to the power n is the sum over its children.

use super::skeleton::Skeleton;
use crate::base::maths::pow;

/// Sets every radius by the pipe model; tips have `tip` (metres).
pub(super) fn pipe_model(skeleton: &mut Skeleton, exponent: f64, tip: f64) {
    let mut sums = vec![0.0f64; skeleton.segments.len()];
    let unit = pow(tip, exponent);
    for number in (0..skeleton.segments.len()).rev() {
        let sum = if sums[number] > 0.0 { sums[number] } else { unit };
        let segment = &mut skeleton.segments[number];
        segment.radius = pow(sum, 1.0 / exponent).max(tip);
        if let Some(parent) = segment.parent {
            sums[parent as usize] += sum;
        }
    }
}

/// Keeps radii that the rules have set, but lets none exceed its parent's; where none was set, `least` (metres) stands.
pub(super) fn as_set(skeleton: &mut Skeleton, least: f64) {
    for number in 0..skeleton.segments.len() {
        let bound = skeleton.segments[number].parent.map(|parent| skeleton.segments[parent as usize].radius);
        let segment = &mut skeleton.segments[number];
        let wanted = if segment.radius > 0.0 { segment.radius } else { least };
        segment.radius = bound.map_or(wanted, |bound| wanted.min(bound));
    }
}
