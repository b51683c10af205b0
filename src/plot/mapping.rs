//! From values to shares of an axis' length.

use super::Scale;
use crate::base::maths::ln;

/// How far beyond its ends an axis is followed, in lengths: far enough for a line's direction, near enough to be exact.
const BEYOND: f64 = 1.0e6;

/// An axis with its ends.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Mapping {
    pub(super) scale: Scale,
    /// The ends in the axis' unit, the lower first.
    pub(super) range: [f64; 2],
}

impl Mapping {
    /// The place of a value: 0 at the lower end, 1 at the upper. Nothing for what the axis cannot show.
    pub(super) fn share(&self, value: f64) -> Option<f64> {
        let [low, high] = self.range.map(|end| self.scaled(end));
        let share = (self.scaled(value) - low) / (high - low);
        share.is_finite().then(|| share.clamp(-BEYOND, BEYOND))
    }

    /// The value, or its decimal logarithm: what lengths are in proportion to. Not finite for what cannot be shown.
    pub(super) fn scaled(&self, value: f64) -> f64 {
        if self.scale == Scale::Log { log10(value) } else { value }
    }
}

/// The decimal logarithm; exact for 1.
pub(super) fn log10(value: f64) -> f64 {
    ln(value) / std::f64::consts::LN_10
}
