//! Where a leaf that has landed comes to rest.
//!
//! Wind sorts litter: what lies on a bald spot is blown into the next lee. Each leaf slides by the gradient of a potential
//! that is smooth over half a metre and two metres, x -> x + grad phi(x): the map by which Zel'dovich (1970) gathers
//! evenly spread matter into sheets and knots. The same map holds for every leaf, so leaves that land close stay close.

use super::heights::HeightMap;
use crate::base::noise::Lattice;
use crate::base::random::hash;
use crate::base::vector::DVec2;
use std::sync::Arc;

/// Lengths over which drifts vary, metres, and how far leaves slide over each of them (root mean square over the length).
const WAVES: [(f64, f64); 2] = [(2.1, 0.115), (0.55, 0.10)];
/// Distance of the points between which a gradient is taken, in wavelengths.
const STEP: f64 = 0.05;
/// Metres about a trunk's foot that leaves are pushed out of it within.
const SKIRT: f64 = 0.35;
/// Steepest slope on which litter stays, metres a metre: the angle of repose of heaps of leaves is about 40 to 45 degrees (judged;
/// most loose matter rests below 45).
const STEEPEST: f64 = 1.0;
/// What slides rests on slopes between this share of the steepest and the steepest.
const GENTLEST: f64 = 0.7;
/// Most steps of a slide, each of this share of a square of the map.
const MOST_SLIDES: u32 = 2048;
const SLIDE: f64 = 0.5;
/// Share of the drifts that still air leaves, and the wind that makes all of them, m/s.
const STILL: f64 = 0.45;
const DRIFTING: f64 = 1.0;

/// The foot of a trunk.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Trunk {
    /// Its middle, along x and z, metres.
    pub place: DVec2,
    /// Its radius at the ground, metres.
    pub radius: f64,
}

/// What leaves lie on.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Ground {
    /// The trunks that stand in it.
    pub trunks: Vec<Trunk>,
    /// Heights over a grid of squares; level at 0 without one.
    pub heights: Option<Arc<HeightMap>>,
}

impl Ground {
    /// Height at a place (x, z), metres.
    #[must_use]
    pub fn height(&self, place: DVec2) -> f64 {
        self.heights.as_ref().map_or(0.0, |map| map.at(place))
    }

    /// Where a leaf that has landed comes to rest, for a wind in m/s.
    #[must_use]
    pub fn rest(&self, seed: u64, wind: f64, landed: DVec2) -> DVec2 {
        let strength = STILL + (1.0 - STILL) * (wind / DRIFTING).min(1.0);
        let slid = landed + slide(seed, landed) * strength;
        let slid = self.heights.as_ref().map_or(slid, |map| off_slopes(map, slid));
        self.trunks.iter().fold(slid, |place, trunk| pushed(trunk, place))
    }

    /// Whether a place lies within `radius` metres of a trunk's middle.
    #[must_use]
    pub fn is_raked(&self, place: DVec2, radius: f64) -> bool {
        radius > 0.0 && self.trunks.iter().any(|trunk| (place - trunk.place).norm() < radius)
    }
}

/// The slide of a leaf by the gradient of the potential, metres.
fn slide(seed: u64, place: DVec2) -> DVec2 {
    let mut sum = DVec2::zeros();
    for (number, (length, share)) in WAVES.into_iter().enumerate() {
        let lattice = Lattice::new(hash(seed, 0xd41f + number as u64));
        let at =
            |x: f64, y: f64| f64::from(lattice.gradient((place.x / length + x) as f32, (place.y / length + y) as f32));
        let gradient = DVec2::new(at(STEP, 0.0) - at(-STEP, 0.0), at(0.0, STEP) - at(0.0, -STEP)) / (2.0 * STEP);
        sum += gradient * (share * length);
    }
    sum
}

