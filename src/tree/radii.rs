//! Radii of the segments: as the rules set them by `!`, or by the pipe model (Shinozaki et al. 1964; exponent after Murray
//! 1926 and Leonardo): a segment's radius to the power n is the sum over its children.

use super::Settings;
use super::skeleton::Skeleton;
use crate::base::maths::pow;

/// Sets every radius by the pipe model; tips have `tip` (metres). Shoots of a last year that is not over count by their share
/// of it, so that wood thickens steadily.
pub(super) fn pipe_model(skeleton: &mut Skeleton, tip: f64, settings: &Settings) {
    let exponent = settings.radius_exponent;
    let (youngest, last_year) = (settings.steps(), settings.last_year());
    let mut sums = vec![0.0f64; skeleton.segments.len()];
    let unit = pow(tip, exponent);
    for number in (0..skeleton.segments.len()).rev() {
        let segment = &mut skeleton.segments[number];
        let own = if segment.birth == youngest { unit * last_year } else { unit };
        let sum = sums[number].max(own);
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

#[cfg(test)]
mod tests {
    use super::super::grow;
    use super::*;
    use crate::base::limits::Limits;

    fn skeleton(rule: &str) -> Skeleton {
        let (axiom, rules) = ("A(3)".to_owned(), vec![rule.to_owned()]);
        let settings = Settings { axiom, rules, iterations: 6, radius_exponent: 2.3, ..Settings::default() };
        grow(&settings, 1, &Limits::default()).unwrap().0.skeleton
    }

    #[test]
    fn the_pipe_model_sums_and_never_grows_along_a_branch() {
        let skeleton = skeleton("A(w) -> F[+A(w)]F[-A(w)][&A(w)]A(w)");
        for (number, children) in skeleton.children().iter().enumerate() {
            let radius = skeleton.segments[number].radius;
            let children = children.iter().map(|&child| skeleton.segments[child as usize].radius);
            let sum: f64 = children.clone().map(|radius| pow(radius, 2.3)).sum();
            assert!(children.clone().all(|child| child <= radius));
            let wanted = if sum > 0.0 { pow(sum, 1.0 / 2.3) } else { 0.001 };
            assert!((radius - wanted).abs() < 1e-12);
        }
    }

    #[test]
    fn widths_that_would_grow_are_held() {
        let skeleton = skeleton("A(w) -> !(w)F[+A(w*2)]A(w*0.9)");
        for segment in &skeleton.segments {
            let bound = segment.parent.map_or(0.015, |parent| skeleton.segments[parent as usize].radius);
            assert!(segment.radius <= bound);
        }
        assert!((skeleton.segments[0].radius - 0.015).abs() < 1e-15);
    }
}
