//! What the gusts of the days after its landing do to a leaf: dry litter is rolled along until a tuft stops it.
//!
//! Each day has one spell of gusts that is strong enough, of a strength by chance (exponential, as hours' variances are in
//! `wind`), towards where the wind of that day blows; each leaf finds its next tuft after a way by chance (exponential: tufts
//! lie at random), a little aside of the wind. After some days a leaf lies wet and matted and stays. The density about a
//! crown thus ends gradually and with an exponential tail, and every leaf stays counted.

use super::{DAY, Fallen, Wind};
use crate::base::maths::sincos;
use crate::base::random::{Purpose, Stream};
use crate::base::vector::DVec2;

/// Days until litter is matted.
const LOOSE: u64 = 4;
/// Mean way to the next tuft over the mean speed of the wind, seconds, and the longest mean way, metres (judged: half a metre in
/// the lightest air).
const ROLLS: f64 = 2.0;
const LONGEST: f64 = 6.0;
/// Standard deviation of a leaf's way about the wind's, radians.
const ASIDE: f64 = 0.9;

impl Wind {
    /// How far a leaf drifts on the ground, along x and z, metres.
    #[must_use]
    pub fn drifted(&self, seed: u64, leaf: &Fallen) -> DVec2 {
        let mean = (ROLLS * self.speed()).min(LONGEST);
        if mean <= 0.0 {
            return DVec2::zeros();
        }
        let mut own = Stream::new(seed, Purpose::Litter, leaf.leaf, leaf.year ^ 1 << 62);
        let first = leaf.day.floor();
        (0..LOOSE).fold(DVec2::zeros(), |sum, later| {
            let day = first + later as f64;
            let strength = Stream::new(seed, Purpose::Gust, day as i64 as u64, 3).exponential();
            let towards = self.direction((day + 0.5) * DAY);
            let (sine, cosine) = sincos(ASIDE * own.normal());
            let turned = DVec2::new(towards.x * cosine - towards.y * sine, towards.x * sine + towards.y * cosine);
            sum + turned * (mean * strength * own.exponential())
        })
    }
}

#[cfg(test)]
mod tests {
    use super::super::Settings;
    use super::super::tests::leaf;
    use super::*;

    /// Mean and root mean square of the drifts of a month's leaves.
    fn drifts(settings: &Settings) -> (DVec2, f64) {
        let wind = Wind::new(settings, 5);
        let all: Vec<DVec2> = (0..4000).map(|id| wind.drifted(5, &leaf(id, 5.0))).collect();
        let count = all.len() as f64;
        (all.iter().sum::<DVec2>() / count, (all.iter().map(DVec2::norm_squared).sum::<f64>() / count).sqrt())
    }

    #[test]
    fn drifts_grow_with_the_wind_and_days_of_all_directions_cancel() {
        let with = |wind: f64| drifts(&Settings { wind, ..Settings::default() });
        let ((_, still), (mean, light), (_, double)) = (with(0.0), with(0.3), with(0.6));
        assert_eq!(still, 0.0);
        // Products of two exponential numbers of mean 1 have the mean square 4.
        let expected = 0.3 * ROLLS * 2.0 * (LOOSE as f64).sqrt();
        assert!((0.5..1.6).contains(&(light / expected)), "{light} {expected}");
        assert!((double / light - 2.0).abs() < 1e-9 && mean.norm() < 0.5 * light, "{mean} {light} {double}");
    }

    #[test]
    fn a_wind_of_one_direction_drifts_litter_its_way() {
        let (mean, _) = drifts(&Settings { direction: Some(0.0), ..Settings::default() });
        assert!(mean.x > 0.5 && mean.y.abs() < 0.15 * mean.x, "{mean}");
    }
}