/// Down from slopes that are too steep for litter to lie on. What slides comes to rest on different slopes, by chance: here by
/// where it set out, so that it lies in a band at their feet and not in a line.
fn off_slopes(map: &HeightMap, place: DVec2) -> DVec2 {
    let slope = |place: DVec2| {
        let normal = map.normal(place);
        DVec2::new(-normal.x, -normal.z) / normal.y
    };
    if slope(place).norm_squared() <= STEEPEST * STEEPEST {
        return place;
    }
    let chance = (hash(place.x.to_bits(), place.y.to_bits()) >> 40) as f64 / (1u64 << 24) as f64;
    let rests_on = STEEPEST * (1.0 - (1.0 - GENTLEST) * chance);
    let mut at = place;
    for _ in 0..MOST_SLIDES {
        let rise = slope(at);
        let steepness = rise.norm();
        if steepness <= rests_on {
            break;
        }
        let next = at - rise * (SLIDE * map.step / steepness);
        // The bottom of a gully between steep sides.
        if map.at(next) >= map.at(at) {
            break;
        }
        at = next;
    }
    at
}

/// Out of a trunk: distances of 0 to R become r to R, so leaves gather about its foot and none lies within it.
fn pushed(trunk: &Trunk, place: DVec2) -> DVec2 {
    let away = place - trunk.place;
    let (distance, reach) = (away.norm(), trunk.radius + SKIRT);
    if distance >= reach {
        return place;
    }
    let direction = away.try_normalize(1e-9).unwrap_or_else(DVec2::x);
    trunk.place + direction * (trunk.radius + distance * (1.0 - trunk.radius / reach))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_leaf_rests_in_a_trunk_and_far_ones_do_not_notice_it() {
        let trunk = Trunk { place: DVec2::new(1.0, 2.0), radius: 0.2 };
        let ground = Ground { trunks: vec![trunk], heights: None };
        for number in 0..400 {
            let (row, column) = (f64::from(number / 20), f64::from(number % 20));
            let landed = trunk.place + DVec2::new(column - 9.5, row - 9.5) * 0.05;
            assert!((ground.rest(3, 0.5, landed) - trunk.place).norm() >= trunk.radius);
        }
        let far = DVec2::new(9.0, 9.0);
        assert_eq!(ground.rest(3, 0.5, far), Ground::default().rest(3, 0.5, far));
        assert!(ground.is_raked(trunk.place, 0.5) && !ground.is_raked(far, 0.5) && !ground.is_raked(trunk.place, 0.0));
    }

    #[test]
    fn no_litter_stays_on_slopes_over_forty_five_degrees() {
        // a bank 8 m high that is half as wide, between level ground above and below
        let rows: Vec<Vec<f64>> = (0..6).map(|_| vec![0.0, 0.0, 0.0, 8.0, 8.0, 8.0]).collect();
        let map = HeightMap::smoothed(&rows, 4.0).unwrap();
        let ground = Ground { trunks: Vec::new(), heights: Some(Arc::new(map.clone())) };
        let (mut slid, mut stayed) = (0, 0);
        for number in 0..400 {
            let landed = DVec2::new(-6.0 + 0.03 * f64::from(number), 0.0);
            let (rest, level) = (ground.rest(3, 0.3, landed), Ground::default().rest(3, 0.3, landed));
            let normal = map.normal(rest);
            assert!(normal.y >= 0.5f64.sqrt() - 1e-9, "{landed} {rest}");
            stayed += u32::from(rest == level);
            slid += u32::from(map.at(rest) < map.at(level) - 1.0);
        }
        assert!(slid > 40 && stayed > 200, "{slid} {stayed}");
    }

    #[test]
    fn litter_gathers_more_in_wind() {
        // Counts of an even lattice after the slide: their variance over the mean tells drifts from an even cover.
        let clumped = |wind: f64| {
            let mut counts = vec![0.0f64; 400];
            for number in 0..40_000 {
                let even = DVec2::new(f64::from(number % 200), f64::from(number / 200)) * 0.05;
                let rest = Ground::default().rest(7, wind, even);
                let cell = (rest.y / 0.5).floor() * 20.0 + (rest.x / 0.5).floor();
                if (0.0..10.0).contains(&rest.x) && (0.0..10.0).contains(&rest.y) {
                    counts[cell as usize] += 1.0;
                }
            }
            let mean = counts.iter().sum::<f64>() / 400.0;
            counts.iter().map(|count| (count - mean) * (count - mean)).sum::<f64>() / 400.0 / (mean * mean)
        };
        let (still, windy) = (clumped(0.0), clumped(1.0));
        assert!(windy > 0.05 && windy > 2.0 * still && still > 0.002, "{still} {windy}");
    }
}
