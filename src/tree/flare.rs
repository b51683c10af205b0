//! The foot of a trunk: it swells towards the ground, and the thicker it is the more it runs out into buttresses.

use super::path::Ring;
use crate::base::maths::{cos, exp, sin};
use crate::base::random::hash_unit;
use std::f64::consts::TAU;

/// Swelling at the ground of a young and of an old trunk, in radii.
const SWELL: [f64; 2] = [0.28, 0.55];
/// Depth of the buttresses at the ground of a young and of an old trunk, in radii.
const LOBES: [f64; 2] = [0.07, 0.34];
/// Radii of a young and of an old trunk, metres.
const AGES: [f64; 2] = [0.04, 0.35];
/// Waves of the buttresses around the trunk with their weights.
const WAVES: [(f64, f64); 3] = [(2.0, 0.22), (4.0, 0.42), (7.0, 0.36)];
/// Heights over which swelling and buttresses fall to 1/e, in radii: swelling, buttresses, and the flutes above them.
const HEIGHTS: [f64; 3] = [1.1, 1.7, 8.0];
/// Share of the buttresses that goes on as flutes.
const FLUTES: f64 = 0.08;

/// The foot of one trunk.
pub(super) struct Flare {
    ground: f64,
    radius: f64,
    swell: f64,
    lobes: f64,
    phases: [f64; 3],
}

impl Flare {
    /// The foot of the trunk of this id, whose first ring on the ground is given.
    pub(super) fn new(id: u64, foot: &Ring) -> Self {
        let age = ((foot.radius - AGES[0]) / (AGES[1] - AGES[0])).clamp(0.0, 1.0);
        let between = |ends: [f64; 2]| ends[0] + (ends[1] - ends[0]) * age;
        let phases = [0, 1, 2].map(|wave| TAU * f64::from(hash_unit(id, 0xF1A5 + wave)));
        Self { ground: foot.centre.y, radius: foot.radius, swell: between(SWELL), lobes: between(LOBES), phases }
    }

    /// Factor on the radius, its derivative by the angle, and by the height (1/m).
    pub(super) fn factor(&self, ring: &Ring, angle: f64) -> (f64, f64, f64) {
        let height = ((ring.centre.y - self.ground) / self.radius).max(-0.6);
        let [swelling, root, flute] = HEIGHTS.map(|scale| exp(-height / scale));
        let (mut wave, mut turn) = (0.0, 0.0);
        for (&(count, weight), phase) in WAVES.iter().zip(self.phases) {
            wave += weight * cos(count * angle + phase);
            turn -= weight * count * sin(count * angle + phase);
        }
        let lobes = self.lobes * (root * (1.0 - FLUTES) + flute * FLUTES);
        let rise = self.swell * swelling / HEIGHTS[0]
            + self.lobes * wave * (root * (1.0 - FLUTES) / HEIGHTS[1] + flute * FLUTES / HEIGHTS[2]);
        (1.0 + self.swell * swelling + lobes * wave, lobes * turn, -rise / self.radius)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::base::vector::DVec3;

    fn ring(radius: f64, height: f64) -> Ring {
        let (tangent, side) = (DVec3::y(), DVec3::x());
        Ring { centre: DVec3::y() * height, tangent, side, radius, slope: 0.0, length: height }
    }

    /// Largest over smallest factor at the ground.
    fn roundness(radius: f64) -> f64 {
        let flare = Flare::new(7, &ring(radius, 0.0));
        let factors = (0..360).map(|degree| flare.factor(&ring(radius, 0.0), f64::from(degree).to_radians()).0);
        let (low, high) = factors.fold((f64::INFINITY, 0.0f64), |(low, high), f| (low.min(f), high.max(f)));
        high / low
    }

    #[test]
    fn old_trunks_have_buttresses_and_young_ones_hardly() {
        assert!(roundness(0.03) < 1.15 && roundness(0.4) > 1.3, "{} {}", roundness(0.03), roundness(0.4));
    }

    #[test]
    fn the_derivatives_are_those_of_the_factor() {
        let flare = Flare::new(3, &ring(0.3, 0.0));
        for step in 0..40 {
            let (angle, height) = (0.157 * f64::from(step), 0.04 * f64::from(step));
            let (_, turn, rise) = flare.factor(&ring(0.3, height), angle);
            let at = |angle: f64, height: f64| flare.factor(&ring(0.3, height), angle).0;
            assert!((turn - (at(angle + 1e-5, height) - at(angle - 1e-5, height)) / 2e-5).abs() < 1e-6);
            let (low, high) = (at(angle, height), at(angle, height + 1e-5));
            assert!((rise - (high - low) / 1e-5).abs() < 1e-2);
        }
    }
}
